"""Robots of other makers, where the package that holds them is installed."""

from importlib import metadata
from pathlib import Path

import pytest

_INSIDE = "cmeel.prefix/share/example-robot-data/robots"


def _directory() -> Path | None:
    try:
        found = Path(str(metadata.distribution("example-robot-data").locate_file(_INSIDE)))
    except metadata.PackageNotFoundError:
        return None
    return found if found.is_dir() else None


DIRECTORY = _directory()

needs_example_robots = pytest.mark.skipif(
    DIRECTORY is None,
    reason="needs the robots of example-robot-data: pip install 'gaitopt[robots]'",
)

BIPEDS = (
    "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf",
    "bolt_description/robots/bolt.urdf",
    "g1_description/urdf/g1_29dof_rev_1_0.urdf",
    "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
    "human_description/robots/human.urdf",
    "icub_description/robots/icub.urdf",
    "icub_description/robots/icub_reduced.urdf",
    "romeo_description/urdf/romeo.urdf",
    "romeo_description/urdf/romeo_laas_small.urdf",
    "romeo_description/urdf/romeo_small.urdf",
    "simple_humanoid_description/urdf/simple_humanoid.urdf",
    "simple_humanoid_description/urdf/simple_humanoid_classical.urdf",
    "talos_data/robots/talos_full_v2.urdf",
    "talos_data/robots/talos_full_v2_box.urdf",
    "talos_data/robots/talos_reduced.urdf",
    "talos_data/robots/talos_reduced_box.urdf",
    "talos_data/robots/talos_reduced_corrected.urdf",
)
"""Every robot on two legs that the package holds as a URDF."""


def example_robot(path: str) -> Path:
    """Path of a robot; only for tests with the mark `needs_example_robots`."""
    assert DIRECTORY is not None
    return DIRECTORY / path
