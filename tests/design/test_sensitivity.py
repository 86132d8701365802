"""Sensitivities of optimal walks against walks of changed robots and tasks, solved again."""

from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from changed_robots import changed as changed_robot
from example_robots import needs_example_robots
from one_motor import ONE_MOTOR
from reference_cases import reference_task

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.catalogue.parameters import PARAMETERS, changed
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.relaxation import limit_adjustments, step_width_adjustment
from gaitopt.design.robot_changes import Anatomy
from gaitopt.design.sensitivity import Envelope, sensitivities
from gaitopt.design.shadow_prices import LIMIT, SETTING, shadow_prices
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import ElectricalEnergy
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.model_gradient import OF_ROBOT
from gaitopt.gait.parameters import GEOMETRY, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.robot import Robot
from gaitopt.nlp import Rows, Start
from gaitopt.solvers import solver_by_name

TIGHT = solver_by_name("sqp", tolerance=1e-9)
QUICK = DesignOptions(solver=TIGHT, refine=False)
CLOSE = 1e-5  # relative: what the issue asks for


class Walk:
    """An optimal walk that is solved again with something changed."""

    def __init__(self, robot, task):
        found = design(robot, task, QUICK)
        self.robot, self.problem = robot, found.problem
        self.found = found.solution
        again = TIGHT.solve(self.problem, Start(self.found.x, self.found.multipliers))
        self.x, self.multipliers = again.x, again.multipliers
        self.bound_multipliers = again.bound_multipliers
        self.report = sensitivities(self.problem, again.x, (again.multipliers,
                                                            again.bound_multipliers))  # fmt: skip

    def cost(self, robot=None, task=None):
        """Of the optimal walk of another robot or task."""
        problem = WalkProblem(robot or self.robot, task or self.problem.task, self.problem.grid)
        return self.solved(problem).cost

    def solved(self, problem):
        """The optimal walk of a problem near this one."""
        found = TIGHT.solve(problem, Start(self.x, self.multipliers))
        assert found.optimality <= 1e-8
        return found

    def difference(self, make, step):
        """Of the optimal cost, central, per unit of what `make` changes."""
        return (self.cost(**make(step)) - self.cost(**make(-step))) / (2.0 * step)


@pytest.fixture(scope="module")
def biped(robot):
    return Walk(robot, reference_task(speed=1.0, duration=0.4))


@pytest.mark.parametrize(
    "name",
    [
        "shin", "thigh", "hip_width", "ankle_height", "foot_length", "foot_width", "trunk_mass",
        "thigh_mass", "shin_mass", "foot_mass",
    ],
)  # fmt: skip
def test_of_the_biped_by_words(biped, name):
    value = PARAMETERS[name].value(biped13())

    def other(step):
        text = urdf_text(changed(biped13(), {name: value + step}))
        return {"robot": Robot.from_urdf(text)}

    found = biped.report.of(name.replace("_", " ")).per_unit
    if name in ("foot_length", "foot_width"):
        step = 1e-3 * value  # the sole is written in micrometres, which are kept whole here
        once, twice = biped.difference(other, step), biped.difference(other, 2.0 * step)
        expected = (4.0 * once - twice) / 3.0
    else:
        expected = biped.difference(other, 1e-4 * value)
    assert found == pytest.approx(expected, rel=CLOSE)


def test_of_centres_and_inertias_of_the_biped(biped):
    link = biped13().links.shin

    def centre(step):
        com = (link.com[0] + step, *link.com[1:])
        return {"robot": Robot.from_urdf(urdf_text(changed(biped13(), {"links.shin.com": com})))}

    def inertia(step):
        own = np.array(link.com_inertia) + np.diag([0.0, step, 0.0])
        change = {"links.shin.inertia": tuple(map(tuple, own))}
        return {"robot": Robot.from_urdf(urdf_text(changed(biped13(), change)))}

    for name, make, step in (
        ("shin centre forward", centre, 1e-5), ("shin inertia, pitch", inertia, 1e-6),
    ):  # fmt: skip
        found = biped.report.of(name).per_unit
        assert found == pytest.approx(biped.difference(make, step), rel=CLOSE)


