"""Optimal walking gaits for bipeds: how to walk at a given speed for the least effort.

Everything a user needs stands here; each name is imported when it is first used, so that
`import gaitopt` costs nothing.
"""

from __future__ import annotations

from importlib import import_module

from gaitopt.version import __version__

TYPE_CHECKING = False  # as type checkers know it; `typing` takes three quarters of this import
if TYPE_CHECKING:
    from gaitopt.actuators.linkages import read_linkages
    from gaitopt.actuators.motors import MotorTable, read_motors
    from gaitopt.catalogue.biped_spec import BipedSpec, biped13
    from gaitopt.catalogue.parameters import read_spec, write_spec
    from gaitopt.catalogue.urdf_writer import urdf_text
    from gaitopt.design.audit import Audit, audit
    from gaitopt.design.certificate import Certificate, certify
    from gaitopt.design.design import compare_solvers
    from gaitopt.design.options import DesignOptions
    from gaitopt.design.pipeline import Design
    from gaitopt.design.replanner import Plan, Replanner
    from gaitopt.design.starts import design_gait, many_starts
    from gaitopt.design.summary import summarise
    from gaitopt.design.transition import audit_transition, design_transition
    from gaitopt.errors import (
        EvaluationError,
        GaitFileError,
        GaitoptError,
        InputError,
        MissingExtraError,
        NoGaitFoundError,
        RobotError,
        SpecError,
        UnreachableError,
    )
    from gaitopt.gait.constraint import Constraint, ConstraintContext, margin
    from gaitopt.gait.constraints import Margins, MotorEnvelope
    from gaitopt.gait.costs import (
        Cost,
        ElectricalEnergy,
        MechanicalWork,
        PositiveWork,
        RunningCost,
        TorqueCost,
        WeightedSum,
    )
    from gaitopt.gait.functions import ComplexStep, Entries, Linear, QuantityFunction, SquaredNorm
    from gaitopt.gait.gait_file import load_gait, save_gait
    from gaitopt.gait.motor_space import MotorSpace
    from gaitopt.gait.plugin import load_plugin
    from gaitopt.gait.presets import preset_task
    from gaitopt.gait.problem import WalkProblem
    from gaitopt.gait.result import Gait
    from gaitopt.gait.task import Task
    from gaitopt.gait.terrain import Profile, Terrain
    from gaitopt.gait.trajectory import Trajectory
    from gaitopt.gait.transition import load_transition, save_transition
    from gaitopt.model.import_options import (
        ImportOptions,
        InertiaOverride,
        LimitOverride,
        PartChange,
        Payload,
        choices_from_toml,
    )
    from gaitopt.model.robot import Robot
    from gaitopt.model.sole import Sole
    from gaitopt.motions.export import export, export_library, export_transition
    from gaitopt.nlp import Status
    from gaitopt.solvers import solver_by_name
    from gaitopt.view.figures import write_figures
    from gaitopt.view.page import page_text, write_page
    from gaitopt.view.scene_server import play

_HOMES = {
    name: f"gaitopt.{home}"
    for home, names in {
        "actuators.linkages": "read_linkages",
        "actuators.motors": "MotorTable read_motors",
        "catalogue.biped_spec": "BipedSpec biped13",
        "catalogue.parameters": "read_spec write_spec",
        "catalogue.urdf_writer": "urdf_text",
        "design.audit": "Audit audit",
        "design.certificate": "Certificate certify",
        "design.design": "compare_solvers",
        "design.options": "DesignOptions",
        "design.pipeline": "Design",
        "design.replanner": "Plan Replanner",
        "design.starts": "design_gait many_starts",
        "design.summary": "summarise",
        "design.transition": "audit_transition design_transition",
        "errors": "EvaluationError GaitFileError GaitoptError InputError "
        "MissingExtraError NoGaitFoundError RobotError SpecError UnreachableError",
        "gait.constraint": "Constraint ConstraintContext margin",
        "gait.constraints": "Margins MotorEnvelope",
        "gait.costs": "Cost ElectricalEnergy MechanicalWork "
        "PositiveWork RunningCost TorqueCost WeightedSum",
        "gait.functions": "ComplexStep Entries Linear QuantityFunction SquaredNorm",
        "gait.gait_file": "load_gait save_gait",
        "gait.motor_space": "MotorSpace",
        "gait.plugin": "load_plugin",
        "gait.presets": "preset_task",
        "gait.problem": "WalkProblem",
        "gait.result": "Gait",
        "gait.task": "Task",
        "gait.terrain": "Profile Terrain",
        "gait.trajectory": "Trajectory",
        "gait.transition": "load_transition save_transition",
        "model.sole": "Sole",
        "model.import_options": "ImportOptions InertiaOverride LimitOverride PartChange Payload "
        "choices_from_toml",
        "model.robot": "Robot",
        "motions.export": "export export_library export_transition",
        "nlp": "Status",
        "solvers": "solver_by_name",
        "view.figures": "write_figures",
        "view.page": "page_text write_page",
        "view.scene_server": "play",
    }.items()
    for name in names.split()
}
"""Module of each public name."""


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'gaitopt' has no attribute '{name}'")
    if _HOMES[name] != "gaitopt.errors":
        import_module("gaitopt.pinocchio_check").require_pinocchio()
    try:
        value: object = getattr(import_module(_HOMES[name]), name)
    except ModuleNotFoundError as error:
        errors = import_module("gaitopt.errors")
        if said := errors.missing_package(error):
            raise errors.InputError(said) from error
        raise
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return __all__


__all__ = [
    "Audit",
    "BipedSpec",
    "Certificate",
    "ComplexStep",
    "Constraint",
    "ConstraintContext",
    "Cost",
    "Design",
    "DesignOptions",
    "ElectricalEnergy",
    "Entries",
    "EvaluationError",
    "Gait",
    "GaitFileError",
    "GaitoptError",
    "ImportOptions",
    "InertiaOverride",
    "InputError",
    "LimitOverride",
    "Linear",
    "Margins",
    "MechanicalWork",
    "MissingExtraError",
    "MotorEnvelope",
    "MotorSpace",
    "MotorTable",
    "NoGaitFoundError",
    "PartChange",
    "Payload",
    "Plan",
    "PositiveWork",
    "Profile",
    "QuantityFunction",
    "Replanner",
    "Robot",
    "RobotError",
    "RunningCost",
    "Sole",
    "SpecError",
    "SquaredNorm",
    "Status",
    "Task",
    "Terrain",
    "TorqueCost",
    "Trajectory",
    "UnreachableError",
    "WalkProblem",
    "WeightedSum",
    "__version__",
    "audit",
    "audit_transition",
    "biped13",
    "certify",
    "choices_from_toml",
    "compare_solvers",
    "design_gait",
    "design_transition",
    "export",
    "export_library",
    "export_transition",
    "load_gait",
    "load_plugin",
    "load_transition",
    "many_starts",
    "margin",
    "page_text",
    "play",
    "preset_task",
    "read_linkages",
    "read_motors",
    "read_spec",
    "save_gait",
    "save_transition",
    "solver_by_name",
    "summarise",
    "urdf_text",
    "write_figures",
    "write_page",
    "write_spec",
]
