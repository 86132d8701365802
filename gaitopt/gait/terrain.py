"""Terrain: the ground under a walk, which every step finds the same, or every other step.

Its axes are those of the sole that stands, flat on it: x ahead, y left, z normal to the ground. A
terrain says where gravity points in them, how much higher the next foot stands, and how high the
ground is between the footprints. Gravity, the double support, the clearance, the first guess, the
refusals, pictures and gait files ask it: a new one is one class, here or in a plugin.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from gaitopt.bounds import fixed, is_finite, is_line, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.functions import QuantityFunction, real_array
from gaitopt.model.sole import LEVEL, Sole
from gaitopt.nlp import Array

LEAST_ROUNDING = 0.02
"""Length before an edge [m] from which on the sides of a sole of 0.2 m need few points."""
_OF_SOLE = 0.1
"""As much, of a shorter sole's length."""
RISE_STEP = 0.04
"""Of stairs, largest between a walk and the next that starts from it [m]."""
_SPACING = 1.0 / 3.0
"""Between points of the sole's sides, of the length over which the ground changes."""
_EDGES = (-2.0, -1.0, 0.0, 1.0)  # in treads from the edge before the stance foot
_OUTLINE = 48  # points of the ground of a step, for pictures
_CORNERS = 4
_CHECKED, _MOVE, _APART = 401, 1e-5, 1e-3
"""Places at which a profile is checked; step of the differences, over that of the walk; largest
disagreement, over the largest derivative (where the third derivative jumps, 1e-4 is usual)."""
_ORDERS = 3  # the height and its first two derivatives
_LEVEL = 1e-9  # m: rounding of a height


class Profile(ABC):
    """How high the ground is along x in the axes of the stance sole; the same for every y.

    Over the footprints, the one ahead and the one behind too, it is level.

    Attributes:
        length: over which the ground changes [m]; points of the swing sole stand closer than that.
    """

    length: float

    @abstractmethod
    def height(self, x: Array) -> tuple[Array, Array, Array]:
        """Return the height at x [m] and its first two derivatives, each of the shape of x.

        The swing foot passes from one step behind the stance foot to one step ahead of it.
        """

    def outline(self, step: float) -> Array:
        """Return points (x, z) of the ground of one step for pictures [m], shape (m, 2).

        Args:
            step: length of a step [m].
        """
        x = step * np.linspace(-0.5, 0.5, _OUTLINE, endpoint=False)
        return np.stack([x, self.height(x)[0]], axis=1)


class Terrain(ABC):
    """A ground; subclasses are frozen dataclasses, whose fields are what people say of it.

    Attributes:
        name: in gait files.
        shaped: whether the ground between the footprints is no plane. Steps then are as long as
            speed and duration say, both of them given, and the foot stands flat.
    """

    name: ClassVar[str]
    shaped: ClassVar[bool] = False

    @abstractmethod
    def words(self, step: float) -> str:
        """Return what a person calls it, for steps of a length [m]: "uphill, 10 %"."""

    @property
    def down(self) -> tuple[float, float, float]:
        """Direction of gravity, of unit length."""
        return LEVEL

    @property
    def in_mirror(self) -> tuple[float, float, float]:
        """Direction of gravity for a second step that is seen as its mirror image."""
        x, y, z = self.down
        return x, -y, z

    @property
    def across_angle(self) -> float:
        """Angle of the ground to the left, rising above zero [rad]."""
        return math.asin(-self.down[1])

    @property
    def rise(self) -> float:
        """Height of the footprint ahead over that of the stance foot, along z [m]."""
        return 0.0

    @property
    def lift(self) -> float:
        """By how much more than on a plane the first guess lifts the swing foot [m]."""
        return abs(self.rise)

    @property
    def incline(self) -> float:
        """Angle of the ground ahead, uphill above zero [rad]."""
        return math.atan2(-self.down[0], -self.down[2])

    def profile(self, sole: Sole, step: float, nosing: float | None) -> Profile | None:
        """Return the height between the footprints, None for a plane.

        Args:
            sole: the rectangle that stands on it.
            step: length of a step [m].
            nosing: the margin of that name, length over which edges are rounded [m].

        Raises:
            InputError: there is no room for the sole.
        """
        del sole, step, nosing
        return None

    def easier(self) -> tuple[Terrain, ...]:
        """Return terrains to walk on first, the easiest first; none: slower walks are tried."""
        return ()


@dataclass(frozen=True)
class Level(Terrain):
    """Level ground, that of the paper."""

    name = "level"

    def words(self, step: float) -> str:
        del step
        return ""


