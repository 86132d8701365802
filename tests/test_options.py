"""Dataclasses of options refuse names and kinds of values with advice that works."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from inspect import isfunction, signature
from itertools import chain
from typing import Any, Protocol, TypeVar

import numpy as np
import pytest
from reference_cases import biped
from sample_gait import sample_gait
from typing_extensions import TypeAliasType

import gaitopt
from gaitopt import (
    BipedSpec,
    DesignOptions,
    Entries,
    ImportOptions,
    Margins,
    MotorEnvelope,
    MotorTable,
    Replanner,
    Robot,
    Sole,
    Task,
    TorqueCost,
    WalkProblem,
    WeightedSum,
    audit,
    audit_transition,
    certify,
    choices_from_toml,
    compare_solvers,
    design_gait,
    design_transition,
    export,
    export_transition,
    load_gait,
    many_starts,
    margin,
    page_text,
    play,
    preset_task,
    save_gait,
    save_transition,
    solver_by_name,
    summarise,
    urdf_text,
    write_figures,
    write_spec,
)
from gaitopt.actuators.motors import Drive, Motor
from gaitopt.contact import HeelLine, Phase, Schedule, ToeLine
from gaitopt.design.certificate import RefereeVerdict, WorstRow
from gaitopt.design.codesign import Study, Variable, WalkCase
from gaitopt.errors import InputError, OptionError, RobotError, did_you_mean
from gaitopt.gait.trajectory import FootTurning, StepSequence, TrajectoryPhase
from gaitopt.gait.transition import Transition, WeightShift
from gaitopt.model.import_options import InertiaOverride, LimitOverride, Payload
from gaitopt.model.multibody import Multibody
from gaitopt.motions.motion import motion
from gaitopt.settings import _argument_kinds, checked_arguments, checked_facts
from gaitopt.simulate.battery import Check
from gaitopt.simulate.disturbance import Disturbance, Push, SensorNoise, StartError
from gaitopt.simulate.walk import WalkOptions
from gaitopt.solvers import SLSQP, SQP, Ipopt, TrustConstr, TwoStageSQP
from gaitopt.sweep import parse_axis, sweep


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Task(torque_limit=3), "torque_limit is a margin: preset_task(torque_limit=...)"),
        (lambda: Task(spede=1.0), "Task has no option spede; did you mean 'speed'?"),
        (lambda: Task(*range(40)), "Task: too many positional arguments; its options are speed"),
        (lambda: Task(margins=3), "Task: margins is 3; give Margins"),
        (lambda: Task(geometry=4), "Task: geometry is 4; give a tuple or a list"),
        (lambda: Margins(fricton=0.5), "did you mean 'friction'?"),
        (lambda: DesignOptions(solvr=None), "did you mean 'solver'?"),
        (lambda: DesignOptions(refine="no"), "refine is 'no'; it must be True or False"),
        (lambda: SQP(tolerance="x"), "SQP: tolerance is 'x'; give a number"),
        (lambda: SQP(max_iterations=2.5), "max_iterations is 2.5; give a whole number"),
        (lambda: SQP(max_iterations=True), "max_iterations is True; give a whole number"),
        (lambda: SLSQP(tolerence=1e-3), "SLSQP has no option tolerence; did you mean 'tolerance'?"),
        (lambda: Ipopt(max_iterations="x"), "Ipopt: max_iterations is 'x'; give a whole number"),
        (lambda: TrustConstr(1, 2, 3, 4, 5, 6, 7, 8, 9), "TrustConstr: too many positional"),
        (lambda: TwoStageSQP(first=3), "TwoStageSQP: first is 3; give SQP"),
        (lambda: ImportOptions(sole=3), "ImportOptions: sole is 3; give Sole or None"),
        (lambda: LimitOverride("knee", sped=3.0), "did you mean 'speed'?"),
        (lambda: Payload(), "Payload: missing a required argument: 'link'; its options are link"),
        (lambda: TorqueCost(weight={}), "did you mean 'weights'?"),
        (lambda: WeightedSum(3), "WeightedSum: terms is 3; give a tuple or a list"),
        (lambda: Sole(toe="x", heel=0.0, left=1.0, right=0.0), "Sole: toe is 'x'; give a number"),
        (lambda: BipedSpec(nme="x"), "BipedSpec has no option nme; did you mean 'name'?"),
    ],
)
def test_what_is_no_option_is_told(make, said):
    with pytest.raises(OptionError, match=re.escape(said)) as told:
        make()
    assert isinstance(told.value, InputError)
    assert isinstance(told.value, TypeError)  # which programs may catch


OURS = {"ConstraintContext"}  # which nobody else makes
MADE = [getattr(gaitopt, name) for name in gaitopt.__all__ if name not in OURS]
PARTS = (
    Motor, Drive, Multibody, Transition, WeightShift, FootTurning, TrajectoryPhase, StepSequence,
    Phase, Schedule, ToeLine, HeelLine, RefereeVerdict, WorstRow,
    Variable, WalkCase, Study, Push, SensorNoise, StartError, Disturbance, Check, WalkOptions,
)  # fmt: skip


@pytest.mark.parametrize("kind", [*filter(is_dataclass, MADE), *PARTS])
def test_every_constructor_checks_names_and_kinds(kind):
    with pytest.raises(OptionError, match=f"{kind.__name__} has no option zzz; its options are"):
        kind(zzz=3)
    values = {one.name: object() for one in fields(kind) if one.init}
    with pytest.raises(InputError):  # in Python's words it would be another error
        kind(**values)


def test_arrays_are_known_behind_an_alias():
    """NumPy's `NDArray` is one from version 2.5 on, where every check of an array was lost."""
    scalar = TypeVar("scalar")
    known = np.ndarray[tuple, np.dtype[scalar]]
    alias = TypeAliasType("Alias", known, type_params=(scalar,))[np.float64]
    plain = type("Plain", (), {"__annotations__": {"x": alias}, "__module__": __name__})
    kind = checked_facts(dataclass(frozen=True, eq=False)(plain))
    assert kind(np.zeros(2)).x.shape == (2,)
    with pytest.raises(OptionError, match="Plain: x is 'far'; give "):
        kind("far")