@pytest.mark.parametrize("name", ["speed", "duration", "slope"])
def test_of_the_task_of_the_biped(biped, name):
    task = biped.problem.task

    def other(step):
        return {"task": replace(task, **{name: getattr(task, name) + step})}

    found = biped.report.of(name).per_unit
    assert found == pytest.approx(biped.difference(other, 1e-5), rel=CLOSE)


def test_a_step_and_its_share_and_speed(biped):
    shin, speed = biped.report.of("shin"), biped.report.of("speed")
    assert shin.step == 0.01
    assert shin.share == pytest.approx(shin.per_unit * 0.01 / biped.report.cost)
    assert shin.speed == pytest.approx(-shin.per_unit * 0.01 / speed.per_unit)
    assert speed.speed == pytest.approx(-speed.step)
    shares = [abs(one.share) for one in biped.report.found]
    assert shares == sorted(shares, reverse=True)
    assert len({one.name for one in biped.report.found}) == len(shares) > 60


def test_on_stairs_with_a_load(robot):
    task = preset_task(speed=0.5, duration=0.6, stairs=0.1, samples=25)
    stairs = Walk(robot, task)

    def other(name):
        return lambda step: {"task": replace(task, **{name: getattr(task, name) + step})}

    for name in ("speed", "duration", "stairs"):
        found = stairs.report.of(name).per_unit
        assert found == pytest.approx(stairs.difference(other(name), 1e-5), rel=CLOSE), name

    def foot(step):
        spec = changed(biped13(), {"foot_length": 0.214 * (1.0 + step)})
        return {"robot": Robot.from_urdf(urdf_text(spec))}

    found = stairs.report.of("foot length").per_unit
    assert found * 0.214 == pytest.approx(stairs.difference(foot, 1e-3), rel=1e-4)


def test_of_gear_ratios_with_envelopes_and_electrical_energy():
    def driven(knee):
        table = ONE_MOTOR.apart("*knee*", ["right_knee", "left_knee"])
        table = table.changed({"*knee*.ratio": knee})
        motors = table.at_joints
        task = preset_task(
            speed=0.8, duration=0.45, samples=25,
            cost=ElectricalEnergy(motors=motors), constraints=[MotorEnvelope(motors=motors)],
        )  # fmt: skip
        robot = Robot.from_urdf(urdf_text(biped13()), choices=ImportOptions(limits=table.rotors()))
        return {"robot": robot, "task": task}

    walk = Walk(**driven(12.0))
    found = walk.report.of("gear ratio of '*knee*'").per_unit
    expected = walk.difference(lambda step: driven(12.0 * np.exp(step)), 1e-4)
    assert found == pytest.approx(expected, rel=CLOSE)


@pytest.fixture(scope="module")
def g1():
    source, choices = description(entry_by_name("g1"))
    robot = Robot.from_urdf(source, choices=choices)
    return Walk(robot, preset_task("humanoid", robot, speed=0.6, trunk_yaw=None))


def edited(g1, edit):
    root = ET.fromstring(g1.robot.urdf)
    edit(root)
    return {"robot": Robot.from_urdf(ET.tostring(root, encoding="unicode"),
                                     choices=g1.robot.choices)}  # fmt: skip


def numbers(element, name):
    return np.array([float(value) for value in element.get(name).split()])


def put(element, name, values):
    element.set(name, " ".join(repr(float(value)) for value in values))


