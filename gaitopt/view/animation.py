"""The walking robot in a scene: ground, footprints, robot, centre of pressure and force, moving.

MeshCat animates position, orientation and scale of a node; the force arrow is a shaft that is
stretched and a head that is moved, so its length is the force. Its camera turns about the origin
of the scene only, so that to follow the robot the world is moved the other way.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from gaitopt.bounds import FRAMES, STEPS, at_most, shown
from gaitopt.contact import BOTH_FEET, FlatFoot, HeelLine, ToeLine
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait, Ground, ground_of
from gaitopt.gait.trajectory import TrajectorySamples
from gaitopt.gait.transition import Transition
from gaitopt.mechanics.spatial import quaternions, upright
from gaitopt.model.multibody import Multibody
from gaitopt.nlp import Array
from gaitopt.tolerances import SAME
from gaitopt.view.robot_shapes import UPRIGHT, RobotShapes, draw_shape, robot_shapes, triangles
from gaitopt.view.stick_figures import contact_colour
from gaitopt.view.viewer import Node, animation, geometry

DEFAULT_STEPS = 6
_REPETITIONS = 1_000_000  # of a film
_WORLD = "world"
_LEVEL = 1e-6  # m: rounding over a walk
_BLOCKS = (0xD9DEE3, 0xC9D0D7)
_WIDTH, _BLOCK, _UNDER, _MORE_STEPS = 1.6, 0.1, 0.002, 3
"""Of ground that is no plane [m], below its lowest point [m], below the soles [m]; steps of it
before and behind the walk."""
CAMERA = (1.9, 0.6, 2.05)  # from what it looks at, in heights of the hips: ahead, up, right
TARGET_HEIGHT = 0.92  # of the point the camera looks at, in heights of the hips
_ARROW = 0.9  # the weight's arrow, about, in heights of the hips
_SWITCH = 1e-4  # s: marks leave the old foot this long before they are on the new one
_PRINT = 0.004  # m: thickness of the marks on the ground
_BORDER = 0.05  # m: by how much the mark of the standing foot is larger than its sole
_LINE_WIDTH = 0.03  # m: of the mark of a foot that stands on a line
_SMOOTH = 0.25  # s: the camera follows a robot that walks faster and faster within about this
_SAME = 1e-6  # m: footprints nearer to each other are one
_HIDDEN = 1e-4  # size of a mark that is not to be seen
_GROUND_SIZE = 20.0  # m, square
_GRID = 0.5  # m between the lines on the ground
_GROUND, _LINE, _FOOTPRINT = 0xEDF0F2, 0xC9D1D8, 0x9DB4C8
_COP, _FORCE = 0xB00020, 0xE07A10
PUSH = "#8b3fc0"
_GAP = 1.2  # between two robots, in heights of the hips
_PUSH_LENGTH = 0.7  # of its arrow, in heights of the hips
PUSH_SEEN = 0.4  # s for which it is shown; the push itself is over at once


class Animation:
    """Collects the motion of the nodes of a scene: tracks keyed by seconds."""

    def __init__(self) -> None:
        self._times = np.zeros(0)
        self._tracks: dict[str, dict[str, tuple[str, Array]]] = {}

    def place(self, node: Node, times: Array, positions: Array) -> None:
        """Move a node through positions (N, 3) [m] at times (N,) [s]."""
        self._key(node, "position", "vector3", times, positions)

    def turn(self, node: Node, times: Array, rotations: Array) -> None:
        """Turn a node through rotation matrices (N, 3, 3) at times (N,) [s]."""
        self._key(node, "quaternion", "quaternion", times, quaternions(rotations))

    def stretch(self, node: Node, times: Array, scales: Array) -> None:
        """Scale a node by factors (N, 3) along its axes at times (N,) [s]."""
        self._key(node, "scale", "vector3", times, scales)

    def show(self, viewer: Node, whole: bool) -> None:
        """Hand the motion to the viewer, which plays it over and over.

        Args:
            whole: False for its ends alone, where `record` gives the page the rest.
        """
        # one frame is one second, so that key times are times
        film = animation.Animation(default_framerate=1)
        last = len(self._times) - 1
        rows = np.arange(last + 1) if whole else np.unique([0, last])
        times = self._times[rows].tolist()
        for path, tracks in self._tracks.items():
            film.clips[path] = animation.AnimationClip(
                {prop: animation.AnimationTrack(prop, kind, times, values[rows].tolist())
                 for prop, (kind, values) in tracks.items()}, fps=1,
            )  # fmt: skip
        viewer.set_animation(film, play=True, repetitions=_REPETITIONS)

    def record(self) -> dict[str, object]:
        """Return the motion for `move` of load.js, which puts it in the place of another one.

        The tracks are in the order in which a viewer that was shown the other one has them.
        """
        tracks = [[values for _, values in own.values()] for own in self._tracks.values()]
        return {"times": self._times, "tracks": tracks}

    def _key(self, node: Node, prop: str, kind: str, times: Array, values: Array) -> None:
        self._times = times  # the same for all
        self._tracks.setdefault(node.path, {})[prop] = kind, values


@dataclass(frozen=True)
class ShownPush:
    """A push at the pelvis, midway between the hips.

    Attributes:
        begins: [s].
        impulse: in the world [N·s].
    """

    begins: float
    impulse: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Replay:
    """A walk that went otherwise than designed, as one that was simulated.

    Attributes:
        name: what it is, "undisturbed".
        ending: what came of it, "walked all steps".
        time: of its postures, increasing [s], shape (N,).
        configuration: of the gait's body in the world of its trajectory, shape (N, 7 + M).
        pushes: that it was given.
    """

    name: str
    ending: str
    time: Array
    configuration: Array
    pushes: tuple[ShownPush, ...] = ()


@dataclass(frozen=True)
class Scene:
    """What was put into a viewer.

    Attributes:
        force_scale: metres of arrow for 1 N.
        shapes: what the robot is drawn with.
        robots: paths of the robots' nodes in the viewer's tree; the first is drawn, others are to
            be given its shapes.
        motion: of everything that moves, see `Animation.record`.
    """

    force_scale: float
    shapes: RobotShapes
    robots: tuple[tuple[str, ...], ...]
    motion: dict[str, object]


def frames(gait: Gait, steps: int = DEFAULT_STEPS) -> TrajectorySamples:
    """Return a gait's walk at its sample times over several steps.

    The last frame of a step and the first of the next are the same instant and posture, before
    and after the impact: rates, force and standing foot jump there.

    Raises:
        InputError: there is no step, or there are too many frames.
        RobotError: the gait's robot cannot be read.
    """
    if steps < 1:
        raise InputError(f"{shown(steps)} steps cannot be shown; ask for one or more")
    at_most(steps, STEPS, "steps")
    # where the contact changes, the instants before and after it are no two pictures
    own = gait.time[np.diff(gait.time, prepend=-np.inf) > SAME * gait.duration]
    count = len(own)
    few = FRAMES // count
    at_most(steps * count, FRAMES, "frames", f"{few} steps of this gait's {count} instants")
    times = np.concatenate([own + k * gait.duration for k in range(steps)])
    before = np.tile(np.arange(count) > count // 2, steps)
    return gait.trajectory.at(times, before=before)


def transition_frames(transition: Transition) -> TrajectorySamples:
    """Return a transition, with what it leads from and to, at times as near as those of a step.

    Where a step follows another there are two frames of one posture, as in `frames`.

    Raises:
        InputError: there are too many frames.
    """
    trajectory = transition.trajectory
    ends = trajectory.breaks
    near = min(float(np.diff(step.time).max()) for step in transition.steps)
    counts = np.ceil(np.diff(ends) / near).astype(int) + 1
    at_most(int(counts.sum()), FRAMES, "frames")
    each = [
        np.linspace(begin, end, count)
        for begin, end, count in zip(ends, ends[1:], counts, strict=False)
    ]
    before = np.concatenate([np.arange(count) == count - 1 for count in counts])
    return trajectory.at(np.concatenate(each), before=before)


def build_scene(
    viewer: Node,
    gait: Gait | Transition,
    steps: int,
    package_dirs: tuple[str, ...] = (),
    drawn: RobotShapes | None = None,
    whole: bool = False,
) -> Scene:
    """Put the walking robot into a MeshCat viewer and set it in motion.

    Args:
        gait: one step, or a transition, of which all is shown.
        steps: how many to show; then the animation starts again.
        package_dirs: where to look for meshes.
        drawn: what the viewer shows already of this robot: objects are only moved then, and what
            moves by itself is left to `Scene.motion`.
        whole: whether the viewer is given all of the motion, and not only its ends, because
            nothing puts `Scene.motion` in their place.

    Raises:
        InputError: steps < 1.
        RobotError: the robot cannot be drawn.
    """
    samples = transition_frames(gait) if isinstance(gait, Transition) else frames(gait, steps)
    # the last frame of each step comes a moment earlier: keys must increase
    times = samples.time - _SWITCH * np.append(np.diff(samples.step) > 0, False)
    return _scene(viewer, gait, (samples, times), steps, package_dirs, drawn, None, whole)


def build_beside(
    viewer: Node,
    gait: Gait,
    other: Replay,
    steps: int,
    drawn: RobotShapes | None = None,
) -> Scene:
    """Put two robots into a viewer: one that walked otherwise, and to its left as designed.

    The film is left to `Scene.motion`, whose tracks are the same for every other walk.

    Args:
        steps: of the longest walk that is shown: of stairs, and of footprints.
        drawn: as for `build_scene`.

    Raises:
        RobotError: the robot cannot be drawn.
    """
    samples = gait.trajectory.at(other.time)
    return _scene(viewer, gait, (samples, other.time), steps, (), drawn, other)


def _scene(
    viewer: Node,
    gait: Gait | Transition,
    walk: tuple[TrajectorySamples, Array],
    steps: int,
    package_dirs: tuple[str, ...],
    drawn: RobotShapes | None,
    other: Replay | None,
    whole: bool = False,
) -> Scene:
    """Put one robot, or two, into a viewer; the walk is its samples and the times of the frames."""
    (samples, times), moves, body = walk, Animation(), gait.trajectory.body
    new = drawn is None
    shapes = robot_shapes(gait, package_dirs) if drawn is None else drawn
    hips = hip_height(body, samples)
    force_scale = _force_scale(samples, hips)
    ground, gap = ground_of(gait), 0.0 if other is None else _GAP * hips
    if new:
        _prepare(viewer, hips, climbs=ground.shaped and ground.rise * gait.step_length > 0.0)
    viewer[_WORLD].set_transform(pin.SE3(upright(body.gravity), np.zeros(3)).homogeneous)
    world = viewer[_WORLD]["along"]  # x runs along the ground, on a slope too
    if ground.shaped:
        _draw_profile(world["ground"], ground, gait.step_length, steps, gap)
    elif new:
        _draw_ground(world["ground"])
    lane = world if other is None else world["designed"]
    lane_of_other = [] if other is None else [world["robot"]]
    if other is not None and new:
        lane.set_transform(_shift([0.0, gap, 0.0]))
    prints = _footprints(gait, steps)
    _draw_footprints(lane["footprints"], body, prints, new)
    if other is not None:
        _draw_footprints(world["footprints"], body, prints, new)
        draw_robot(world["robot"], moves, body, shapes, other.configuration, times, new)
        _draw_pushes(world["push"], moves, body, other, hips, new)
    robot, first = lane["robot"], new and other is None
    draw_robot(robot, moves, body, shapes, samples.configuration, times, first)
    for mark in _marks(gait, samples):
        _draw_mark(lane[mark.node], moves, body, (samples, times), mark, new)
    _draw_force(lane["ground_force"], moves, samples, times, force_scale, new)
    steady = not isinstance(gait, Transition)
    _follow(world, moves, samples, times, (0.5 * gap, TARGET_HEIGHT * hips), steady)
    if new:
        moves.show(viewer, whole)
    robots = [*lane_of_other, robot]
    paths = tuple(tuple(one.path.lower().strip("/").split("/")) for one in robots)
    return Scene(force_scale, shapes, paths, moves.record())


def draw_robot(
    robot: Node,
    moves: Animation,
    body: Multibody,
    shapes: RobotShapes,
    configurations: Array,
    times: Array,
    new: bool = True,
) -> None:
    """Put a robot into a viewer and move it, with one node for each body that carries shapes.

    Args:
        configurations: of its model, shape (N, 7 + M).
        times: of these, increasing [s].
        new: whether its shapes are still to be put there.
    """
    groups = [name.replace("/", "_") for name in ("root_joint", *body.joint_names)]
    for carrier, item, place in shapes.shapes if new else ():
        draw_shape(robot, groups[carrier], item, place)
    places = body.placements(configurations)
    for carrier in shapes.carriers:
        node = robot[groups[carrier]]
        if new:
            node.set_transform(places[0, carrier])
        moves.place(node, times, places[:, carrier, :3, 3])
        moves.turn(node, times, places[:, carrier, :3, :3])


def hip_height(body: Multibody, samples: TrajectorySamples) -> float:
    """Return the height of the hips at the beginning of a walk [m]: the size of the robot.

    Knees that bend much, as on stairs, make no small robot: it is at least the length of a leg.
    """
    places = body.placements(samples.configuration[:1])[0]
    legs = np.array([places[np.array(body.leg(foot)) + 1, :3, 3] for foot in (0, 1)])
    reach = np.linalg.norm(np.diff(legs, axis=1), axis=-1).sum(axis=1)
    return float(max(legs[:, -1, 2].mean(), reach.mean()))


def _force_scale(samples: TrajectorySamples, hips: float) -> float:
    """Return metres of arrow for 1 N: 10 cm for 1, 2 or 5 times a power of ten."""
    force = float(samples.wrench[..., 2].sum(axis=1).mean())
    exact = 0.1 * force / (_ARROW * hips)  # N for 10 cm
    power = 10.0 ** np.floor(np.log10(exact))
    return 0.1 / float(
        min((power * n for n in (1, 2, 5, 10)), key=lambda n: abs(np.log(n / exact)))
    )


def _prepare(viewer: Node, hips: float, climbs: bool) -> None:
    viewer["/Background"].set_property("top_color", [0.97, 0.98, 1.0])
    viewer["/Background"].set_property("bottom_color", [0.80, 0.84, 0.88])
    for name in ("/Axes", "/Grid"):  # they would not move with the world
        viewer[name].set_property("visible", False)
    ahead, up, right = CAMERA
    place = [-ahead if climbs else ahead, up, right]  # stairs hide feet from where they lead
    viewer["/Cameras/default/rotated/<object>"].set_property("position", [hips * c for c in place])


def _draw_ground(node: Node) -> None:
    plain = _painted(node["plane"], geometry.MeshBasicMaterial, _GROUND, layer=-3)
    node["plane"].set_object(geometry.Box([_GROUND_SIZE, _GROUND_SIZE, 0.01]), plain)
    node["plane"].set_transform(_shift([0.0, 0.0, -0.5 * 0.01]))
    # Short pieces: software renderers drop a line with one end behind the camera.
    at = np.arange(-_GROUND_SIZE / 2.0, _GROUND_SIZE / 2.0, _GRID)
    x, y = (c.ravel() for c in np.meshgrid(at, at))
    zero = np.zeros_like(x)
    along_x = np.stack([[x, y, zero], [x + _GRID, y, zero]], axis=-1)
    along_y = np.stack([[x, y, zero], [x, y + _GRID, zero]], axis=-1)
    lines = np.concatenate([along_x, along_y], axis=1).reshape(3, -1)
    points = geometry.PointsGeometry(lines.astype(np.float32))
    material = _painted(node["grid"], geometry.LineBasicMaterial, _LINE, layer=-2)
    node["grid"].set_object(geometry.LineSegments(points, material))


def _draw_profile(node: Node, ground: Ground, step: float, steps: int, beside: float) -> None:
    """Draw a block for the ground of each step, of those that the walk does not reach too.

    Args:
        step: length of a step [m].
        beside: by how much wider it is to the left [m].
    """
    numbers = range(-_MORE_STEPS, steps + _MORE_STEPS + 1)
    heights = ground.outline[:, 1]
    bottom = min(ground.rise * numbers[0], ground.rise * numbers[-1]) + heights.min() - _BLOCK
    for number in numbers:
        block = node[f"step_{number - numbers[0]}"]
        block.set_object(
            _block(ground, number, step, bottom, beside),
            geometry.MeshLambertMaterial(color=_BLOCKS[number % len(_BLOCKS)]),
        )
        block.set_property("renderOrder", -2)  # before the footprints


def _block(
    ground: Ground, number: int, step: float, bottom: float, beside: float
) -> geometry.Geometry:
    """Return the ground of one step down to a height [m], up to the next one or its own edge."""
    x, z = ground.along(number, number + 1, step).T
    ahead, height = ground.along(number + 1, number + 2, step)[0]
    if ahead - x[-1] > SAME * step:
        x, z = np.append(x, ahead), np.append(z, height)
    rings = np.empty((len(x), 4, 3))  # left and right at the top, right and left at the bottom
    rings[:, :, 0] = x[:, None]
    rings[:, :, 1] = np.array([0.5, -0.5, -0.5, 0.5]) * _WIDTH + np.array([beside, 0, 0, beside])
    rings[:, :2, 2], rings[:, 2:, 2] = z[:, None] - _UNDER, bottom
    near, far = rings[:-1], rings[1:]
    other, beyond = np.roll(near, -1, axis=1), np.roll(far, -1, axis=1)
    quads = [
        *np.stack([near, other, beyond, far], axis=2).reshape(-1, 4, 3), rings[0, ::-1], rings[-1],
    ]  # fmt: skip
    return triangles(np.array([quad[k] for quad in quads for k in ([0, 1, 2], [0, 2, 3])]))


def _painted(
    node: Node, kind: type[geometry.Material], colour: int, layer: int
) -> geometry.Material:
    """Return a material for marks on the ground, which lie in one plane: painted in layers."""
    node.set_property("renderOrder", layer)
    return kind(color=colour, depthWrite=False)


def _footprints(gait: Gait | Transition, steps: int) -> list[tuple[int, Array]]:
    """Return the foot of each footprint, and the placement of its sole in the world (4, 4)."""
    trajectory = gait.trajectory
    if not isinstance(gait, Transition):
        standing = trajectory.at((np.arange(steps) + 1e-6) * gait.duration).standing
        return [(int(f), trajectory.advance(k).homogeneous) for k, f in enumerate(standing)]
    samples = trajectory.at(trajectory.breaks, before=True)
    found = list[tuple[int, Array]]()
    for k in range(len(samples.time)):
        for foot in np.flatnonzero(samples.contact[k]):
            place = samples.sole[k, foot]
            if not any(f == foot and np.allclose(place, known, atol=_SAME) for f, known in found):
                found.append((int(foot), place))
    return found


def _draw_footprints(
    node: Node, body: Multibody, prints: Sequence[tuple[int, Array]], new: bool
) -> None:
    for number, (foot, place) in enumerate(prints):
        print_ = node[str(number)]
        if new:
            size = [*np.ptp(body.sole_corners[foot], axis=0)[:2], _PRINT]
            material = _painted(print_, geometry.MeshBasicMaterial, _FOOTPRINT, layer=-1)
            print_.set_object(geometry.Box(size), material)
        print_.set_transform(place @ _shift(_centre(body, foot, -0.5 * _PRINT)))


@dataclass(frozen=True, eq=False)
class _Mark:
    """What shows that a foot rests on the ground, in the colour of its contact.

    Attributes:
        node: path of it.
        contact: its name.
        feet: whose sole is marked, shape (N,).
        shown: when, shape (N,); None: always.
    """

    node: str
    contact: str
    feet: NDArray[np.int64]
    shown: NDArray[np.bool_] | None


def _marks(gait: Gait | Transition, samples: TrajectorySamples) -> list[_Mark]:
    """Return the marks of the feet that stand."""
    standing, both = samples.standing, np.asarray(samples.contact.all(axis=1))
    if isinstance(gait, Transition):
        phases = [(FlatFoot.name, ~both), (BOTH_FEET, both)][: 1 + bool(both.any())]
    else:
        phases = [(one.contact, samples.phase == k) for k, one in enumerate(gait.phases)]
    marks = []
    for index, (contact, during) in enumerate(phases):
        shown = during if len(phases) > 1 else None
        marks.append(_Mark(f"standing_sole/{index}", contact, standing, shown))
        if contact == BOTH_FEET:
            marks.append(_Mark(f"front_sole/{index}", contact, 1 - standing, shown))
    return marks


def _draw_mark(
    node: Node,
    moves: Animation,
    body: Multibody,
    walk: tuple[TrajectorySamples, Array],
    mark: _Mark,
    new: bool,
) -> None:
    """Mark what of a foot rests on the ground, if the mark is new; move it."""
    (samples, times), feet, contact = walk, mark.feet, mark.contact
    corners = body.sole_corners[0]
    size = np.ptp(corners, axis=0)[:2]
    ends = {ToeLine.name: corners[:, 0].max(), HeelLine.name: corners[:, 0].min()}
    line = contact in ends
    if new:
        length = _LINE_WIDTH if line else size[0] + _BORDER
        material = geometry.MeshBasicMaterial(color=int(contact_colour(contact).lstrip("#"), 16))
        node.set_object(geometry.Box([length, size[1] + _BORDER, _PRINT]), material)
    centres = np.array([_centre(body, foot, 0.0) for foot in (0, 1)])
    if line:
        centres[:, 0] = ends[contact]
    places = samples.sole[np.arange(len(times)), feet]
    own = centres[feet][..., None]
    at = (places[:, :3, :3] @ own)[..., 0] + places[:, :3, 3]
    moves.place(node, times, at - [0.0, 0.0, 0.49 * _PRINT])
    about = np.arctan2(places[:, 1, 0], places[:, 0, 0])  # the ground's normal
    moves.turn(node, times, np.array([pin.utils.rotate("z", angle) for angle in about.tolist()]))
    if mark.shown is not None:
        shown = np.where(mark.shown, 1.0, _HIDDEN)
        moves.stretch(node, times, np.tile(shown[:, None], (1, 3)))


def _draw_force(
    node: Node,
    moves: Animation,
    samples: TrajectorySamples,
    times: Array,
    scale: float,
    new: bool,
) -> None:
    if new:
        node["cop"].set_object(geometry.Sphere(0.016), _seen_through(_COP))
        draw_arrow(node, _FORCE)
    move_arrow(node, moves, times, pressure(samples), scale * samples.force.sum(axis=1))


def draw_arrow(node: Node, colour: int) -> None:
    """Put an arrow into a group, in which it points along z, for `move_arrow`."""
    paint = _seen_through(colour)
    node["shaft/bar"].set_object(geometry.Cylinder(1.0, 0.009), paint)
    node["shaft/bar"].set_transform(_shift([0.0, 0.0, 0.5]) @ UPRIGHT)
    node["head/cone"].set_object(geometry.Cylinder(0.07, radiusTop=0.0, radiusBottom=0.024), paint)
    node["head/cone"].set_transform(_shift([0.0, 0.0, 0.035]) @ UPRIGHT)


def move_arrow(node: Node, moves: Animation, times: Array, places: Array, along: Array) -> None:
    """Move an arrow: from places (N, 3), as long as the vectors along it (N, 3) [m]."""
    length = np.linalg.norm(along, axis=1)
    one = np.ones_like(length)
    moves.place(node, times, places)
    moves.turn(node, times, np.array([_towards(vector) for vector in along]))
    moves.stretch(node["shaft"], times, np.column_stack([one, one, np.maximum(length, 1e-6)]))
    moves.place(node["head"], times, np.outer(length, [0.0, 0.0, 1.0]))


def _draw_pushes(
    node: Node,
    moves: Animation,
    body: Multibody,
    walk: Replay,
    hips: float,
    new: bool,
) -> None:
    """Draw the pushes of a walk: an arrow that ends where one acts, for long enough to be seen."""
    if new:
        draw_arrow(node, int(PUSH.lstrip("#"), 16))
    places = body.placements(walk.configuration)[..., :3, 3]
    middle = places[:, [body.leg(foot)[-1] + 1 for foot in (0, 1)]].mean(axis=1)
    along = np.tile([0.0, 0.0, 1e-6], (len(walk.time), 1))
    for push in walk.pushes:
        seen = (walk.time >= push.begins) & (walk.time <= push.begins + PUSH_SEEN)
        size = float(np.linalg.norm(push.impulse))
        along[seen] = np.array(push.impulse) * (_PUSH_LENGTH * hips / size if size > 0.0 else 0.0)
    move_arrow(node, moves, walk.time, middle - along, along)
    shown = np.where(np.linalg.norm(along, axis=1) > 1e-3, 1.0, _HIDDEN)
    moves.stretch(node, walk.time, np.tile(shown[:, None], (1, 3)))


def pressure(samples: TrajectorySamples) -> Array:
    """Return the centre of pressure in the world [m], shape (N, 3): of all feet that stand."""
    local = np.where(samples.contact[..., None], samples.pressure, 0.0)[..., None]
    at = (samples.sole[..., :3, :2] @ local)[..., 0] + samples.sole[..., :3, 3]
    load = np.where(samples.contact, samples.wrench[..., 2], 0.0)
    both = np.asarray(samples.contact.all(axis=1))[:, None]
    share = np.where(both, load / load.sum(axis=1, keepdims=True), samples.contact)
    return np.asarray((share[..., None] * at).sum(axis=1))


def _seen_through(colour: int) -> geometry.Material:
    """Return a material that the robot in front of it does not hide."""
    return geometry.MeshBasicMaterial(
        color=colour, opacity=0.85, transparent=True, depthTest=False, depthWrite=False
    )


def _follow(
    world: Node,
    moves: Animation,
    samples: TrajectorySamples,
    times: Array,
    target: tuple[float, float],
    steady: bool,
) -> None:
    """Move the world back, so that the robot stays in the picture.

    Args:
        samples, times: of the walk, and of the frames [s].
        target: what the camera looks at: to the left of the robot's path, above the ground [m].
        steady: whether at the mean speed; otherwise as the robot moves, smoothed.
    """
    root = samples.base_position[:, :2]
    share = samples.time / samples.time[-1]
    x = root[0, 0] + share * (root[-1, 0] - root[0, 0])
    if not steady:
        near = np.exp(-0.5 * ((samples.time[:, None] - samples.time) / _SMOOTH) ** 2)
        x = near @ root[:, 0] / near.sum(axis=1)
    y = np.full_like(x, root[:, 1].mean() + target[0])
    climb = samples.base_position[-1, 2] - samples.base_position[0, 2]  # a whole walk's, as x
    z = target[1] + share * (climb if abs(climb) > _LEVEL else 0.0)
    path = np.column_stack([x, y, z])
    world.set_transform(_shift(-path[0]))
    moves.place(world, times, -path)


def _centre(body: Multibody, foot: int, height: float) -> Array:
    """Return the middle of a sole in its frame."""
    x, y, _ = body.sole_corners[foot].mean(axis=0)
    return np.array([x, y, height])


def _towards(force: Array) -> Array:
    """Return the rotation that turns z into the direction of a force."""
    size = float(np.linalg.norm(force))
    up = np.array([0.0, 0.0, 1.0])
    return np.array(pin.Quaternion.FromTwoVectors(up, force / size if size > 0.0 else up).matrix())


def _shift(by: ArrayLike) -> Array:
    """Return the homogeneous matrix of a shift."""
    return np.asarray(pin.SE3(np.eye(3), np.asarray(by)).homogeneous)