@dataclass(frozen=True)
class Slope(Terrain):
    """A plane that rises or falls ahead, or to a side.

    Attributes:
        angle: of what points ahead on it, uphill above zero [rad].
        across: of what points to the left on it, rising above zero [rad].
    """

    name = "slope"
    angle: float
    across: float = 0.0

    @property
    def down(self) -> tuple[float, float, float]:
        if self.across == 0.0:
            return -math.sin(self.angle), 0.0, -math.cos(self.angle)
        x, y = math.sin(self.angle), math.sin(self.across)
        return -x, -y, -math.sqrt(1.0 - x * x - y * y)

    def words(self, step: float) -> str:
        del step
        ways = (
            ("uphill" if self.angle > 0.0 else "downhill", self.angle),
            (f"rising to the {'left' if self.across > 0.0 else 'right'}", self.across),
        )
        return ", ".join(
            f"{way}, {100.0 * math.tan(abs(angle)):.3g} % ({math.degrees(abs(angle)):.3g}°)"
            for way, angle in ways
            if angle != 0.0
        )


@dataclass(frozen=True)
class Stairs(Terrain):
    """Level treads, as long as the steps: every foot stands on one of its own.

    Attributes:
        height: of each tread over the one before, down below zero [m].
    """

    name = "stairs"
    shaped = True
    height: float

    @property
    def rise(self) -> float:
        return self.height

    def words(self, step: float) -> str:
        way = "upstairs" if self.height > 0.0 else "downstairs"
        return f"{way}, {1e3 * abs(self.height):.4g} mm for {1e3 * step:.4g} mm"

    def easier(self) -> tuple[Terrain, ...]:
        count = int(np.ceil(abs(self.height) / RISE_STEP))
        shares = (float(share) for share in np.arange(1, count) / count)
        return (Level(), *(Stairs(share * self.height) for share in shares))

    def profile(self, sole: Sole, step: float, nosing: float | None) -> Treads:
        """Return the treads that a sole can stand on; see `Terrain.profile`.

        Raises:
            InputError: the treads are too short for it.
        """
        length = sole.length
        room = step - length
        wanted = min(LEAST_ROUNDING, _OF_SOLE * length) if nosing is None else nosing
        if room < wanted:
            raise InputError(
                f"a tread as long as a step, {step:.3g} m, is too short for a sole of "
                f"{length:.3g} m and {wanted:.3g} m to the edges (nosing): at least "
                f"{length + wanted:.4g} m; take longer steps (speed times duration), or a smaller "
                "nosing"
            )
        rounding = room if nosing is None else nosing
        return Treads(self.height, step, sole.toe + (room - rounding) / 2.0, rounding)


@dataclass(frozen=True)
class Treads(Profile):
    """Stairs under a sole.

    Between the toe of a foot and the heel on the next tread the ground rises or falls at an edge;
    the height is rounded there, before the edge upstairs and behind it downstairs. So it is never
    lower than the stairs, and has two continuous derivatives.

    Attributes:
        rise: of each tread over the one before, down below zero [m].
        tread: depth of a tread [m].
        begin: x at which the height begins to change before the stance foot [m].
        length: over which it changes [m].
    """

    rise: float
    tread: float
    begin: float
    length: float

    @property
    def edge(self) -> float:
        """X of the edge before the stance foot [m]."""
        return self.begin + (self.length if self.rise > 0.0 else 0.0)

    def height(self, x: Array) -> tuple[Array, Array, Array]:
        total, first, second = (
            np.full(x.shape, -2.0 * self.rise),
            np.zeros(x.shape),
            np.zeros(x.shape),
        )
        for count in _EDGES:
            t = np.clip((x - self.begin - count * self.tread) / self.length, 0.0, 1.0)
            total += self.rise * t**3 * (10.0 + t * (6.0 * t - 15.0))
            first += self.rise / self.length * 30.0 * t**2 * (1.0 - t) ** 2
            second += self.rise / self.length**2 * 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t)
        return total, first, second

    def outline(self, step: float) -> Array:
        return np.array([[self.edge - step, 0.0], [self.edge, 0.0]])