def stretched(element, along, factor):
    """Stretch a link's mass about its joint, along an axis of the robot's."""
    inertial = element.find("inertial")
    mass, origin = float(inertial.find("mass").get("value")), inertial.find("origin")
    assert not numbers(origin, "rpy").any()
    com, parts = numbers(origin, "xyz"), inertial.find("inertia")
    xx, xy, xz, yy, yz, zz = (
        float(parts.get(f"i{a}")) for a in ("xx", "xy", "xz", "yy", "yz", "zz")
    )
    about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    second = 0.5 * np.trace(about) * np.eye(3) - about
    K = np.eye(3) + (factor - 1.0) * np.outer(along, along)
    second = K @ second @ K
    about = np.trace(second) * np.eye(3) - second
    for row, a in enumerate("xyz"):
        for column, b in enumerate("xyz"):
            if column >= row:
                parts.set(f"i{a}{b}", repr(float(about[row, column])))
    put(origin, "xyz", K @ com)
    assert mass > 0.0


def wider(step):
    def edit(root):
        for joint in root.findall("joint"):
            if joint.get("name").endswith("_hip_pitch_joint"):
                side = 1.0 if joint.get("name").startswith("left") else -1.0
                origin = joint.find("origin")
                put(origin, "xyz", numbers(origin, "xyz") + side * step / 2.0 * np.eye(3)[1])

    return edit


def longer_shins(step):
    def edit(root):
        for joint in root.findall("joint"):
            if joint.get("name").endswith("_ankle_pitch_joint"):
                origin = joint.find("origin")
                put(origin, "xyz", numbers(origin, "xyz") - [0.0, 0.0, step])
        for link in root.findall("link"):
            if link.get("name").endswith("_knee_link"):
                stretched(link, np.array([0.0, 0.0, 1.0]), 1.0 + step / 0.30001)

    return edit


def heavier_shins(step):
    def edit(root):
        for link in root.findall("link"):
            if link.get("name").endswith("_knee_link"):
                inertial = link.find("inertial")
                mass = inertial.find("mass")
                factor = 1.0 + step / float(mass.get("value"))
                mass.set("value", repr(factor * float(mass.get("value"))))
                inertia = inertial.find("inertia")
                for name in inertia.attrib:
                    inertia.set(name, repr(factor * float(inertia.get(name))))

    return edit


@needs_example_robots
@pytest.mark.parametrize(
    ("name", "edit", "step"),
    [
        ("hip width", wider, 1e-5), ("shin", longer_shins, 1e-5),
        ("shin mass", heavier_shins, 1e-5),
    ],
)  # fmt: skip
def test_of_g1(g1, name, edit, step):
    found = g1.report.of(name).per_unit
    expected = g1.difference(lambda amount: edited(g1, edit(amount)), step)
    assert found == pytest.approx(expected, rel=CLOSE)


@needs_example_robots
def test_of_the_rotors_of_g1(g1):
    def rotors(step):
        own = LimitOverride("*_knee_joint", armature=0.025101925 + step)
        choices = g1.robot.choices
        choices = choices.over(limits=(*choices.limits, own))
        return {"robot": Robot.from_urdf(g1.robot.urdf, choices=choices)}

    found = g1.report.of("knee rotor inertia").per_unit
    assert found == pytest.approx(g1.difference(rotors, 1e-6), rel=CLOSE)


PARTS = (*OF_ROBOT, "sole", "straight", "reach")


def together(walk, seed):
    """All numbers of a robot at once, each so far that it is worth as much as the others."""
    random, cost = np.random.default_rng(seed), walk.report.cost
    moved, exact = dict.fromkeys(PARTS, 0.0), 0.0
    for change in Anatomy(walk.problem.robot).changes:
        rate = walk.report.of(change.name).per_unit
        size = random.uniform(0.5, 1.5) * min(change.step, 1e-3 * cost / abs(rate)) * np.sign(rate)
        exact += rate * size
        for name in PARTS:
            moved[name] = moved[name] + size * getattr(change, name)
    return moved, exact


@needs_example_robots
@pytest.mark.parametrize("which", ["biped", "g1"])
def test_of_all_numbers_of_a_robot_together(which, request):
    walk = request.getfixturevalue(which)
    for seed in (1, 2):
        moved, exact = together(walk, seed)

        def other(amount, moved=moved):
            return {"robot": changed_robot(walk.robot, moved, amount)}

        assert exact > 0.03 * walk.report.cost
        once, twice = (walk.difference(other, step) for step in (1e-3, 2e-3))
        assert exact == pytest.approx((4.0 * once - twice) / 3.0, rel=CLOSE)


