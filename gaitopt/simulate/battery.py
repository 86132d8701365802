"""A simulated walk disturbed: what it survives, and what in the gait a fall points to.

Success is success of this controller on this ground; speeds after a disturbance say whether the
robot walks on as designed or stumbles on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.design.walkability import (
    FRICTION,
    IMPULSE,
    LANDING,
    PRESSURE,
    RESERVE,
    TURNING,
    WeakPoint,
)
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.settings import checked
from gaitopt.simulate.disturbance import NONE, Disturbance, Push, SensorNoise, StartError
from gaitopt.simulate.walk import MakeController, SimulatedWalk, WalkOptions, simulate
from gaitopt.simulate.whole_body import whole_body_walks

STEPS = 15
"""Of a disturbed walk."""
START_STEPS = 8
STARTS = 20
PUSHED = 4  # step in which a push comes: the walk has settled
RECOVERED = 8  # steps that follow it
BISECTIONS = 6
HARDEST = 1.2  # m/s, impulse over mass: beyond it nobody stays on their feet
HALVED = 0.5  # of the designed speed: below, a robot no longer walks the gait


@checked
@dataclass(frozen=True)
class Check:
    """A disturbance with its name and what in a gait it tries.

    Attributes:
        name: in words.
        disturbance: that the controller is not told.
        tries: names of weak points (`walkability`) that a fall points to.
        friction: of the ground where it is another [-].
    """

    name: str
    disturbance: Disturbance
    tries: tuple[str, ...]
    friction: float | None = None


CHECKS = (
    Check("mass +5 %", Disturbance(mass=0.05), (RESERVE, PRESSURE)),
    Check("every second step 1 cm higher", Disturbance(ground=0.01), (RESERVE, LANDING, IMPULSE)),
    Check("friction 0.5", NONE, (FRICTION, TURNING), friction=0.5),
    Check("delay 5 ms", Disturbance(delay=0.005), (IMPULSE, PRESSURE, LANDING)),
)
"""Of every simulation."""
THOROUGH = (
    Check("mass -5 %", Disturbance(mass=-0.05), (RESERVE, PRESSURE)),
    Check("every second step 1 cm lower", Disturbance(ground=-0.01), (RESERVE, LANDING, IMPULSE)),
    Check("armature 0.01 kg·m² more", Disturbance(armature=0.01), (LANDING, IMPULSE)),
    Check("contacts of 20 ms", Disturbance(contact_time=0.02), (LANDING, IMPULSE)),
    Check("noise of sensors", Disturbance(noise=SensorNoise()), (PRESSURE, LANDING)),
)
"""Beside them with `--thorough`."""
START = Check("starts off the cycle", Disturbance(start=StartError()), (RESERVE, PRESSURE))


@dataclass(frozen=True, eq=False)
class Checked:
    """A check and the walk that it was.

    Attributes:
        check: what was tried.
        walk: the walk.
        passed: whether it went on, with half of the designed speed at least.
    """

    check: Check
    walk: SimulatedWalk
    passed: bool


@dataclass(frozen=True, eq=False)
class PushLimit:
    """The largest push of a direction that was survived.

    Attributes:
        direction: in words.
        impulse: of the push [N·s]; 0 if none was survived.
        over_mass: the same over the robot's mass [m/s].
        speed: of the last five steps after it [m/s].
        walk: after it; None if none was survived.
        unbounded: whether the hardest push that is tried was survived.
    """

    direction: str
    impulse: float
    over_mass: float
    speed: float
    walk: SimulatedWalk | None
    unbounded: bool


@dataclass(frozen=True, eq=False)
class Battery:
    """Everything that was tried on a gait.

    Attributes:
        checks: those of the default, then those of `--thorough`.
        pushes: forward, backward, to the swing and to the stance side; empty unless thorough.
        starts: walks from disturbed starts; empty unless thorough.
    """

    checks: tuple[Checked, ...]
    pushes: tuple[PushLimit, ...]
    starts: tuple[Checked, ...]

    @property
    def starts_walked(self) -> int:
        """Number of the starts from which all steps were walked."""
        return sum(start.passed for start in self.starts)


def battery(
    gait: Gait,
    options: WalkOptions | None = None,
    controller: MakeController | None = None,
    *,
    thorough: bool = False,
    on_progress: Callable[[str], None] | None = None,
) -> Battery:
    """Try a gait in disturbed walks.

    Args:
        gait: what to walk; undisturbed it should walk.
        options: ground of the walks; their numbers of steps are the battery's.
        thorough: whether to try everything; otherwise four checks.
        on_progress: called with the name of what is tried next.

    Raises:
        InputError: the gait cannot be simulated.
        RobotError: the gait has no robot of its own, and its URDF is not its robot.
    """
    options = replace(options or WalkOptions(), steps=STEPS)
    controller = controller or whole_body_walks()
    tell = on_progress or (lambda _: None)
    checks = []
    for check in (*CHECKS, *THOROUGH) if thorough else CHECKS:
        tell(check.name)
        checks.append(try_check(gait, check, options, controller))
    if not thorough:
        return Battery(tuple(checks), (), ())
    pushes = []
    for direction, along in directions(gait).items():
        tell(f"pushes {direction}")
        pushes.append(largest_push(gait, direction, along, options, controller))
    tell(f"{STARTS} starts")
    starts = tuple(_starts(gait, replace(options, steps=START_STEPS), controller))
    return Battery(tuple(checks), tuple(pushes), starts)


def try_check(
    gait: Gait, check: Check, options: WalkOptions, controller: MakeController | None = None
) -> Checked:
    """Walk a gait under one disturbance."""
    if check.friction is not None:
        options = replace(options, friction=check.friction)
    walk = simulate(gait, options, controller, check.disturbance)
    return Checked(check, walk, _goes_on(walk))


def _goes_on(walk: SimulatedWalk) -> bool:
    """Return whether a robot still walks the gait, not merely stays up."""
    if walk.in_place:
        return walk.walked
    return walk.walked and walk.last_speed / walk.designed_speed > HALVED


def directions(gait: Gait) -> dict[str, Array]:
    """Return unit vectors (3,) in the world by the name of the direction of a push."""
    trajectory = gait.trajectory
    stance, swing = trajectory.advance(PUSHED), trajectory.advance(PUSHED + 1)
    ahead = trajectory.advance(PUSHED - 1).rotation[:, 0] + stance.rotation[:, 0]
    forward = np.array([ahead[0], ahead[1], 0.0]) / np.hypot(ahead[0], ahead[1])
    left = np.array([-forward[1], forward[0], 0.0])
    side = float(np.sign((swing.translation - stance.translation) @ left)) or 1.0
    return {
        "forward": forward,
        "backward": -forward,
        "to the swing side": side * left,
        "to the stance side": -side * left,
    }


def largest_push(
    gait: Gait,
    direction: str,
    along: Array,
    options: WalkOptions | None = None,
    controller: MakeController | None = None,
    bisections: int = BISECTIONS,
) -> PushLimit:
    """Return the largest push of a direction that is survived, by bisection.

    A push is survived if eight more steps follow, the last with half of the designed speed at
    least. It lasts 50 ms and comes at half of the fifth step.

    Args:
        along: unit vector in the world, shape (3,).

    Raises:
        InputError: fewer than one bisection.
    """
    if bisections < 1:
        raise InputError(f"{bisections} bisections find nothing; ask for 1 at least")
    options = replace(options or WalkOptions(), steps=PUSHED + 1 + RECOVERED)
    controller = controller or whole_body_walks()
    mass = float(gait.trajectory.body.mass.sum())
    survived, fallen = 0.0, HARDEST * mass
    best: SimulatedWalk | None = None

    def walked(size: float) -> SimulatedWalk | None:
        x, y, z = (size * along).tolist()
        push = Push((x, y, z), step=PUSHED)
        walk = simulate(gait, options, controller, Disturbance(push=push))
        return walk if _goes_on(walk) else None

    for _ in range(bisections):
        middle = (survived + fallen) / 2.0
        found = walked(middle)
        survived, fallen, best = (
            (survived, middle, best) if found is None else (middle, fallen, found)
        )
    speed = float("nan") if best is None else best.last_speed
    unbounded = fallen == HARDEST * mass
    return PushLimit(direction, survived, survived / mass, speed, best, unbounded)


def suspect(tries: tuple[str, ...], points: tuple[WeakPoint, ...]) -> WeakPoint:
    """Return what in the gait a fall points to: of what was tried, what is nearest its bound."""
    return max((p for p in points if p.name in tries), key=lambda p: p.severity)


def _starts(
    gait: Gait, options: WalkOptions, controller: MakeController | None
) -> Iterator[Checked]:
    for seed in range(STARTS):
        check = replace(START, disturbance=replace(START.disturbance, seed=seed))
        yield try_check(gait, check, options, controller)
