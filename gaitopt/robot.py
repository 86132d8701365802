"""The old name of robots' modules, for programs that were written for version 0.1."""

from __future__ import annotations

import sys
import warnings
from importlib import import_module

from gaitopt.catalogue.biped_spec import BipedSpec, Geometry, Joints, Links, LinkSpec, biped13
from gaitopt.catalogue.biped_spec import JointSpec as JointLimits
from gaitopt.catalogue.parameters import changed, read_spec, spec_text, write_spec
from gaitopt.catalogue.urdf_writer import urdf_text

warnings.warn(
    "gaitopt.robot is now gaitopt.importers (files), gaitopt.model (bipeds) and gaitopt.catalogue",
    DeprecationWarning,
    stacklevel=2,
)
sys.modules[f"{__name__}.choices_file"] = import_module("gaitopt.model.import_options")

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