def test_facts_of_other_kinds_are_told(robot):
    gait = sample_gait()
    for make, said in (
        (lambda: Entries(3, 12), "Entries: chosen is 3; give a slice, as slice(2, 3)"),
        (lambda: MotorTable(["knee"]), "give a tuple or a list of Drive"),
        (lambda: Robot("robot.urdf"), "give a Robot, as Robot.from_urdf('robot.urdf')"),
        (lambda: replace(gait, multibody=robot), "Gait: multibody is <Robot"),
        (lambda: replace(gait.trajectory, phases=3), "phases is 3; give a tuple or a list"),
        (lambda: replace(robot, mirror="E"), "mirror is 'E'; give an array of numbers"),
    ):
        with pytest.raises(OptionError, match=re.escape(said)):
            make()
    with pytest.raises(InputError, match="Entries: factor is 'x'; give a number or an array"):
        Entries(slice(3), 12, "x")
    assert Entries(slice(3), np.int64(12), 2).factor == 2  # other numbers are numbers
    assert MotorTable([]).drives == ()


ROW = [0.1, 0.2, 0.3]


def test_lists_are_the_arrays_that_facts_want(robot):
    body = robot.multibody
    same = replace(body, mass=body.mass.tolist(), axis=body.axis.tolist())
    assert repr(same) == repr(body)
    assert same.axis.shape == body.axis.shape
    assert not same.mass.flags.writeable
    for make, said in (
        (lambda: replace(body, mass=[1.0]), r"mass has shape (1,); with 12 joints give (13,)"),
        (lambda: replace(body, mass=3.0), "Multibody: mass has shape ()"),
        (lambda: replace(body, axis=ROW), "axis has shape (3,); with 12 joints give (12, 3)"),
        (
            lambda: replace(body, damping=ROW),
            "damping has shape (3,); with 12 joints give (12, any)",
        ),
        (lambda: replace(body, inertia=[["a"]]), "Multibody: inertia has shape (1, 1)"),
        (
            lambda: replace(body, mass=[[1.0], 2.0]),
            "mass is [[1.0], 2.0]; give an array of numbers",
        ),
        (lambda: Entries(slice(2), 3, [1.0, "a"]), "Entries: factor is "),
        (lambda: Schedule(3), "Schedule: phases is 3; give a tuple or a list of Phase"),
        (lambda: Disturbance(mass="much"), "Disturbance: mass is 'much'; give a number"),
        (lambda: Disturbance(push=3.0), "Disturbance: push is 3.0; give Push or None"),
    ):
        with pytest.raises(OptionError, match=re.escape(said)):
            make()


