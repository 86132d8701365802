"""What a set of gaits requires of each motor: torque, speed, power and how they go together.

A motor serves its joint in the stance leg in one step and in the swing leg in the next, and the
motor of the mirrored joint does the same one step later: a requirement is that of one motor over a
whole stride, two steps.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from operator import attrgetter

import numpy as np

from gaitopt.actuators.motors import Drive, MotorTable
from gaitopt.dataclass import dataclass
from gaitopt.design.summary import linkage_motors, named_groups, trapezoid
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments

INSTANTS = 401
"""Of each step, beside its samples and the knots, where accelerations have their corners."""
_END = 1e-9  # of a step: instants this near to its end are its end
_LOADED = 0.5  # of the peak torque, above which a motor counts as loaded


@dataclass(frozen=True, eq=False)
class MotorLoop:
    """Torque and speed of one motor over a stride.

    Attributes:
        motor: the name that the joints of both sides share.
        joint: one of these joints.
        time: from 0 to the end of the second step [s], shape (N,).
        torque: of the motor [N·m], shape (N,); its force [N] if it slides.
        rate: [rad/s; m/s], shape (N,).
        acceleration: [rad/s²; m/s²], shape (N,).
        torque_limit, speed_limit: of a motor of a linkage [N·m, rad/s; N, m/s]; None for none.
        slides: whether it is a linear motor.
    """

    motor: str
    joint: str
    time: Array
    torque: Array
    rate: Array
    acceleration: Array
    torque_limit: float | None = None
    speed_limit: float | None = None
    slides: bool = False

    @property
    def power(self) -> Array:
        """Mechanical power [W], shape (N,): above zero where the motor drives."""
        return self.torque * self.rate

    def drive(self, table: MotorTable) -> Drive | None:
        """Return motor and gear of a table, if it has them: it has none that slide."""
        return None if self.slides else table.drive(self.joint)

    def mean(self, values: Array) -> float:
        """Return the mean over the stride of values at `time`, shape (N,)."""
        return trapezoid(values, self.time) / float(self.time[-1])


@dataclass(frozen=True)
class Requirement:
    """What one motor must deliver in one gait, sizes without sign; in N and m/s if it slides.

    Attributes:
        motor: as of `MotorLoop`.
        gait: label of the gait.
        peak_torque: largest torque [N·m].
        speed_at_peak_torque: [rad/s].
        peak_speed: largest speed [rad/s].
        torque_at_peak_speed: [N·m].
        rms_torque: root of the mean square over the stride [N·m], which heats the motor.
        peak_power: largest power that the motor gives [W].
        regenerated_power: largest power that it takes back [W].
        duty: share of the time in which the torque is above half of its peak.
        slides: whether it is a linear motor.
    """

    motor: str
    gait: str
    peak_torque: float
    speed_at_peak_torque: float
    peak_speed: float
    torque_at_peak_speed: float
    rms_torque: float
    peak_power: float
    regenerated_power: float
    duty: float
    slides: bool = False


UNITS = {
    "peak_torque": "N·m",
    "speed_at_peak_torque": "rad/s",
    "peak_speed": "rad/s",
    "torque_at_peak_speed": "N·m",
    "rms_torque": "N·m",
    "peak_power": "W",
    "regenerated_power": "W",
    "duty": "",
}
"""Of the numbers of a `Requirement`; for motors that slide see `motion_words`."""
FIGURES = tuple(UNITS)
"""Their names."""

_DECIDING = {"speed_at_peak_torque": "peak_torque", "torque_at_peak_speed": "peak_speed"}
"""Figures that go with another one: they are of the gait in which that is largest."""


@dataclass(frozen=True)
class MotorUse:
    """What a gait asks of a motor before its gear, and which share of its limits that is.

    Attributes:
        motor: as of `MotorLoop`.
        gait: label of the gait.
        ratio: of the gear.
        peak_torque: largest torque of the motor, gear losses included [N·m].
        peak_share: of the torque at its peak current.
        rms_torque: root of the mean square over the stride [N·m].
        rms_share: of the torque at its continuous current.
        peak_speed: of the motor [rad/s].
        voltage_share: largest share of the supply's voltage, |torque / stall + speed / no-load|.
        copper_loss: mean over the stride [W].
    """

    motor: str
    gait: str
    ratio: float
    peak_torque: float
    peak_share: float
    rms_torque: float
    rms_share: float
    peak_speed: float
    voltage_share: float
    copper_loss: float


USES = {
    "ratio": "", "peak_torque": "N·m", "peak_share": "", "rms_torque": "N·m", "rms_share": "",
    "peak_speed": "rad/s", "voltage_share": "", "copper_loss": "W",
}  # fmt: skip
"""Units of the numbers of a `MotorUse`, by their names."""


@dataclass(frozen=True)
class MotorRequirement:
    """What one motor must deliver in a set of gaits.

    Attributes:
        motor: as of `MotorLoop`.
        values: by the names of `FIGURES` or `USES`, the largest over the gaits; speed at peak
            torque and torque at peak speed are of the gait that has the peak.
        gaits: label of the gait that decides each of them.
        slides: whether it is a linear motor.
    """

    motor: str
    values: Mapping[str, float]
    gaits: Mapping[str, str]
    slides: bool = False


@checked_arguments
def motor_loops(gait: Gait, table: MotorTable | None = None) -> list[MotorLoop]:
    """Return the loops of the joints of a side over a stride, legs from hip to ankle first.

    Of a stride of two steps that are no mirror images, over it and its mirror image: a motor must
    serve on both sides.

    Args:
        gait: of any robot; its splines are evaluated between its samples too.
        table: motors whose rotors are to be accelerated in place of those of the gait's robot.

    Raises:
        RobotError: the gait's URDF is not its robot.
        SpecError: the motors do not fit the joints.
    """
    return _of_joints(gait, *_stride(gait, table)[:2])


def own_motor_loops(gait: Gait, table: MotorTable | None = None) -> list[MotorLoop]:
    """Return the loops of the motors themselves: `motor_loops`, those of linkages for their joints.

    Raises:
        RobotError, SpecError: see `motor_loops`.
    """
    time, both, q = _stride(gait, table)
    linked = linkage_motors(gait)
    turned = {row for _, pair, _ in linked for group in pair for row in group.rows}
    loops = _of_joints(gait, time, both, turned)
    torque, rate, acceleration = both
    for name, (group, _), k in linked:
        linkage, of = group.linkage, group.values(torque, rate, q)
        loops.append(
            MotorLoop(
                name, linkage.motors[k], time, of["torque"][:, k], of["speed"][:, k],
                group.accelerations(rate, acceleration, q)[:, k], linkage.torque[k],
                linkage.speed[k], linkage.slides(k),
            )
        )  # fmt: skip
    return loops


def _of_joints(gait: Gait, time: Array, both: Array, but: Collection[int] = ()) -> list[MotorLoop]:
    """Return the loops of the joints of a side, but for some, from what `_stride` returns."""
    return [
        MotorLoop(name, gait.joint_names[group[0]], time, *both[:, :, group[0]])
        for name, group in named_groups(gait)
        if group[0] not in but
    ]


def _stride(gait: Gait, table: MotorTable | None) -> tuple[Array, Array, Array]:
    """Return instants (N,) of a stride; torques, rates, accelerations (3, N, J); angles (N, J)."""
    trajectory = gait.trajectory
    step = trajectory.step_duration
    known = [part for one in gait.steps for part in (one.knots, one.time)]
    inner = np.concatenate([np.linspace(0.0, step, INSTANTS), *known])
    inner = np.append(np.unique(inner[inner < step * (1.0 - _END)]), step)
    changes = [phase.begin for phase in gait.phases[1:]]  # torques jump there
    times = np.concatenate([inner, changes, changes])
    before = np.concatenate([inner == step, np.arange(2 * len(changes)) < len(changes)])
    order = np.lexsort((~before, times))
    columns = [trajectory.joint_names.index(name) for name in gait.joint_names]
    starts = step * np.arange(len(gait.steps))
    each = [trajectory.at(start + times[order], before=before[order]) for start in starts]
    first = np.concatenate(
        [np.stack([part[:, columns] for part in (at.torque, at.dq, at.ddq, at.q)]) for at in each],
        axis=1,
    )  # of a step, or of both of a stride
    if table is not None:
        table.check(gait.joint_names, gait.mirror)
        drives = [table.drive(name) for name in gait.joint_names]
        there = trajectory.body.armature[columns]
        own = [
            have if one is None else one.armature for one, have in zip(drives, there, strict=True)
        ]
        first[0] += (np.array(own) - there) * first[2]
    both = np.concatenate([first, first @ gait.mirror.T], axis=1)
    time = np.concatenate([start + times[order] for start in step * np.arange(2 * len(starts))])
    return time, both[:3], both[3]


def requirement(loop: MotorLoop, gait: str) -> Requirement:
    """Return what a motor must deliver in the gait of a label."""
    torque, rate, power = np.abs(loop.torque), np.abs(loop.rate), loop.power
    strongest, fastest = int(np.argmax(torque)), int(np.argmax(rate))
    return Requirement(
        motor=loop.motor,
        gait=gait,
        peak_torque=float(torque[strongest]),
        speed_at_peak_torque=float(rate[strongest]),
        peak_speed=float(rate[fastest]),
        torque_at_peak_speed=float(torque[fastest]),
        rms_torque=float(np.sqrt(loop.mean(torque**2))),
        peak_power=float(max(power.max(), 0.0)),
        regenerated_power=float(max(-power.min(), 0.0)),
        duty=loop.mean((torque > _LOADED * torque[strongest]).astype(float)),
        slides=loop.slides,
    )


@checked_arguments
def requirements(gaits: Mapping[str, Gait]) -> list[Requirement]:
    """Return what every motor must deliver in every gait, motor by motor.

    Args:
        gaits: by label, of robots with the same joints.

    Raises:
        InputError: there are no gaits, or their joints differ.
        RobotError: a gait's URDF is not its robot.
    """
    return requirements_of({label: own_motor_loops(gait) for label, gait in gaits.items()})


def requirements_of(loops: Mapping[str, Sequence[MotorLoop]]) -> list[Requirement]:
    """Return what every motor must deliver, given the loops of gaits by label.

    Raises:
        InputError: there are no gaits, or their motors differ.
    """
    if not loops:
        raise InputError("there is no gait to take requirements from; give one at least")
    (first, own), *others = ((label, [one.motor for one in of]) for label, of in loops.items())
    for label, motors in others:
        if motors != own:
            raise InputError(
                f"the gaits '{first}' and '{label}' move different joints ({', '.join(own)}; "
                f"{', '.join(motors)}); give gaits of one robot, or another design by --against"
            )
    return [requirement(of[k], label) for k in range(len(own)) for label, of in loops.items()]


def motor_use(loop: MotorLoop, gait: str, drive: Drive) -> MotorUse:
    """Return what a gait asks of a motor, and which share of its limits that is."""
    motor, able = drive.motor, drive.at_joint()
    torque = (np.abs(loop.torque) + drive.friction) / (drive.ratio * drive.efficiency)
    current = torque / motor.torque_constant
    rms = float(np.sqrt(loop.mean(torque**2)))
    voltage = np.abs(loop.torque / able.stall_torque + loop.rate / able.no_load_speed)
    return MotorUse(
        motor=loop.motor,
        gait=gait,
        ratio=drive.ratio,
        peak_torque=float(torque.max()),
        peak_share=float(current.max()) / motor.peak_current,
        rms_torque=rms,
        rms_share=rms / (motor.torque_constant * motor.continuous_current),
        peak_speed=drive.ratio * float(np.abs(loop.rate).max()),
        voltage_share=float(voltage.max()),
        copper_loss=motor.resistance * loop.mean(current**2),
    )


def motor_uses(loops: Mapping[str, Sequence[MotorLoop]], table: MotorTable) -> list[MotorUse]:
    """Return what every gait asks of every motor that the table has, motor by motor."""
    found = [
        (k, motor_use(loop, label, drive))
        for label, of in loops.items()
        for k, loop in enumerate(of)
        if (drive := loop.drive(table)) is not None
    ]
    return [use for _, use in sorted(found, key=lambda one: one[0])]


def worst_case(
    found: Iterable[Requirement | MotorUse], names: Iterable[str] = FIGURES
) -> list[MotorRequirement]:
    """Return for every motor the largest of each figure, and the gait that asks for it.

    Args:
        names: of the figures, `FIGURES` or `USES`.
    """
    by_motor: dict[str, list[Requirement | MotorUse]] = {}
    for one in found:
        by_motor.setdefault(one.motor, []).append(one)
    return [_worst(motor, of, tuple(names)) for motor, of in by_motor.items()]


def _worst(
    motor: str, of: Sequence[Requirement | MotorUse], names: Sequence[str]
) -> MotorRequirement:
    deciding = {name: max(of, key=attrgetter(_DECIDING.get(name, name))) for name in names}
    values = {name: float(getattr(one, name)) for name, one in deciding.items()}
    gaits = {name: one.gait for name, one in deciding.items()}
    slides = any(isinstance(one, Requirement) and one.slides for one in of)
    return MotorRequirement(motor, values, gaits, slides)
