"""How far gaitopt gets with a robot: its description, what was found in it, or why it stops."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.report import Finding
from gaitopt.importers.source import Source, read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.importer import ImportedRobot, import_robot
from gaitopt.model.robot import Robot


@dataclass(frozen=True, eq=False)
class Inspection:
    """What is known about a robot; what could not be reached is None.

    Attributes:
        title: name of the robot, or of its file.
        origin: where the description is from.
        source: the description.
        model: the whole robot, its root on a free-flyer.
        reading: legs, heading and soles found in it.
        robot: as gaits are designed for.
        refusal: why it cannot be used, empty if it can.
    """

    title: str
    origin: str
    source: Source | None = None
    model: pin.Model | None = None
    reading: ImportedRobot | None = None
    robot: Robot | None = None
    refusal: str = ""

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was found, guessed and changed."""
        if self.robot is not None:
            return self.robot.findings
        return () if self.reading is None else self.reading.findings

    @property
    def choices(self) -> ImportOptions | None:
        """Every guess made explicit, None if not even the legs were found."""
        return None if self.reading is None else self.reading.choices


def inspect_robot(urdf: str | Path, choices: ImportOptions, origin: str = "") -> Inspection:
    """Read a robot as far as possible; whatever is wrong with it is part of the result.

    Args:
        urdf: path of a URDF or MJCF file, or its text.
        choices: what was chosen about it.
        origin: where it is from, by default the path.
    """
    origin = origin or (str(urdf) if isinstance(urdf, Path) else "made by gaitopt")
    source = model = reading = robot = None
    refusal = ""
    try:
        source = read_source(urdf, choices.package_dirs)
        model = source.model()
        reading = import_robot(source, choices)
        robot = Robot.from_reading(source, reading)
    except RobotError as error:
        refusal = str(error)
    title = Path(origin).name if model is None else str(model.name)
    return Inspection(title, origin, source, model, reading, robot, refusal)