def test_the_advice_works():
    assert preset_task(torque_limit=80.0).margins.torque_limit == 80.0
    assert Task(margins=Margins(torque_limit=80.0)).margin("torque_limit") == 80.0
    with pytest.raises(InputError, match=re.escape("as solver_by_name('sqp')")):
        DesignOptions(solver="sqp")
    assert DesignOptions(solver=solver_by_name("sqp")).solver == SQP()


def test_what_a_class_says_itself_goes_first():
    with pytest.raises(InputError, match="postures is 'a'; it must be a whole number"):
        Task(postures="a")


NUMBERS = {
    float: (np.float64, np.float32, np.longdouble),
    int: (np.int64, np.int32),
    bool: (np.bool_,),
}


@pytest.mark.parametrize("kind", [Task, Margins, DesignOptions, ImportOptions, SQP, SLSQP])
def test_numbers_of_numpy_are_numbers(kind):
    tried = 0
    for one in fields(kind):
        for make in NUMBERS.get(type(one.default), ()):
            plain = type(one.default)(make(one.default))  # float32 rounds
            made = kind(**{one.name: make(one.default)})
            assert made == kind(**{one.name: plain})
            assert type(getattr(made, one.name)) is type(plain)
            tried += 1
    assert tried


@pytest.mark.parametrize("preset", ["standard", "paper", "humanoid", "robust"])
def test_presets_are_sized_by_numbers_of_numpy_too(robot, preset):
    given = {"speed": np.float32(0.5), "friction": np.float32(0.6), "lateral_gap": np.float64(0.02)}
    given |= {"duration": Fraction(2, 5)}
    plain = {name: float(value) for name, value in given.items()}
    assert preset_task(preset, robot, **given) == preset_task(preset, robot, **plain)
    weighed = TorqueCost({"*knee*": np.float32(2.0)})
    assert weighed == TorqueCost({"*knee*": 2.0})
    assert type(weighed.weights["*knee*"]) is float


def test_what_was_said_is_not_what_may_have_been_meant(robot):
    assert did_you_mean("arms", ["arms", "arm"]) == "did you mean 'arm'? "
    with pytest.raises(RobotError, match="is meant by 'arms'; give arms, waist or"):
        Robot.from_urdf(robot.urdf, moving=("arms",))


@pytest.mark.parametrize(
    ("name", "known", "meant"),
    [
        ("left_foot", "right_foot", ""),
        ("lower_leg_L", "lower_leg_R", ""),
        ("Left_Foot", "left_foot", "left_foot"),
        ("left_knee", "l_knee", "l_knee"),
        ("pelvis_l", "pelvis", "pelvis"),
        ("Pelvis", "pelvis", "pelvis"),
    ],
)
def test_no_name_of_the_other_side_is_meant(name, known, meant):
    assert did_you_mean(name, [known]) == (f"did you mean '{meant}'? " if meant else "")


def test_arrays_are_lists_of_numbers():
    along, box = np.array([0, 0, 1]), np.array([0.1, 0.2, 0.3], dtype=np.float32)
    assert ImportOptions(up=along) == ImportOptions(up=(0, 0, 1))
    assert Payload("torso", 5.0, along, box) == Payload("torso", 5.0, (0, 0, 1), box.tolist())
    com, inertia = np.array([0.1, 0.0, 0.2]), np.array([1e-3, 2e-3, 2e-3, 0.0, 0.0, 0.0])
    given = InertiaOverride("*foot*", com=com, inertia=inertia)
    assert given == InertiaOverride("*foot*", com=tuple(com), inertia=tuple(inertia))
    assert hash(given)


class NoGait:
    """Stands for a design, whose gait was meant."""


NO_GAIT = [
    audit,
    audit_transition,
    summarise,
    page_text,
    play,
    design_transition,
    lambda gait: design_transition(None, gait),
    lambda gait: save_gait(gait, "walk.npz"),
    lambda gait: save_transition(gait, "walk.npz"),
    lambda gait: export(gait, "walk.csv"),
    lambda gait: export_transition(gait, "walk.npz", format="motion"),
    lambda gait: write_figures(gait, "figures"),
]