@needs_example_robots
@pytest.mark.parametrize("name", ["speed", "duration", "slope"])
def test_of_the_task_of_g1(g1, name):
    task = g1.problem.task

    def other(step):
        return {"task": replace(task, **{name: getattr(task, name) + step})}

    found = g1.report.of(name).per_unit
    assert found == pytest.approx(g1.difference(other, 1e-5), rel=CLOSE)


def test_where_derivatives_may_jump_is_said(biped):
    """A limit put exactly where the walk is, where nothing presses on it yet."""
    task, problem = biped.problem.task, biped.problem
    torque = np.abs(problem.step(biped.x).support.effort[:, 6:]).max()
    walk = WalkProblem(biped.robot, task.with_margins({"torque_limit": float(torque)}),
                       problem.grid)  # fmt: skip
    found = TIGHT.solve(walk, Start(biped.x, biped.multipliers))
    report = sensitivities(walk, found.x, (found.multipliers, found.bound_multipliers))
    told = [text for text in report.doubts if " torque is " in text and "N·m from" in text]
    assert len(told) == 1
    assert not [text for text in biped.report.doubts if " torque is" in text]


@pytest.mark.parametrize("turn", [{"toe_off": 0.7}, {"heel_strike": 0.15}])
def test_soles_about_whose_edges_a_foot_turns_are_left_out(robot, turn):
    task = preset_task(speed=0.8, samples=15, **turn)
    problem = WalkProblem(robot, task)
    at = Envelope(problem, first_guess(problem), np.zeros(problem.rows.lower.size))
    names = {change.name for change in at.changes}
    assert {"shin", "foot width", "trunk mass"} <= names
    assert not {"foot length", "sole forward"} & names


LIMITED = {  # every limit presses on one of these walks of the biped, or on that of G1
    "torque_limit": 70.0, "speed_limit": 6.0, "friction": 0.4, "trunk_pitch": 0.1,
    "trunk_roll": 0.05, "trunk_yaw": 0.05, "step_width": 0.2, "landing_impulse": 0.15,
    "landing_speed": 0.1, "swing_tilt": 0.2, "swing_height": 0.08, "torsional_friction": 0.02,
    "leg_gap": 0.01, "minimum_load": 100.0, "leg_extension": 0.99, "lateral_gap": 0.03,
    "liftoff_speed": -0.005,
}  # fmt: skip


CLOSE_LEGS = {
    "minimum_load": 300.0, "leg_extension": 0.97, "lateral_gap": -0.05, "leg_gap": 0.06,
    "liftoff_speed": -0.02,
}  # fmt: skip
SMALL = 2e-4


@pytest.fixture(scope="module")
def limited(robot):
    return Walk(robot, preset_task(samples=21, **LIMITED))


@pytest.fixture(scope="module")
def soft(robot):
    return Walk(robot, preset_task(samples=21, landing_impulse=0.1, **CLOSE_LEGS))


@pytest.fixture(scope="module")
def swift(robot):
    return Walk(robot, preset_task(samples=21, **CLOSE_LEGS | {"landing_speed": 0.3,
                                                              "leg_extension": 0.985}))  # fmt: skip


def held(problem, x):
    """Which rows and bounds a walk is at."""
    rows, bounds, values = problem.rows, problem.variables, problem.values(x).rows
    away = (
        np.minimum(values - rows.lower, rows.upper - values),
        np.minimum(x - bounds.lower, bounds.upper - x),
    )
    return np.concatenate(away) < 1e-7


