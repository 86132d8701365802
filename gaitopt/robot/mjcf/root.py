"""Which of the bodies of a compiled MJCF file is the robot, and what of its root is only a stand.

A robot may float on a free joint, slide and turn on up to six joints, or be fixed to the world:
here it always floats, for it is going to walk.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from gaitopt.errors import RobotError

_LIGHT = 0.01  # of the robot's mass: a body that only carries a joint of the root
_MOST_ROOT_JOINTS = 6


@dataclass(frozen=True)
class Root:
    """The body from which a robot hangs.

    Attributes:
        body: its place in the model.
        carriers: bodies between it and the world that move and have their mass, from the world on.
        joints: of body and carriers, which a free-flyer replaces.
        free: whether the file lets it float.
    """

    body: int
    carriers: tuple[int, ...]
    joints: tuple[int, ...]
    free: bool


class Bodies:
    """The tree of the bodies of an MjModel.

    Args:
        mujoco: the module.
        model: MuJoCo's.
    """

    def __init__(self, mujoco: ModuleType, model: Any) -> None:
        self.model = model
        self.free, self.slide = (
            int(kind) for kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_SLIDE)
        )
        self.children: dict[int, list[int]] = {body: [] for body in range(model.nbody)}
        for body in range(1, model.nbody):
            self.children[int(model.body_parentid[body])].append(body)

    def joints(self, body: int) -> tuple[int, ...]:
        """Return the joints of a body."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return tuple(range(first, first + count))

    def below(self, body: int) -> Iterator[int]:
        """Yield a body and all that hang on it, depth first."""
        yield body
        for child in self.children[body]:
            yield from self.below(child)

    def moving(self, body: int) -> bool:
        """Return whether a body or one on it has a joint."""
        return any(self.joints(b) for b in self.below(body))

    def kinds(self, joints: tuple[int, ...]) -> list[int]:
        """Return the types of joints."""
        return [int(self.model.jnt_type[j]) for j in joints]

    def count(self, root: Root) -> int:
        """Return how many joints a robot has beside those of its root."""
        return sum(len(self.joints(b)) for b in self.below(root.body)) - len(self.joints(root.body))


def choose_root(mujoco: ModuleType, model: Any) -> tuple[Root, tuple[str, ...]]:
    """Return the root of the robot, which is what has most joints, and the names of other robots.

    Raises:
        RobotError: nothing in the file moves.
    """
    bodies = Bodies(mujoco, model)
    roots = [
        root for top in bodies.children[0] if bodies.moving(top) for root in _roots(bodies, top)
    ]
    if not roots:
        raise RobotError("the MJCF file has no body that moves; it describes no robot")
    chosen = max(roots, key=bodies.count)
    return chosen, tuple(str(model.body(r.body).name) for r in roots if r is not chosen)


def _roots(bodies: Bodies, body: int) -> list[Root]:
    """Return the robots on a body that hangs on the world or on what is fixed to it."""
    if bodies.joints(body):
        return [_jointed(bodies, body)]
    hanging = [c for c in bodies.children[body] if bodies.moving(c)]
    inner = [root for child in hanging for root in _roots(bodies, child)]
    # What hangs on hinges alone are the limbs of a body that is held.
    return [root for root in inner if root.free] or [Root(body, (), (), False)]


def _jointed(bodies: Bodies, first: int) -> Root:
    """Return the robot of which the first body has joints."""
    joints = bodies.joints(first)
    if bodies.free in bodies.kinds(joints):
        return Root(first, (), joints, True)
    path = [first]
    while len(bodies.children[path[-1]]) == 1 and _carries_only(bodies, first, path):
        path += bodies.children[path[-1]]
    sliding = [b for b in path if bodies.slide in bodies.kinds(bodies.joints(b))]
    if not sliding:
        return Root(first, (), joints, False)
    joints = tuple(j for b in path for j in bodies.joints(b))
    return Root(path[-1], tuple(path[:-1]), joints, True)


def _carries_only(bodies: Bodies, first: int, path: list[int]) -> bool:
    """Whether the last body of a path is light, and the joints may still all be the root's."""
    model = bodies.model
    (child,) = bodies.children[path[-1]]
    count = sum(len(bodies.joints(b)) for b in [*path, child])
    light = model.body_mass[path[-1]] <= _LIGHT * model.body_subtreemass[first]
    return bool(light and bodies.joints(child) and count <= _MOST_ROOT_JOINTS)
