import coal
import numpy as np
import pinocchio as pin
import pytest
from sample_gait import sample_gait

from gaitopt.importers.reader import read_source
from gaitopt.view.animation import Animation, draw_robot, frames
from gaitopt.view.inspection_page import draw_still
from gaitopt.view.robot_shapes import robot_shapes
from gaitopt.view.viewer import Node, RecordingWindow, umsgpack

GAIT = sample_gait()
SOURCE = read_source(GAIT.urdf)
MODEL = SOURCE.model()
SHAPES = SOURCE.geometry(pin.GeometryType.VISUAL)
DRAWN = robot_shapes(GAIT)
for items in (SHAPES.geometryObjects, [item for _, item, _ in DRAWN.shapes]):
    items[3].meshScale = np.array([1.5, -0.5, 0.8])


def configuration(samples, frame):
    """Of the model of the file."""
    q = pin.neutral(MODEL)
    q[:7] = samples.configuration[frame, :7]
    for name, angle in zip(GAIT.trajectory.joint_names, samples.q[frame], strict=True):
        q[MODEL.joints[MODEL.getJointId(name)].idx_q] = angle
    return q


def expected(q):
    """Pinocchio's own placement of each shape, with its scale."""
    data, drawn = MODEL.createData(), SHAPES.createData()
    pin.updateGeometryPlacements(MODEL, data, SHAPES, drawn, q)
    scaled = [np.diag([*item.meshScale, 1.0]) for item in SHAPES.geometryObjects]
    return [m.homogeneous @ s for m, s in zip(drawn.oMg, scaled, strict=True)]


def upright(item):
    """From MeshCat's cylinders, along y, to Pinocchio's, along z."""
    turned = isinstance(item.geometry, coal.Cylinder | coal.Cone)
    turn = pin.SE3(pin.utils.rotate("x", np.pi / 2.0), np.zeros(3)).homogeneous
    return turn if turned else np.eye(4)


def commands(recorder):
    return [umsgpack.unpackb(c) for c in recorder.commands]


def transforms(recorder):
    """The last transform of each node; the viewer reads matrices column by column."""
    moved = [c for c in commands(recorder) if c["type"] == "set_transform"]
    return {c["path"]: np.reshape(c["matrix"], (4, 4)).T for c in moved}


def test_every_shape_moves_as_its_link():
    recorder, moves = RecordingWindow(), Animation()
    viewer = Node(recorder)
    samples = frames(GAIT, 2)
    times = np.arange(len(samples.time), dtype=float)
    body = GAIT.trajectory.body
    draw_robot(viewer["robot"], moves, body, DRAWN, samples.configuration, times)
    moves.show(viewer, whole=True)
    still = transforms(recorder)
    clips = commands(recorder)[-1]["animations"]
    tracks = {c["path"]: {t["name"]: t["keys"] for t in c["clip"]["tracks"]} for c in clips}
    assert len(tracks) == 13  # trunk and the twelve links of the legs
    for frame in (0, 17, 45):
        for item, place in zip(
            SHAPES.geometryObjects, expected(configuration(samples, frame)), strict=True
        ):
            (path,) = [p for p in still if p.endswith(f"/{item.name}")]
            keys = tracks[path.rpartition("/")[0]]
            turn = pin.Quaternion(np.array(keys[".quaternion"][frame]["value"])).matrix()
            carrier = pin.SE3(turn, np.array(keys[".position"][frame]["value"])).homogeneous
            assert carrier @ still[path] == pytest.approx(place @ upright(item), abs=1e-9)


def test_a_robot_stands_where_its_joints_are():
    recorder = RecordingWindow()
    data = MODEL.createData()
    q = configuration(frames(GAIT, 1), 5)
    pin.forwardKinematics(MODEL, data, q)
    draw_still(Node(recorder)["robot"], MODEL, data, SHAPES)
    still = transforms(recorder)
    for item, place in zip(SHAPES.geometryObjects, expected(q), strict=True):
        (path,) = [p for p in still if p.endswith(f"/{item.name}")]
        assert still[path] == pytest.approx(place @ upright(item), abs=1e-12)
