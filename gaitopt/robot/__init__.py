"""What the machine is: its specification, its URDF, and the model made from a URDF."""

from gaitopt.robot.presets import biped13
from gaitopt.robot.spec import BipedSpec, Geometry, JointLimits, Joints, Links, LinkSpec
from gaitopt.robot.spec_file import read_spec, spec_text, write_spec
from gaitopt.robot.spec_table import changed
from gaitopt.robot.urdf import urdf_text

__all__ = [
    "BipedSpec",
    "Geometry",
    "JointLimits",
    "Joints",
    "LinkSpec",
    "Links",
    "biped13",
    "changed",
    "read_spec",
    "spec_text",
    "urdf_text",
    "write_spec",
]