def check_profile(terrain: Terrain, sole: Sole, step: float, nosing: float | None) -> None:
    """Check the profile of a terrain of one's own.

    Raises:
        InputError: a number of it is none, its height is not finite, a derivative is wrong, or the
            footprints are not level or not where `rise` says.
    """
    if not is_line(words := terrain.words(step)):
        raise InputError(
            f"the words of the terrain '{terrain.name}' are {shown(words)}; give a text of one line"
        )
    for name in ("rise", "lift"):
        if not is_finite(value := getattr(terrain, name)):
            raise InputError(
                f"the {name} of the terrain '{terrain.name}' is {shown(value)}; give metres"
            )
    easier = terrain.easier()
    if not (isinstance(easier, tuple) and all(isinstance(one, Terrain) for one in easier)):
        raise InputError(f"easier() of the terrain '{terrain.name}' returns no tuple of terrains")
    profile = terrain.profile(sole, step, nosing)
    if profile is None:
        return
    what = f"the profile of the terrain '{terrain.name}'"
    if not isinstance(profile, Profile):
        raise InputError(f"{what} is {shown(profile)}; give an instance of a Profile, or None")
    if not terrain.shaped:
        raise InputError(
            f"the terrain '{terrain.name}' has a profile, so that it is no plane; write "
            "shaped = True into its class"
        )
    length = getattr(profile, "length", None)
    if not (is_finite(length) and length > 0.0):
        raise InputError(
            f"{what} has the length {shown(length)}; give metres, over which the ground changes"
        )
    x = step * np.linspace(-1.0, 1.0, _CHECKED)
    move = _MOVE * step
    # the corners at all instants are asked for at once, as pairs of dimensions
    heights = [profile.height(at) for at in (x - move, x, x + move, x.reshape(-1, 1))]
    if not all(isinstance(part, tuple | list) and len(part) == _ORDERS for part in heights):
        raise InputError(f"{what} returns no tuple of the height and two derivatives")
    before, here, after, pairs = heights
    if not all(
        real_array(part, what).shape == x.shape
        and np.isfinite(part).all()
        and np.shape(other) == (x.size, 1)
        and np.allclose(part, np.ravel(other), rtol=1e-9)  # sums may be rounded otherwise
        for part, other in zip(here, pairs, strict=True)
    ):
        raise InputError(
            f"{what} returns no finite height and two derivatives for every x, each of its shape"
        )
    for k, name in enumerate(("first", "second")):
        found = (after[k] - before[k]) / (2.0 * move)
        if np.abs(found - here[k + 1]).max() > _APART * max(np.abs(found).max(), 1e-9):
            raise InputError(
                f"{what} has a {name} derivative that disagrees with differences; correct it (the "
                "height has two continuous derivatives)"
            )
    outline = real_array(profile.outline(step), f"the outline of {what}")
    if outline.ndim != 2 or outline.shape[1] != 2 or not np.isfinite(outline).all():
        raise InputError(f"the outline of {what} is {shown(outline)}; return points (x, z) in rows")
    for number in (-1, 0, 1):
        under = np.linspace(sole.heel, sole.toe, _CHECKED) + number * step
        if np.abs(profile.height(under)[0] - number * terrain.rise).max() > _LEVEL:
            raise InputError(
                f"{what} is not level at {number * terrain.rise:g} m where the foot of step "
                f"{number} stands, x from {fixed(under[0], 3)} to {fixed(under[-1], 3)} m"
            )


def sole_points(spacing: float, sole: Sole) -> Array:
    """Return the shares of the corners in points along both sides of a sole, shape (p, 4).

    Args:
        spacing: largest distance between two of them [m].
    """
    count = int(np.ceil(sole.length / spacing))
    points = np.eye(_CORNERS)
    for share in np.arange(1, count) / count:
        points = np.vstack([points, [[1 - share, 0, share, 0], [0, 1 - share, 0, share]]])
    return points


@dataclass(frozen=True)
class AboveProfile(QuantityFunction):
    """Heights of points of the swing sole above a profile, from its corners, shape (K, p).

    Attributes:
        profile: below them.
        points: shares of the four corners in each point, shape (p, 4): the corners, then points
            between them, for what the ground rises to may lie between the corners.
    """

    profile: Profile
    points: Array

    @classmethod
    def of_sole(cls, profile: Profile, sole: Sole) -> AboveProfile:
        """Return it for the corners of a sole and as many points of its sides as it needs."""
        return cls(profile, sole_points(_SPACING * profile.length, sole))

    def value(self, quantity: Array) -> Array:
        x, z = self._placed(quantity)
        return np.asarray(z - self.profile.height(x)[0])

    def jacobian(self, quantity: Array) -> Array:
        x, _ = self._placed(quantity)
        jacobian = np.zeros((*x.shape, _CORNERS, 3))
        jacobian[..., 0] = -self.profile.height(x)[1][..., None] * self.points
        jacobian[..., 2] = self.points
        return jacobian.reshape(*x.shape, -1)

    def hessian(self, quantity: Array, weights: Array) -> Array:
        x, _ = self._placed(quantity)
        bent = -weights * self.profile.height(x)[2]
        hessian = np.zeros((len(x), _CORNERS, 3, _CORNERS, 3))
        hessian[:, :, 0, :, 0] = np.einsum("kp,pi,pj->kij", bent, self.points, self.points)
        return hessian.reshape(len(x), 3 * _CORNERS, 3 * _CORNERS)

    def _placed(self, quantity: Array) -> tuple[Array, Array]:
        corners = quantity.reshape(-1, _CORNERS, 3)
        return corners[..., 0] @ self.points.T, corners[..., 2] @ self.points.T


def ground_record(
    terrain: Terrain, sole: Sole, step: float, nosing: float | None
) -> dict[str, object]:
    """Return what a gait file says of its ground, so that no plugin is needed to draw it."""
    profile = terrain.profile(sole, step, nosing)
    return {
        "words": terrain.words(step),
        "down": list(map(float, terrain.down)),
        "rise": float(terrain.rise),
        "outline": [] if profile is None else np.asarray(profile.outline(step)).tolist(),
    }
