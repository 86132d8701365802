"""The options that say which robot, and what not to guess about it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from gaitopt.cli.options import option

_ROBOT, _RESULT = "Robot", "Results"

RobotName = Annotated[
    str | None, option("--robot", "Name in the catalogue: gaitopt robots.", _ROBOT, "NAME")
]
UrdfFile = Annotated[Path | None, option("--urdf", "URDF or MJCF of any humanoid.", _ROBOT, "FILE")]
SpecFile = Annotated[
    Path | None,
    option("--spec", "Parameter table of a biped, TOML.", _ROBOT, "FILE"),
]
PackageDir = Annotated[
    list[Path] | None,
    option("--package-dir", "Directory with the packages of its meshes; repeatable.", _ROBOT,
            "DIR"),
]  # fmt: skip
ChoicesFile = Annotated[
    Path | None,
    option("--choices", "What not to guess about it, TOML: inspect --write-choices.", _ROBOT,
            "FILE"),
]  # fmt: skip
Forward = Annotated[
    str | None, option("--forward", "Where it looks: x, -x, y, ... of its root link.", _ROBOT,
                        "AXIS"),
]  # fmt: skip
Posture = Annotated[
    str | None, option("--posture", "Pose of the SRDF in which it stands.", _ROBOT, "NAME")
]
SrdfFile = Annotated[Path | None, option("--srdf", "SRDF with that pose.", _ROBOT, "FILE")]
SoleEdges = Annotated[
    str | None,
    option("--sole", "Rectangle in the sole frame: toe,heel,left,right.", _ROBOT, "M,M,M,M"),
]
StanceSole = Annotated[
    str | None, option("--stance-sole", "Frame of the standing sole.", _ROBOT, "FRAME")
]
SwingSole = Annotated[
    str | None, option("--swing-sole", "Frame of the other sole.", _ROBOT, "FRAME")
]

Without = Annotated[
    list[str] | None,
    option(
        "--without",
        "Physics of its file to leave out: friction, damping, springs, armature, "
        "gravity-compensation, gravity; a list with commas, or repeated.",
        _ROBOT,
        "PARTS",
    ),
]
Armature = Annotated[
    list[str] | None,
    option(
        "--armature",
        "Rotor inertia times gear ratio squared of the joints of that name, kg·m²: '*knee*=0.02'; "
        "repeatable.",
        _ROBOT,
        "PATTERN=VALUE",
    ),
]

RobotPage = Annotated[
    Path | None,
    option("--html", "Write a page with the robot standing and these tables.", _RESULT, "FILE"),
]
NewChoices = Annotated[
    Path | None,
    option("--write-choices", "Write what was found or guessed, to edit; then --choices FILE.",
            _RESULT, "FILE"),
]  # fmt: skip
