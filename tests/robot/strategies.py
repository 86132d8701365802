"""Random bipeds for property-based tests."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from gaitopt.catalogue.biped_spec import BipedSpec, LinkSpec, biped13
from gaitopt.catalogue.parameters import changed

edges = st.floats(0.01, 2.0)
offsets = st.floats(-1.0, 1.0)
vectors = st.tuples(offsets, offsets, offsets)


@st.composite
def inertias(draw: st.DrawFn) -> tuple[tuple[float, ...], ...]:
    """Inertia of three unequal point masses and a ball: full, and certainly physical."""
    matrix = np.eye(3) * draw(st.floats(0.01, 1.0))
    for _ in range(3):
        x = np.array(draw(vectors))
        matrix += draw(st.floats(0.1, 5.0)) * (x @ x * np.eye(3) - np.outer(x, x))
    return tuple(tuple(float(entry) for entry in row) for row in (matrix + matrix.T) / 2.0)


@st.composite
def link_specs(draw: st.DrawFn) -> LinkSpec:
    """A link with a box's inertia or with its own."""
    return LinkSpec(
        mass=draw(st.floats(0.01, 100.0)),
        size=draw(st.tuples(edges, edges, edges)),
        com=draw(vectors),
        inertia=draw(st.none() | inertias()),
    )


@st.composite
def biped_specs(draw: st.DrawFn) -> BipedSpec:
    """A biped in which no two numbers need agree with the preset's."""
    spec = biped13()
    length = draw(st.floats(0.05, 0.5))
    changes = {f"geometry.{key}": draw(edges) for key in ("d1", "d3", "d4", "d7", "foot_width")}
    changes |= {"geometry.foot_length": length, "geometry.l4": draw(offsets)}
    changes["geometry.l1"] = -length * draw(st.floats(0.0, 1.0))
    for name, _ in spec.links.named():
        changes[f"links.{name}"] = _fields(draw(link_specs()))
    for name, _ in spec.joints.named():
        changes[f"joints.{name}.torque"] = draw(st.floats(1.0, 500.0))
        changes[f"joints.{name}.lower"] = draw(st.floats(-3.0, -0.1))
        changes[f"joints.{name}.upper"] = draw(st.floats(0.0, 3.0))
    return changed(spec, changes)


def _fields(link: LinkSpec) -> dict[str, object]:
    return {"mass": link.mass, "size": link.size, "com": link.com, "inertia": link.inertia}