@pytest.mark.parametrize("use", NO_GAIT)
def test_what_is_no_gait_is_refused(use, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for given in (NoGait(), "walk.npz"):
        with pytest.raises(OptionError, match=r"give a (Gait|Transition): load_|give a Gait"):
            use(given)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("use", "said"),
    [
        (lambda r: design_gait("r.urdf"), "design_gait: robot is 'r.urdf'; give a Robot, as"),
        (lambda r: many_starts(3), "robot is 3; give a Robot"),
        (lambda r: compare_solvers(None), "robot is None; give a Robot"),
        (lambda r: preset_task("standard", 3), "robot is 3; give a Robot"),
        (lambda r: WalkProblem(None, Task()), "WalkProblem: robot is None; give a Robot"),
        (lambda r: Replanner().replan(r, "humanoid"), "Replanner.replan: task is 'humanoid'; give"),
        (lambda r: design_gait(r, "humanoid"), "task is 'humanoid'; give a Task"),
        (lambda r: design_gait(r, Task(), 3), "options is 3; give DesignOptions(...)"),
        (lambda r: many_starts(r, count=2.5), "count is 2.5; give a whole number"),
        (lambda r: many_starts(r, seed="a"), "seed is 'a'; give a whole number"),
        (lambda r: compare_solvers(r, Task(), [3]), "give a list of texts or Solver"),
        (lambda r: compare_solvers(r, Task(), {3}), "give a list of texts or Solver"),
        (lambda r: Replanner().replan(r, Task(), deadline="1"), "is '1'; give a number or None"),
        (lambda r: certify(3, np.zeros(2)), "problem is 3; give a WalkProblem"),
        (lambda r: Task().with_margins(3), "margins is 3; give a table by name"),
        (lambda r: Robot.from_urdf(r.urdf, choices="c.toml"), "choices is 'c.toml'; give Import"),
        (lambda r: choices_from_toml(None), "toml is None; give a text or a path"),
        (lambda r: urdf_text(r), "spec is <Robot"),
        (lambda r: motion(sample_gait(), "50"), "rate is '50'; give a number"),
        (lambda r: motion(sample_gait(), 50.0, "2"), "strides is '2'; give a number"),
        (lambda r: motion(sample_gait(), 50.0, joints=3), "give a text or a list of texts"),
        (lambda r: write_spec("x", "x.toml"), "spec is 'x'; give a BipedSpec, as biped13()"),
        (lambda r: page_text(sample_gait(), steps=2.5), "steps is 2.5; give a whole"),
        (lambda r: load_gait(None), "load_gait: path is None; give a text or a path"),
        (lambda r: load_gait("x.npz", verfy=True), "did you mean 'verify'? its arguments are path"),
        (lambda r: load_gait("x.npz", verify=np.zeros(2)), "verify is array([0., 0.]); give True"),
        (lambda r: design_gait(r, stop=3), "stop is 3; give a function"),
        (lambda r: Replanner(3), "Replanner: options is 3; give DesignOptions(...) or None"),
        (lambda r: Replanner().replan(r, Task(), stop=3), "stop is 3; give a function"),
        (lambda r: WalkProblem(r), "WalkProblem: missing a required argument: 'task'; its arg"),
        (lambda r: WalkProblem(r, Task(), 3), "grid is 3; give Grid or None"),
        (lambda r: page_text(sample_gait(), 6, "x"), "give a tuple or a list of texts or paths"),
        (lambda r: page_text(sample_gait(), 6, (None,)), "give a tuple or a list of texts"),
        (lambda r: WeightedSum((3,)), "WeightedSum: terms is (3,); give a tuple or a list"),
        (lambda r: Task(geometry="ab"), "Task: geometry is 'ab'; give a tuple or a list of G"),
        (lambda r: MotorEnvelope(zzz=3), "MotorEnvelope has no option zzz; its options are motors"),
    ],
)  # fmt: skip
def test_what_is_of_another_kind_is_refused(robot, use, said):
    with pytest.raises(OptionError, match=re.escape(said)):
        use(robot)


