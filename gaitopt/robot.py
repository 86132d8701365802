"""Names of version 0.1: `gaitopt.robot` and `gaitopt.robot.choices_file`; deprecated."""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from types import ModuleType

_SPEC = "gaitopt.catalogue.biped_spec"
_HOMES = {
    **dict.fromkeys(("BipedSpec", "Geometry", "Joints", "LinkSpec", "Links"), _SPEC),
    "JointLimits": f"{_SPEC}:JointSpec",
    "biped13": _SPEC,
    "changed": "gaitopt.catalogue.parameters",
    **dict.fromkeys(("read_spec", "spec_text", "write_spec"), "gaitopt.catalogue.spec_file"),
    "urdf_text": "gaitopt.catalogue.urdf_writer",
}


def __getattr__(name: str) -> object:
    """Return a name from where it is today."""
    if name not in _HOMES:
        raise AttributeError(f"module 'gaitopt.robot' has no attribute '{name}'")
    return _moved(name, _HOMES[name])


class _ChoicesFile(ModuleType):
    def __getattr__(self, name: str) -> object:
        if name not in ("choices_from_record", "choices_from_toml", "choices_record"):
            raise AttributeError(f"module '{self.__name__}' has no attribute '{name}'")
        return _moved(name, "gaitopt.model.import_options")


def _moved(name: str, home: str) -> object:
    module, _, renamed = home.partition(":")
    warnings.warn(f"{name} is {renamed or name} in {module} now", DeprecationWarning, stacklevel=3)
    return getattr(import_module(module), renamed or name)


choices_file = sys.modules[f"{__name__}.choices_file"] = _ChoicesFile(f"{__name__}.choices_file")
