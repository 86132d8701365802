"""What a gait or a transition records about itself, its robot and the ground under it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import field

import numpy as np

from gaitopt.actuators.linkages import linkages_from_rows
from gaitopt.bounds import NUMBER, must_be
from gaitopt.dataclass import dataclass
from gaitopt.errors import GaitFileError, GaitoptError, RobotError
from gaitopt.escape import printable
from gaitopt.gait.motor_space import DrivenJoints, MotorSpace, joints_of_linkages
from gaitopt.gait.trajectory import Trajectory
from gaitopt.importers.physics import PARTS
from gaitopt.importers.report import findings_of
from gaitopt.model.import_options import ImportOptions, choices_from_record
from gaitopt.model.robot import Robot
from gaitopt.model.sole import LEVEL, Sole
from gaitopt.nlp import Array

_LEG_JOINTS = 6  # of each leg of gaits that do not record it


class Recorded:
    """What moves a robot and has a record: a gait, or a transition.

    Attributes:
        joint_names, mirror, urdf, stance_sole, swing_sole_frame, meta: as of a gait.
        trajectory: the motion as a function of time.
    """

    joint_names: tuple[str, ...]
    mirror: Array
    urdf: str
    stance_sole: str
    swing_sole_frame: str
    meta: Mapping[str, object]
    trajectory: Trajectory

    def fact(self, *keys: str) -> object | None:
        """Return `meta[key][key]...`, None if any of the keys is absent."""
        value: object | None = self.meta
        for key in keys:
            value = value.get(key) if isinstance(value, Mapping) else None
        return value

    @property
    def certified(self) -> bool:
        """Whether its record says that it is proven."""
        return self.fact("certificate", "certified") is True

    def number(self, *keys: str) -> float | None:
        """Return a number of `meta`, None if it is absent or not a number."""
        value = self.fact(*keys)
        return float(value) if is_number(value) else None  # type: ignore[arg-type]

    def text(self, *keys: str) -> str | None:
        """Return a text of `meta`, None if it is absent or not a text."""
        value = self.fact(*keys)
        return value if isinstance(value, str) else None

    @property
    def leg_joints(self) -> int:
        """Number of joints of each leg, the first of `joint_names`; six if it is not recorded."""
        return int(self.number("leg_joints") or _LEG_JOINTS)

    def joint_limit(self, kind: str) -> Array | None:
        """Return `meta["limits"][kind]`, shape (J,), None if it is absent or no list of numbers.

        Args:
            kind: "torque" [N·m], "speed" [rad/s], "lower" or "upper" [rad].
        """
        value = self.fact("limits", kind)
        if not isinstance(value, list) or len(value) != len(self.joint_names):
            return None
        if not all(v is None or is_number(v) for v in value):
            return None
        return np.array([np.nan if v is None else v for v in value], dtype=np.float64)


def is_number(value: object) -> bool:
    """Whether a value of JSON is a number whose square has a value."""
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and -NUMBER <= value <= NUMBER
    )


def recorded_choices(gait: Recorded) -> ImportOptions:
    """Return what was chosen about a gait's robot; nothing for a gait that does not record it.

    Raises:
        RobotError: the record cannot be read.
    """
    record = gait.fact("choices")
    return choices_from_record(record) if isinstance(record, Mapping) else ImportOptions()


def robot_of(gait: Recorded) -> Robot:
    """Return the robot a gait was designed for, on the ground that it walks on.

    Raises:
        GaitFileError: neither the choices about it nor its sole are recorded.
        RobotError: the URDF is not a biped, or the choices do not fit it.
    """
    choices = gait.fact("choices")
    if isinstance(choices, Mapping):
        robot = Robot.from_urdf(gait.urdf, choices=_of_its_time(gait, choices_from_record(choices)))
        robot = robot.as_before(findings_of(gait.fact("findings")))
        return robot.on_ground(ground_of(gait).down)
    edges = {name: gait.number("sole", name) for name in ("toe", "heel", "left", "right")}
    missing = [name for name, value in edges.items() if value is None]
    if missing:
        raise GaitFileError(
            f"the gait does not record the {missing[0]} edge of the sole in its 'meta'; "
            "was it designed by gaitopt?"
        )
    sole = Sole(**{name: value for name, value in edges.items() if value is not None})
    return Robot.from_urdf(
        gait.urdf, stance_sole=gait.stance_sole, swing_sole=gait.swing_sole_frame, sole=sole
    )


def recorded_linkages(gait: Recorded) -> list[DrivenJoints]:
    """Return the joints that motors turn through linkages, of the robot's file and of its task.

    Both legs stand one after the other for each linkage. None of a gait whose records are damaged.
    """
    constraints = gait.fact("task", "constraints")
    with suppress(GaitoptError):
        own = robot_of(gait).linkages if any(tag in gait.urdf for tag in _LOOPS) else ()
        for record in constraints if isinstance(constraints, list) else ():
            fields = record.get("fields") if isinstance(record, Mapping) else None
            if isinstance(fields, Mapping) and record.get("name") == MotorSpace.name:
                own = (*own, *linkages_from_rows(fields.get("linkages")))
        return joints_of_linkages(gait.joint_names, gait.mirror, gait.trajectory.body, own)
    return []


def _of_its_time(gait: Recorded, choices: ImportOptions) -> ImportOptions:
    """Return the choices; a gait of version 0.1 counted nothing but rotor inertias."""
    if gait.fact("physics") is not None:
        return choices
    return choices.over(without=tuple(part for part in PARTS if part != "armature"))


def drawn_robot(gait: Recorded) -> Robot:
    """Return the robot of a gait of format 1 or made by hand; what it does not record is found.

    Raises:
        RobotError: the URDF is not a biped, or not one with the gait's joints and sole frames.
    """
    try:
        robot = _robot_or_found(gait)
    except RobotError as error:
        raise RobotError(f"the gait's URDF cannot be read: {error}") from error
    for name in set(gait.joint_names) - set(robot.joint_names):
        raise RobotError(f"the gait's URDF has no joint '{name}', which the gait moves")
    return robot


def _robot_or_found(gait: Recorded) -> Robot:
    try:
        return robot_of(gait)
    except GaitFileError:
        return Robot.from_urdf(
            gait.urdf, stance_sole=gait.stance_sole, swing_sole=gait.swing_sole_frame
        )


_LONGEST = 80  # characters of words
_LOOPS = ("<connect", "<weld")  # in the text of a robot with loops of bodies
_MOST = 1000  # points of an outline


def must_be_gait(gait: object, kind: type | tuple[type, ...] = Recorded) -> None:
    """Refuse what is given in place of a gait, as the design that holds it or the name of its file.

    Raises:
        OptionError: it is none.
    """
    must_be(gait, kind, "the gait", "a Gait: load_gait('walk.npz'), or .gait of a Design")


@dataclass(frozen=True)
class Ground:
    """The ground of a gait.

    Attributes:
        words: what a person calls it, empty for level ground.
        down: direction of gravity in its axes, those of the stance sole; of unit length.
        rise: of the next footprint over this one [m].
        outline: points (x, z) of the ground of one step [m], shape (m, 2); none of a plane.
    """

    words: str = ""
    down: tuple[float, float, float] = LEVEL
    rise: float = 0.0
    outline: Array = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def shaped(self) -> bool:
        """Whether it is no plane."""
        return len(self.outline) > 0

    def along(self, first: int, last: int, step: float) -> Array:
        """Return its points from one step to another before the next [m], shape (m, 2).

        Args:
            first, last: numbers of the steps; the stance foot stands in step 0.
            step: length of a step [m].
        """
        one = self.outline if self.shaped else np.zeros((1, 2))
        return np.concatenate([one + k * np.array([step, self.rise]) for k in range(first, last)])


def ground_of(gait: Recorded) -> Ground:
    """Return the ground that a gait walks on; level where it records none, or nonsense."""
    down, outline = gait.fact("ground", "down"), gait.fact("ground", "outline")
    points = _rows(outline, 2)
    axes = _rows([down], 3)
    direction = axes[0] if len(axes) else np.zeros(3)
    length = float(np.linalg.norm(direction))
    x, y, z = direction / length if length > 0.0 else LEVEL
    return Ground(
        printable((gait.text("ground", "words") or "")[:_LONGEST]),
        (float(x), float(y), float(z)),
        gait.number("ground", "rise") or 0.0,
        points,
    )


def _rows(value: object, width: int) -> Array:
    """Return lists of numbers as rows (m, width); none if they are not that."""
    rows = value if isinstance(value, list) else []
    if len(rows) > _MOST or not all(
        isinstance(row, list) and len(row) == width and all(map(is_number, row)) for row in rows
    ):
        rows = []
    return np.array(rows, dtype=np.float64).reshape(-1, width)
