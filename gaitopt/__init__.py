"""Optimal walking gaits for bipeds: how to walk at a given speed for the least effort.

Everything a user needs stands here; each name is imported when it is first used, so that
`import gaitopt` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from gaitopt.version import __version__

if TYPE_CHECKING:
    from gaitopt.actuators.linkages import read_linkages
    from gaitopt.actuators.motors import MotorTable, read_motors
    from gaitopt.catalogue.biped_spec import BipedSpec, biped13
    from gaitopt.catalogue.parameters import read_spec, write_spec
    from gaitopt.catalogue.urdf_writer import urdf_text
    from gaitopt.design.audit import Audit, audit
    from gaitopt.design.certificate import Certificate, certify
    from gaitopt.design.compare import compare_solvers
    from gaitopt.design.design import Design
    from gaitopt.design.options import DesignOptions
    from gaitopt.design.replanner import Plan, Replanner
    from gaitopt.design.starts import design_gait, many_starts
    from gaitopt.design.summary import summarise
    from gaitopt.design.transition import design_transition
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
    from gaitopt.model.feet.sole import Sole
    from gaitopt.model.import_options import ImportOptions, choices_from_toml
    from gaitopt.model.robot import Robot
    from gaitopt.motions.export import export, export_library, export_transition
    from gaitopt.nlp import Status
    from gaitopt.solvers import solver_by_name
    from gaitopt.view.figures import write_figures
    from gaitopt.view.page import page_text, write_page
    from gaitopt.view.player import play

_HOMES = {
    # the machine
    "BipedSpec": "gaitopt.catalogue.biped_spec",
    "ImportOptions": "gaitopt.model.import_options",
    "Robot": "gaitopt.model.robot",
    "Sole": "gaitopt.model.feet.sole",
    "MotorSpace": "gaitopt.gait.motor_space",
    "MotorTable": "gaitopt.actuators.motors",
    "biped13": "gaitopt.catalogue.biped_spec",
    "choices_from_toml": "gaitopt.model.import_options",
    "read_linkages": "gaitopt.actuators.linkages",
    "read_motors": "gaitopt.actuators.motors",
    "read_spec": "gaitopt.catalogue.parameters",
    "urdf_text": "gaitopt.catalogue.urdf_writer",
    "write_spec": "gaitopt.catalogue.parameters",
    # the question
    "Margins": "gaitopt.gait.constraints",
    "Task": "gaitopt.gait.task",
    "WalkProblem": "gaitopt.gait.problem",
    "preset_task": "gaitopt.gait.presets",
    # constraints, costs and grounds of one's own
    "ComplexStep": "gaitopt.gait.functions",
    "Constraint": "gaitopt.gait.constraint",
    "ConstraintContext": "gaitopt.gait.constraint",
    "Cost": "gaitopt.gait.costs",
    "ElectricalEnergy": "gaitopt.gait.costs",
    "Entries": "gaitopt.gait.functions",
    "Linear": "gaitopt.gait.functions",
    "load_plugin": "gaitopt.gait.plugin",
    "margin": "gaitopt.gait.constraint",
    "MechanicalWork": "gaitopt.gait.costs",
    "MotorEnvelope": "gaitopt.gait.constraints",
    "PositiveWork": "gaitopt.gait.costs",
    "Profile": "gaitopt.gait.terrain",
    "QuantityFunction": "gaitopt.gait.functions",
    "RunningCost": "gaitopt.gait.costs",
    "SquaredNorm": "gaitopt.gait.functions",
    "Terrain": "gaitopt.gait.terrain",
    "TorqueCost": "gaitopt.gait.costs",
    "WeightedSum": "gaitopt.gait.costs",
    # the answer
    "Audit": "gaitopt.design.audit",
    "Certificate": "gaitopt.design.certificate",
    "Design": "gaitopt.design.design",
    "DesignOptions": "gaitopt.design.options",
    "Gait": "gaitopt.gait.result",
    "Plan": "gaitopt.design.replanner",
    "Replanner": "gaitopt.design.replanner",
    "Status": "gaitopt.nlp",
    "Trajectory": "gaitopt.gait.trajectory",
    "audit": "gaitopt.design.audit",
    "certify": "gaitopt.design.certificate",
    "compare_solvers": "gaitopt.design.compare",
    "design_gait": "gaitopt.design.starts",
    "design_transition": "gaitopt.design.transition",
    "load_gait": "gaitopt.gait.gait_file",
    "many_starts": "gaitopt.design.starts",
    "save_gait": "gaitopt.gait.gait_file",
    "solver_by_name": "gaitopt.solvers",
    "summarise": "gaitopt.design.summary",
    # what people look at
    "export": "gaitopt.motions.export",
    "export_library": "gaitopt.motions.export",
    "page_text": "gaitopt.view.page",
    "export_transition": "gaitopt.motions.export",
    "play": "gaitopt.view.player",
    "write_figures": "gaitopt.view.figures",
    "write_page": "gaitopt.view.page",
    # what can go wrong
    "EvaluationError": "gaitopt.errors",
    "GaitFileError": "gaitopt.errors",
    "GaitoptError": "gaitopt.errors",
    "InputError": "gaitopt.errors",
    "MissingExtraError": "gaitopt.errors",
    "NoGaitFoundError": "gaitopt.errors",
    "RobotError": "gaitopt.errors",
    "SpecError": "gaitopt.errors",
    "UnreachableError": "gaitopt.errors",
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'gaitopt' has no attribute '{name}'")
    if _HOMES[name] != "gaitopt.errors":
        import_module("gaitopt.pinocchio_check").require_pinocchio()
    value: object = getattr(import_module(_HOMES[name]), name)
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
    "InputError",
    "Linear",
    "Margins",
    "MechanicalWork",
    "MissingExtraError",
    "MotorEnvelope",
    "MotorSpace",
    "MotorTable",
    "NoGaitFoundError",
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
    "many_starts",
    "margin",
    "page_text",
    "play",
    "preset_task",
    "read_linkages",
    "read_motors",
    "read_spec",
    "save_gait",
    "solver_by_name",
    "summarise",
    "urdf_text",
    "write_figures",
    "write_page",
    "write_spec",
]
