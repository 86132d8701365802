"""Gaits in the physics engine MuJoCo: its model, its inverse dynamics, and walks under feedback."""

from gaitopt.errors import MissingExtraError

try:
    import mujoco as _  # noqa: F401  # so that one message is given, wherever it is missing
except ImportError as error:
    raise MissingExtraError("a gait in MuJoCo", "mujoco") from error
