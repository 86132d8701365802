import coal
import numpy as np
import pinocchio as pin
import pytest
from sample_gait import sample_gait

from gaitopt.view.body import walking_model
from gaitopt.view.meshcat_quiet import meshcat, umsgpack
from gaitopt.view.moving_robot import draw_robot, draw_still
from gaitopt.view.recorder import Recorder
from gaitopt.view.shapes import robot_shapes
from gaitopt.view.tracks import Film
from gaitopt.view.walk import walk

GAIT = sample_gait()
MODEL = walking_model(GAIT)
SHAPES = robot_shapes(GAIT, MODEL).geometry
SHAPES.geometryObjects[3].meshScale = np.array([1.5, -0.5, 0.8])


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
    recorder, film = Recorder(), Film()
    viewer = meshcat.Visualizer(window=recorder)
    shown = walk(GAIT, MODEL, 2)
    times = np.arange(len(shown.time), dtype=float)
    draw_robot(viewer["robot"], film, MODEL, SHAPES, shown, times)
    film.show(viewer)
    still = transforms(recorder)
    clips = commands(recorder)[-1]["animations"]
    tracks = {c["path"]: {t["name"]: t["keys"] for t in c["clip"]["tracks"]} for c in clips}
    assert len(tracks) == 13  # trunk and the twelve links of the legs
    for frame in (0, 17, 45):
        for item, place in zip(SHAPES.geometryObjects, expected(shown.q[frame]), strict=True):
            (path,) = [p for p in still if p.endswith(f"/{item.name}")]
            keys = tracks[path.rpartition("/")[0]]
            turn = pin.Quaternion(np.array(keys[".quaternion"][frame]["value"])).matrix()
            carrier = pin.SE3(turn, np.array(keys[".position"][frame]["value"])).homogeneous
            assert carrier @ still[path] == pytest.approx(place @ upright(item), abs=1e-9)


def test_a_robot_stands_where_its_joints_are():
    recorder = Recorder()
    data = MODEL.createData()
    q = walk(GAIT, MODEL, 1).q[5]
    pin.forwardKinematics(MODEL, data, q)
    draw_still(meshcat.Visualizer(window=recorder)["robot"], MODEL, data, SHAPES)
    still = transforms(recorder)
    for item, place in zip(SHAPES.geometryObjects, expected(q), strict=True):
        (path,) = [p for p in still if p.endswith(f"/{item.name}")]
        assert still[path] == pytest.approx(place @ upright(item), abs=1e-12)