class Limits:
    """The limits of a walk and what they are worth."""

    def __init__(self, walk):
        self.walk, self.problem = walk, walk.problem
        self.held = held(walk.problem, walk.x)
        prices = shadow_prices(walk.problem, walk.x,
                               (walk.multipliers, walk.bound_multipliers))  # fmt: skip
        self.prices = [price for price in prices if price.kind == SETTING]
        self.single = [price for price in prices if price.kind == LIMIT]
        width = step_width_adjustment(walk.problem)
        self.settings = (*limit_adjustments(walk.problem), *([width] if width else []))

    def price(self, setting):
        """Of a setting, zero where none is told."""
        told = [one.cost_per_unit for one in self.prices if one.name == setting.name]
        assert len(told) <= 1
        return told[0] if told else 0.0

    def difference(self, changed, step):
        """Of the optimal cost, central, of fourth order, so near that the same limits are held."""
        for nearer in (1.0, 0.1, 0.01):
            costs = []
            for times in (-2.0, -1.0, 1.0, 2.0):
                problem = changed(times * nearer * step)
                found = self.walk.solved(problem)
                if (held(problem, found.x) != self.held).any():
                    break
                costs.append(found.cost)
            else:
                once, twice = (costs[2] - costs[1]) / 2.0, (costs[3] - costs[0]) / 4.0
                return (4.0 * once - twice) / 3.0 / (nearer * step)
        raise AssertionError("other limits get held, however little changes")

    def step(self, unit, price):
        """A small change: of the unit that matters, or of the cost."""
        small = SMALL * abs(unit)
        return min(small, SMALL * self.walk.report.cost / abs(price)) if price else small

    def with_settings(self, amounts):
        """The walk with settings moved by amounts."""
        robot, task = self.walk.robot, self.problem.task
        for setting, amount in amounts:
            robot, task = setting.changed(robot, task, setting.before + amount)
        return WalkProblem(robot, task, self.problem.grid)

    def with_rows(self, amounts):
        """The walk with single limits, as prices name them, moved by amounts."""
        problem = WalkProblem(self.walk.robot, self.problem.task, self.problem.grid)
        lower, upper = problem.rows.lower.copy(), problem.rows.upper.copy()
        for price, amount in amounts:
            limits = upper if price.words == "upper" else lower
            for block in problem.blocks:
                if price.name in block.labels:
                    entry = block.labels.index(price.name)
                    part = limits[problem.rows_of(block.name)].reshape(block.lower.shape)
                    part[:, entry] += amount / block.scale[entry]
        problem.rows = Rows(lower, upper)
        return problem


@needs_example_robots
@pytest.mark.parametrize(
    ("which", "pressed"),
    [
        (
            "limited",
            "torque_limit speed_limit friction lateral_gap liftoff_speed torsional_friction "
            "trunk_roll trunk_pitch trunk_yaw swing_tilt swing_height speed",
        ),
        ("soft", "landing_impulse leg_gap leg_extension minimum_load cop_margin clearance"),
        ("swift", "landing_speed leg_gap cop_margin friction"),
        (
            "g1",
            "knee_flexion step_width trunk_roll swing_height cop_margin clearance speed",
        ),
    ],
)
def test_of_each_limit(which, pressed, request):
    walk = request.getfixturevalue(which)
    limits = Limits(walk)
    assert {one.name for one in limits.prices} >= set(pressed.split())
    assert len(limits.settings) > len(limits.prices)
    for setting in limits.settings:
        price = limits.price(setting)
        found = limits.difference(
            lambda amount, setting=setting: limits.with_settings([(setting, amount)]),
            limits.step(setting.step, price),
        )
        zero = 1e-9 * walk.report.cost / abs(setting.step)
        assert price == pytest.approx(found, rel=CLOSE, abs=zero), setting.name


def alone(walk, limits):
    """Prices of single limits, without those that are said to hold what others hold."""
    said = [text for text in walk.report.doubts if "hold the same" in text]
    return [one for one in limits.single
            if not any(f"{one.name} ({one.words})" in text for text in said)]  # fmt: skip


