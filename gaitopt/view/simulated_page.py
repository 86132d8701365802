"""The page of a simulated walk: beside the designed one, with its pushes, and what came of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from gaitopt.atomic import write_atomically
from gaitopt.bounds import STEPS, at_most
from gaitopt.escape import html_text
from gaitopt.gait.result import Gait
from gaitopt.mechanics.spatial import upright
from gaitopt.nlp import Array
from gaitopt.view.animation import PUSH, Replay, Scene, build_beside
from gaitopt.view.page import details, film, headline, page_of
from gaitopt.view.page_parts import Page, Section, table_text
from gaitopt.view.robot_shapes import RobotShapes
from gaitopt.view.viewer import Node, RecordingWindow, page_file

Record = dict[str, Any]
_PUSHED = f'<span class="mark" style="background:{PUSH}"></span> push, at the pelvis'


def write_simulated_page(
    gait: Gait,
    replays: Sequence[Replay],
    tables: Iterable[Section],
    path: str | Path,
    package_dirs: tuple[str, ...] = (),
) -> Path:
    """Write a page on which a robot walks as simulated, and a pale one beside it as designed.

    Args:
        gait: as designed.
        replays: what was simulated; buttons choose between them.
        tables: what was measured.
        path: the .html file.
        package_dirs: where to look for meshes named `package://...` in the URDF.

    Returns:
        The path written.

    Raises:
        InputError: there are too many steps, or the path cannot be written.
        RobotError: the robot cannot be drawn.
    """
    text = simulated_page(gait, replays, tables, package_dirs)
    return write_atomically(path, text.encode("utf-8"))


def simulated_page(
    gait: Gait,
    replays: Sequence[Replay],
    tables: Iterable[Section],
    package_dirs: tuple[str, ...] = (),
) -> Page:
    """Return the text of the page of `write_simulated_page`; a notebook shows it.

    Raises:
        InputError: there are too many steps.
        RobotError: the robot cannot be drawn.
    """
    steps = int(np.ceil(max(one.time[-1] for one in replays) / gait.duration))
    at_most(steps, STEPS, "steps on a page", "simulate fewer --steps")
    recorder = RecordingWindow()
    drawn: RobotShapes | None = None
    films: list[Record] = []
    first: Scene | None = None
    for replay in replays:
        window = recorder if drawn is None else RecordingWindow()
        viewer = Node(window)
        scene = build_beside(viewer, gait, replay, steps, package_dirs, drawn)
        drawn, first = scene.shapes, first or scene
        words = {"verdict": html_text(f"{replay.name}: {replay.ending}")}
        films.append({
            "name": replay.name, "motion": scene.motion, "words": words,
            "duration": replay.time[-1], "curves": replay_curves(gait, replay),
        })  # fmt: skip
    assert first is not None
    said = headline(gait, "designed")
    pushed = any(replay.pushes for replay in replays)
    words = {
        **said, **details(gait, first), **films[0]["words"],
        "title": f"{said['title']}, simulated", "span": "all of it",
        "right": "as simulated", "left": "as designed, pale in the picture",
        "tables": "".join(map(table_text, tables)),
    }  # fmt: skip
    words["standing"] += f"; {_PUSHED}" if pushed else ""
    data = {
        **film(gait, first, 1), "duration": replays[0].time[-1],
        "curves": films[0]["curves"], "films": films,
    }  # fmt: skip
    extra = {"@SLIDERS@": _buttons(films), "@WIRE@": page_file("replay.js")}
    return page_of(words, data, recorder.text(), extra)


def _buttons(films: Sequence[Record]) -> str:
    """Return a button for each walk, none where there is one alone."""
    if len(films) < 2:
        return ""
    names = "".join(f"<button>{html_text(one['name'])}</button>" for one in films)
    return f'<div id="replays" role="group" aria-label="what is shown">{names}</div>'


def replay_curves(gait: Gait, replay: Replay) -> Record:
    """Return curves of a walk beside those of the design, as `gaitopt.view.curves.curves` does."""
    body, times = gait.trajectory.body, replay.time
    designed = gait.trajectory.at(times).configuration
    both = (("simulated", "stance", replay.configuration), ("designed", "swing", designed))

    def panel(title: str, unit: str, values: Sequence[Array], joints: Sequence[str]) -> Record:
        lines = [
            {"name": name, "side": side, "y": y}
            for (name, side, _), y in zip(both, values, strict=True)
        ]
        return {"title": title, "unit": unit, "joints": joints, "limits": [], "lines": lines}

    bases = [configuration[:, :3] for _, _, configuration in both]
    tilts = [_tilt(gait, configuration) for _, _, configuration in both]
    climb = np.outer(times / times[-1], designed[-1, :3] - designed[0, :3])[:, 2]
    ahead = bases[0][:, 0] - bases[1][:, 0]
    trunk = [
        panel("base ahead of the design", "m", [ahead, np.zeros_like(ahead)], []),
        panel("base to the left", "m", [base[:, 1] for base in bases], []),
        panel("rise of the base", "m",
              [base[:, 2] - designed[0, 2] - climb for base in bases], []),
        panel("tilt of the base", "rad", tilts, []),
    ]  # fmt: skip
    joints = [
        panel(name, "rad", [c[:, 7 + row] for _, _, c in both], [name])
        for row, name in enumerate(body.joint_names)
        if row in body.moving
    ]
    return {
        "period": times[-1], "step": gait.duration, "time": times,
        "tabs": [{"name": "base", "panels": trunk}, {"name": "angle", "panels": joints}],
    }  # fmt: skip


def _tilt(gait: Gait, configurations: Array) -> Array:
    """Return by how much the base leans from where it is upright [rad], shape (N,)."""
    body = gait.trajectory.body
    up = upright(body.gravity).T @ np.array([0.0, 0.0, 1.0])
    own = body.heading[:, 2]
    turned = np.array([pin.Quaternion(q).matrix() @ own for q in configurations[:, 3:7]])
    return np.asarray(np.arccos(np.clip(turned @ up, -1.0, 1.0)))
