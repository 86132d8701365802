"""What a message says to do next is done, word by word, and works."""

from __future__ import annotations

import re

import pytest

from gaitopt.cli import optimise
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import many_starts
from gaitopt.errors import NoGaitFoundError, UnreachableError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.solvers import solver_by_name


class AcceptedError(Exception):
    """The request was understood; the search would begin."""


@pytest.fixture
def accepted(cli, monkeypatch, tmp_path):
    """Tell whether a command line gets as far as the search, and what it says if not."""

    def stop(*_: object, **__: object) -> None:
        raise AcceptedError

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(optimise, "_search", stop)
    monkeypatch.setattr("gaitopt.sweep.speed_search.fastest", stop)
    monkeypatch.setattr("gaitopt.cli.sweep.sweep", stop)

    def ask(text: str) -> str:
        try:
            result = cli(*text.split())
        except AcceptedError:
            return ""
        return str(result.stderr).replace("\n", " ")

    return ask


REMEDIES = [
    ("optimise --samples 30", r"give (\d+), or quadrature 'euler'", "optimise --samples {0}"),
    ("optimise --samples 30", r"or quadrature '(euler)'", "optimise --samples 30 --quadrature {0}"),
    ("optimise --samples 2", r"give at least (\d+)", "optimise --samples {0} --postures 1"),
    ("optimise --postures 40", r"give at most (\d+)", "optimise --postures {0}"),
    ("optimise --samples 1000000001", r"give at most (\d+)", "optimise --samples {0}"),
    ("optimise --starts 1000000000", r"give at most (\d+)", "optimise --starts {0}"),
    ("optimise --starts 0", r"give at least (\d+)", "optimise --starts {0}"),
    ("optimise --preset fast", r"choose one of (\w+)", "optimise --preset {0}"),
    ("optimise --speed-as wish", r"choose (\w+) or", "optimise --speed-as {0}"),
    ("optimise --speed-as wish", r" or (penalty)", "optimise --speed-as {0}"),
    ("optimise --boundary open", r"choose (\w+) or", "optimise --boundary {0}"),
    ("optimise --quadrature gauss", r"choose (\w+) or", "optimise --quadrature {0}"),
    ("optimise --approach sideways", r"choose (\w+)", "optimise --approach {0}"),
    ("optimise --differences some", r"choose (\w+)", "optimise --differences {0}"),
    ("optimise --solver magic", r"(sqp)", "optimise --solver {0}"),
    ("optimise --fix step_length=0.4", r"speed as a (penalty)",
     "optimise --fix step_length=0.4 --speed-as {0}"),
    ("optimise --fix step_length=0.4", r"(free) it", "optimise --{0} step_length"),
    ("optimise --fix foot_spacing=0.4 --step-width 0.3", r"(free) it",
     "optimise --{0} foot_spacing --step-width 0.3"),
    ("optimise --fix foot_spacing=0.4 --step-width 0.3", r"a larger (step_width)",
     "optimise --fix foot_spacing=0.4 --step-width 0.5"),
    ("optimise --fix duration=0.5", r"fixed by (--duration)", "optimise {0} 0.5"),
    ("optimise --fix pelvis_roll", r"--fix (pelvis_roll=0.05)", "optimise --fix {0}"),
    ("optimise --fix pelvis_roll=1 --fix pelvis_roll=2", r"give its value (once)",
     "optimise --fix pelvis_roll=1"),
    ("optimise --fix pelvis_roll=nan", r"give a (finite) number", "optimise --fix pelvis_roll=0.1"),
    ("optimise --duration 0.01", r"must be ([\d.]+) s or more",
     "optimise --duration {0} --speed 0.5"),
    ("optimise --duration 6 --free duration", r"between [\d.]+ and ([\d.]+) s",
     "optimise --duration {0} --free duration --speed 0.1"),
    ("optimise --friction 0", r"between ([\d.]+) and", "optimise --friction {0}"),
    ("optimise --clearance -1", r"must (not) be negative", "optimise --clearance 0"),
    ("optimise --leg-extension 1.2", r"at most (\d)", "optimise --leg-extension {0}"),
    ("optimise --fastest --sigma 0.1", r"(leave out) --start, --starts, --seed and --sigma",
     "optimise --fastest"),
    ("optimise --fastest --starts 3", r"(leave out)", "optimise --fastest"),
    ("optimise --robot g1 --urdf x.urdf", r"give (one) of them", "optimise --robot biped13"),
    ("sweep --output lib", r"give --speeds (\S+),", "sweep --speeds {0} --output lib"),
    ("sweep --speeds 1.3:0.4:0.05 --output lib", r"first: ([\d.:]+)",
     "sweep --speeds {0} --output lib"),
    ("sweep --speeds x --output lib", r"as ([\d.:]+), or", "sweep --speeds {0} --output lib"),
    ("sweep --speeds x --output lib", r"values, as ([\d.,]+\d)", "sweep --speeds {0} --output lib"),
    ("sweep --grid duration --output lib", r"as (duration=\S+)", "sweep --grid {0} --output lib"),
    ("sweep --speeds 0.8,1.0 --grid speed=0.5,0.6 --output lib", r"by (--speeds) or",
     "sweep {0} 0.8,1.0 --output lib"),
    ("sweep --speeds 0.8,1.0 --speed 1.0 --output lib", r"leave out (--speed)",
     "sweep --speeds 0.8,1.0 --output lib"),
    ("sweep --speeds 0.8,0.8 --output lib", r"give each (once)", "sweep --speeds 0.8 --output lib"),
    ("sweep --speeds 0.8 --workers 0 --output lib", r"give at least (\d)",
     "sweep --speeds 0.8 --workers {0} --output lib"),
]  # fmt: skip


@pytest.mark.parametrize(("asked", "said", "followed"), REMEDIES)
def test_a_remedy_works(accepted, asked, said, followed):
    message = accepted(asked)
    assert message, "this should have been refused"
    named = re.search(said, message)
    assert named, message
    assert accepted(followed.format(*named.groups())) == ""


def test_a_step_longer_than_the_legs_is_told_what_would_do(robot):
    """The speed that follows from the longest step named leads on: to a walk, or to a diagnosis."""

    with pytest.raises(
        UnreachableError, match=r"at most 1\.164 m; ask for a lower speed"
    ) as caught:
        first_guess(WalkProblem(robot, preset_task(speed=3.2)))
    longest = float(re.search(r"at most ([\d.]+) m", str(caught.value)).group(1)) - 1e-3
    for easier in ({"speed": longest / 0.4}, {"speed": 3.2, "duration": longest / 3.2}):
        task = preset_task(**easier, samples=15)
        first_guess(WalkProblem(robot, task))
        quick = DesignOptions(solver_by_name("sqp", max_iterations=3), diagnose=False)
        with pytest.raises(NoGaitFoundError):
            many_starts(robot, task, quick, count=1)
