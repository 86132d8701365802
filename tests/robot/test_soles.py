import numpy as np
import pinocchio as pin
import pytest

from gaitopt.errors import RobotError
from gaitopt.robot.soles import Sole, sole_from_collision

FOOT = """<robot name='foot'>
<link name='base'/><link name='foot'>
 <inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>
 <collision><origin xyz='{xyz}' rpy='{rpy}'/><geometry>{shape}</geometry></collision>
</link><link name='sole'/>
<joint name='ankle' type='revolute'><parent link='base'/><child link='foot'/><axis xyz='1 0 0'/>
 <limit effort='1' velocity='1' lower='-1' upper='1'/></joint>
<joint name='mount' type='fixed'><parent link='foot'/><child link='sole'/>
 <origin xyz='0.1 0.02 -0.07' rpy='{sole_rpy}'/></joint></robot>"""
BOX = "<box size='0.2 0.1 0.04'/>"


def read(xyz: str, shape: str = BOX, rpy: str = "0 0 0", sole_rpy: str = "0 0 0") -> Sole:
    text = FOOT.format(xyz=xyz, shape=shape, rpy=rpy, sole_rpy=sole_rpy)
    model = pin.buildModelFromXML(text)
    geometry = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    return sole_from_collision(model, geometry, "sole")


def test_corners_start_at_the_toes_on_the_left():
    corners = Sole(toe=0.05, heel=-0.15, left=0.06, right=-0.04).corners
    expected = [[0.05, 0.06, 0], [0.05, -0.04, 0], [-0.15, 0.06, 0], [-0.15, -0.04, 0]]
    np.testing.assert_array_equal(corners, expected)


@pytest.mark.parametrize(
    ("toe", "heel", "left", "right"), [(-0.2, 0.1, 0.05, -0.05), (0.1, -0.2, -0.05, 0.05)]
)
def test_an_empty_rectangle_is_refused(toe, heel, left, right):
    with pytest.raises(RobotError, match=r"sole rectangle is empty.*toe must exceed heel"):
        Sole(toe, heel, left, right)


def test_the_lower_face_in_the_sole_frame():
    # Box 0.2 x 0.1, centre 0.05 m behind and 0.02 m right of the sole frame, lower face at -0.07.
    assert read("0.05 0.0 -0.05") == Sole(toe=0.05, heel=-0.15, left=0.03, right=-0.07)


def test_a_turned_box_is_measured_in_the_sole_frame():
    quarter = "0 0 1.5707963267948966"
    assert read("0.1 0.02 -0.05", rpy=quarter) == Sole(0.05, -0.05, 0.1, -0.1)
    # Seen from a sole frame that is turned as the box, it is as long as it was.
    assert read("0.1 0.02 -0.05", rpy=quarter, sole_rpy=quarter) == Sole(0.1, -0.1, 0.05, -0.05)


@pytest.mark.parametrize(
    ("xyz", "shape"),
    [("0.1 0.02 -0.03", BOX), ("0.1 0.02 -0.05", "<sphere radius='0.02'/>")],
    ids=["box above the sole", "no box"],
)
def test_a_foot_without_a_sole_asks_for_one(xyz, shape):
    with pytest.raises(RobotError, match=r"frame 'sole'; give the sole rectangle: .*sole=Sole\("):
        read(xyz, shape)