@needs_example_robots
@pytest.mark.parametrize("which", ["limited", "g1"])
def test_of_all_limits_together(which, request):
    walk = request.getfixturevalue(which)
    limits, random = Limits(walk), np.random.default_rng(3)
    settings = [(one, limits.price(one), one.step) for one in limits.settings]
    single = [(one, one.cost_per_unit, 0.1 * one.effect / one.cost_per_unit)
              for one in alone(walk, limits)]  # fmt: skip
    for several, other in ((settings, limits.with_settings), (single, limits.with_rows)):
        sizes = [(one, random.uniform(0.5, 1.5) * limits.step(unit, price) * (np.sign(price) or 1))
                 for one, price, unit in several]  # fmt: skip
        exact = sum(price * size for (_, price, _), (_, size) in zip(several, sizes, strict=True))
        found = limits.difference(
            lambda amount, sizes=sizes, other=other: other(
                [(one, amount * size) for one, size in sizes]
            ),
            0.2,
        )
        assert len(several) > 7
        assert exact == pytest.approx(found, rel=CLOSE)


@needs_example_robots
@pytest.mark.parametrize("which", ["limited", "g1"])
def test_of_single_limits(which, request):
    walk = request.getfixturevalue(which)
    limits = Limits(walk)
    for one in alone(walk, limits)[:4]:
        found = limits.difference(
            lambda amount, one=one: limits.with_rows([(one, amount)]),
            limits.step(0.1 * one.effect / one.cost_per_unit, one.cost_per_unit),
        )
        assert one.cost_per_unit == pytest.approx(found, rel=CLOSE), one.name


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        # while the foot turns, the margin narrows the strip under its toe sideways only
        ("cop_margin", {"toe_off": 0.7, "toe_strip": 0.03, "cop_margin": 0.02}),
        # V T of the duration found, not of that asked for
        ("speed", {"geometry": set_geometry(GEOMETRY, {"duration": {"free": True}})}),
    ],
)
def test_of_limits_that_depend_on_the_walk(robot, name, asked):
    limits = Limits(Walk(robot, preset_task(samples=21, **asked)))
    (setting,) = (one for one in limits.settings if one.name == name)
    price = limits.price(setting)
    found = limits.difference(
        lambda amount: limits.with_settings([(setting, amount)]), limits.step(setting.step, price)
    )
    assert price == pytest.approx(found, rel=CLOSE)
    assert price != 0.0


def one_sided(walk, name, step):
    """The price of a limit, and derivatives of the optimal cost above and below its value."""
    limits = Limits(walk)
    (setting,) = (one for one in limits.settings if one.name == name)
    here = walk.solved(walk.problem).cost
    once, twice = (
        np.array([walk.solved(limits.with_settings([(setting, k * side * step)])).cost - here
                  for side in (1.0, -1.0)])
        for k in (1.0, 2.0)
    )  # fmt: skip
    return limits.price(setting), (4.0 * once - twice) / (2.0 * step) * [1.0, -1.0]


def test_a_limit_that_acts_otherwise_on_either_side_is_said(robot):
    walk = Walk(robot, reference_task(samples=21, torque_limit=60.0, friction=0.3))
    price, (above, below) = one_sided(walk, "liftoff_speed", 1e-5)
    assert price == pytest.approx(below, rel=CLOSE)  # where the foot may sink, and limits give
    assert price != pytest.approx(above, rel=1e-4)
    assert [text for text in walk.report.doubts
            if text.startswith("the least lift-off speed") and "other side" in text]  # fmt: skip


@needs_example_robots
def test_limits_that_hold_the_same_are_said(g1):
    walk = Walk(g1.robot, preset_task("humanoid", g1.robot, speed=0.6))
    price, (above, below) = one_sided(walk, "trunk_yaw", 1e-5)
    assert abs(above) < 1e-4 * abs(below)  # the pelvis has the same bound, and does not give
    assert abs(above) < abs(price) < abs(below)
    (said,) = (text for text in walk.report.doubts if "pelvis_yaw" in text)
    assert said.startswith("pelvis_yaw (upper), trunk yaw (lower), trunk yaw (upper): ")