@pytest.mark.parametrize(
    ("use", "said"),
    [
        (
            lambda r: write_figures(sample_gait(), "a\0b"),
            "cannot make the directory 'a\0b':",
        ),
        (lambda r: play(sample_gait(), host="a\0b"), "the host is 'a\\x00b'; give an"),
        (lambda r: Robot.from_urdf(r.urdf, stance_sole="\ud800"), "no frame named '\ud800'"),
        (lambda r: Replanner().replan(r, Task(), deadline=np.nan), "the deadline is nan s; give"),
        (lambda r: Task(geometry=[]), "geometry is []; give a table of all quantities, as set_geo"),
    ],
)
def test_what_is_of_the_kind_and_cannot_be_is_refused(robot, use, said):
    with pytest.raises(InputError, match=re.escape(said)):
        use(robot)


class Untold(Protocol):
    """A protocol of which nobody can ask whether something is one."""


@checked_arguments
def _with_kinds_that_nobody_can_tell(
    any_one: Any, table: Mapping[str, Any], some: Iterable[Untold] = (), one: Untold | None = None
) -> None:
    """Have an argument of every such kind."""


def test_what_nobody_can_tell_is_let_through():
    _with_kinds_that_nobody_can_tell(3, {"a": object()}, [3], 3)
    with pytest.raises(OptionError, match="table is 3; give a table by name"):
        _with_kinds_that_nobody_can_tell(3, 3)
    with pytest.raises(OptionError, match="some is 'ab'; give a list of Untold"):
        _with_kinds_that_nobody_can_tell(3, {}, "ab")


@pytest.mark.parametrize("name", [n for n in gaitopt.__all__ if isfunction(getattr(gaitopt, n))])
def test_every_argument_of_a_public_function_is_checked(name):
    function = getattr(gaitopt, name)
    needed = list(signature(function).parameters.values())
    if needed:
        named = {one.name for one in needed if one.kind is not one.VAR_KEYWORD}
        assert named == set(_argument_kinds(function.__wrapped__))
        values = {one.name: object() for one in needed if one.default is one.empty}
        with pytest.raises(OptionError, match=f"{name}: {needed[0].name} is <object"):
            function(**{needed[0].name: object(), **values})


def test_what_is_read_twice_is_no_generator(tmp_path):
    gait, formats = sample_gait(), ["svg"]
    with pytest.raises(OptionError, match=r"give a list of texts, as list\(\.\.\.\) makes it"):
        write_figures(gait, tmp_path, (one for one in formats), ["cop"])
    assert write_figures(gait, tmp_path, list(one for one in formats), ["cop"])  # noqa: C400
    axes = (parse_axis("speed", text) for text in ["0.5"])
    with pytest.raises(InputError, match="each only once"):  # what is read once may be one
        sweep(biped(), Task(), chain(axes, [parse_axis("speed", "0.5")]), tmp_path)


def test_lists_of_any_kind_are_lists():
    names = list(sample_gait().joint_names)
    once = motion(sample_gait(), 50.0, joints=names)
    for joints in (dict.fromkeys(names), dict.fromkeys(names).keys(), np.array(names)):
        assert motion(sample_gait(), 50.0, joints=joints).joint_names == once.joint_names
    relax = np.array([0.5, 0.1])
    assert margin(0.2, "", relax=relax).metadata == margin(0.2, "", relax=(0.5, 0.1)).metadata


@pytest.mark.parametrize("relax", [(0.1, 0.5), (0.5, -0.1), (0.5, 0.0), (np.nan, 0.1)])
def test_a_margin_is_not_loosened_the_wrong_way_round(relax):
    with pytest.raises(InputError, match=r"relax of a margin of 0.2 is \(.*give the farthest"):
        margin(0.2, "", relax=relax)
    assert margin(0.05, "", relax=(0.0, -0.01))  # as it says
    with pytest.raises(InputError, match="least is 2 and most is 1; swap them"):
        margin(1.5, "", least=2.0, most=1.0)


def test_parameters_of_any_kind_of_numbers_are_those_parameters(sampled_design):
    problem, x = sampled_design.problem, sampled_design.solution.x
    rough = x.astype(np.float32)
    views = np.repeat(rough, 2)[::2], rough.astype(np.float64), rough.tolist()
    costs = {problem.with_grid(problem.grid).point(one).cost for one in (rough, *views)}
    assert costs == {problem.with_grid(problem.grid).point(views[1]).cost}
    assert certify(problem, rough).cost == certify(problem, views[1]).cost
    for wrong in (x[1:], x[:, None], "x"):
        with pytest.raises(InputError, match=f"give {x.size} finite numbers, in the order of"):
            problem.point(wrong)
