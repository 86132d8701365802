"""What the machine is: its specification, its URDF, and the model made from a URDF."""

from gaitopt.robot.generated.presets import biped13
from gaitopt.robot.generated.spec import BipedSpec, Geometry, JointLimits, Joints, Links, LinkSpec
from gaitopt.robot.generated.spec_file import read_spec, spec_text, write_spec
from gaitopt.robot.generated.spec_table import changed
from gaitopt.robot.generated.urdf import urdf_text

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
