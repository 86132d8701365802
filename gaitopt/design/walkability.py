"""What in a gait makes it hard to walk under feedback, and the option that changes it.

Bounds are those beyond which the whole-body controller was seen to fail or to pay
(docs/simulation.md); they judge the designed motion alone.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.gait.result import Gait
from gaitopt.gait.trajectory import Trajectory, TrajectorySamples
from gaitopt.model.sole import turning_arm
from gaitopt.nlp import Array

RESERVE = "shortest reserve of leg length"
LANDING = "landing speed of the slowest corner"
IMPULSE = "vertical impulse at landing over mass"
TURNING = "turning moment over load"
FRICTION = "friction used"
PRESSURE = "room of the centre of pressure"

PYRAMID = 0.53
"""Half-width of the friction pyramid that the controller of simulated walks keeps."""
STRIP = 2e-3
"""Of the sole, along its edges, that it does not use [m]."""
_INSTANTS = 301
_RESERVE = 3e-3  # m of leg length: a centre of mass that lags leaves the landing leg too short
_LANDING = 0.1  # m/s, of the slowest corner: one that grazes makes the landing time undefined
_IMPULSE = 0.3  # m/s, vertical impulse over mass
_HEEL = slice(2, 4)  # corners at the heel, of toe left, toe right, heel left, heel right


@dataclass(frozen=True)
class WeakPoint:
    """A number of a designed gait beside what walks.

    Attributes:
        name: what it is, in words.
        value: of the gait.
        bound: beyond which walks were seen to fail.
        unit: of both.
        least: whether the bound is a least value, not a largest.
        option: that changes it.
    """

    name: str
    value: float
    bound: float
    unit: str
    least: bool
    option: str

    @property
    def severity(self) -> float:
        """How far beyond the bound it is: 0 at the bound, 1 as far again, below 0 inside."""
        excess = (self.bound - self.value) if self.least else (self.value - self.bound)
        return excess / self.bound

    @property
    def weak(self) -> bool:
        """Whether it is beyond the bound."""
        return self.severity > 0.0

    def __str__(self) -> str:
        """Return it as a clause."""
        scale, unit = (1000.0, "mm") if self.unit == "m" and self.bound < 0.02 else (1.0, self.unit)
        side = "least" if self.least else "most"
        value = f"{scale * self.value:.3g} {unit}".rstrip()
        return (
            f"{self.name} {value}, where {scale * self.bound:.3g} at {side} walks well: "
            f"{self.option}"
        )


def weak_points(gait: Gait) -> tuple[WeakPoint, ...]:
    """Return what was measured of a designed gait, the worst first."""
    trajectory = gait.trajectory
    step = np.linspace(0.0, trajectory.step_duration, _INSTANTS)
    begins = np.arange(len(gait.steps)) * trajectory.step_duration
    times = (begins[:, None] + step).ravel()
    samples = trajectory.at(times, before=np.tile(step > 0.0, len(begins)))
    turns = np.array([part.turning is not None for part in trajectory.phases])
    flat = samples.contact & ~turns[samples.phase][:, None]
    wrench, pressure = samples.wrench[samples.contact], samples.pressure[samples.contact]
    load = wrench[:, 2]
    across = pressure[:, 0] * wrench[:, 1] - pressure[:, 1] * wrench[:, 0]
    toe, heel, left, right = np.array(trajectory.body.sole_rectangle).T
    x, y = samples.pressure[..., 0], samples.pressure[..., 1]
    # a foot that turns about a line has no room along it
    room = np.minimum.reduce([toe - x, x - heel, left - y, y - right])[flat]
    mass = float(trajectory.body.mass.sum())
    arm = turning_arm(float(toe[0] - heel[0]), float(left[0] - right[0]))
    found = [
        WeakPoint(
            RESERVE, float(_reserve(trajectory, samples).min()), _RESERVE,
            "m", True, "raise --knee-flexion, lower --leg-extension",
        ),
        WeakPoint(
            TURNING, float((np.abs(wrench[:, 5] - across) / load).max()),
            PYRAMID * arm, "m", False, "lower --torsional-friction",
        ),
        WeakPoint(
            FRICTION, float((np.hypot(wrench[:, 0], wrench[:, 1]) / load).max()),
            PYRAMID, "", False, "lower --friction",
        ),
        WeakPoint(
            PRESSURE, float(room.min()), STRIP, "m", True,
            "raise --cop-margin",
        ),
    ]  # fmt: skip
    if gait.striking or not gait.closing:  # else the foot lands at zero speed, the other stands on
        found += [
            WeakPoint(
                LANDING, float(_landing_speeds(gait).min()),
                _LANDING, "m/s", True, "raise --landing-speed",
            ),
            WeakPoint(
                IMPULSE, max(float(step.impulse[2]) for step in gait.steps) / mass, _IMPULSE,
                "m/s", False, "lower --landing-impulse",
            ),
        ]  # fmt: skip
    return tuple(sorted(found, key=lambda point: -point.severity))


def _landing_speeds(gait: Gait) -> Array:
    """Return how fast the corners that land come down [m/s], shape (4,), of strides (8,)."""
    trajectory, found = gait.trajectory, []
    body = trajectory.body
    model, data = body.model, body.model.createData()
    both = float(np.ptp(gait.double_knots)) if gait.closing else 0.0
    for number in range(len(gait.steps)):
        end = trajectory.at((number + 1) * trajectory.step_duration - both, before=True)
        landing = 1 - int(end.standing[0])
        pin.forwardKinematics(model, data, end.configuration[0], end.velocity[0])
        frame = model.getFrameId(body.sole_names[landing])
        pin.updateFramePlacement(model, data, frame)
        twist = pin.getFrameVelocity(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        corners = body.sole_corners[landing][_HEEL if gait.lands_on_line else slice(None)]
        corners = corners @ data.oMf[frame].rotation.T
        found.append(-(twist.linear + np.cross(twist.angular, corners))[:, 2])
    return np.concatenate(found)


def _reserve(trajectory: Trajectory, samples: TrajectorySamples) -> Array:
    """Return by how much either leg is shorter than when it is straight [m], shape (N, 2).

    A leg is straight where its knee, the joint farthest from the line between hip and ankle joint,
    is on it.
    """
    body = trajectory.body
    places = body.placements(samples.configuration)[:, 1:, :3, 3]
    reserves = []
    for foot in (0, 1):
        joints = places[:, list(body.leg(foot))]
        ankle, hip = joints[:, :1], joints[:, -1:]
        detour = np.linalg.norm(joints - ankle, axis=2) + np.linalg.norm(joints - hip, axis=2)
        reserves.append(detour.max(axis=1) - np.linalg.norm(ankle - hip, axis=2)[:, 0])
    return np.array(reserves).T
