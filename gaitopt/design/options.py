"""How a gait is searched for."""

from __future__ import annotations

from dataclasses import field, replace
from typing import TYPE_CHECKING

from gaitopt.bounds import must_be, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.nlp import ProgressCallback, Stop, StopCallback, never, stopping
from gaitopt.settings import check_settings, checked, entry
from gaitopt.solvers import Solver, solver_by_name

if TYPE_CHECKING:  # else options would load all of a walk
    from gaitopt.gait.problem import MakeProgress, WalkProblem

PHASE_TIMES = ("best", "given")
DIFFERENCES = ("none", "constraints", "all")
APPROACHES = ("automatic", "direct", "relaxed")

SIGMA = 0.1  # rad and rad/s: 20 of 20 such starts reach a walk, some another one; measured
COUNT = 2  # starts; measured: finds the best known optimum at all speeds, docs/diagnosis.md


@checked
@dataclass(frozen=True)
class DesignOptions:
    """How a gait is searched for.

    Attributes:
        solver: does the work.
        refine: whether constraints must hold between the samples too.
        differences: "none" for exact derivatives; "all" for finite-difference gradients, or
            "constraints" for the paper's mode (exact gradient of the cost alone). Refinement and
            confirmation always have the exact ones.
        approach: "direct", or "relaxed": first the walk whose rear foot may sink a little at
            lift-off, then, from there, the walk asked for. "automatic" is relaxed for the lifted
            form of the double support, which is that of robots unlike the paper's.
        toe_begin: of a task with `toe_off`: "best" searches the share of the step at which turning
            about the toe costs least, from the one given, and keeps the flat walk where that is
            cheaper; "given" takes the one given.
        phase_times: of a task with `heel_strike` or `double_support`: "best" searches the share of
            the step until which the foot rolls flat, and the time for which both feet stand, from
            those given; with a heel strike the flat walk is kept where that is cheaper. "given"
            takes those given.
        diagnose: whether to find out why when there is no gait (some seconds).
    """

    solver: Solver = field(default_factory=lambda: solver_by_name("default"))
    refine: bool = entry(
        True, "Keep the limits between the instants too, and prove it.", common=True
    )
    differences: str = entry(
        "none",
        "Which derivatives to replace by finite differences: none, the constraints', or all.",
        choices=DIFFERENCES,
        metavar="WHICH",
    )
    approach: str = entry(
        "automatic",
        "Search first with a rear foot that may sink a little (relaxed), or directly.",
        choices=APPROACHES,
        metavar="HOW",
    )
    toe_begin: str = entry(
        "best",
        "Where --toe-off begins: best, searched from there, or flat if that is cheaper; or given.",
        choices=PHASE_TIMES,
        metavar="HOW",
    )
    phase_times: str = entry(
        "given",
        "Times of --heel-strike and --double-support: as given, or the best, searched from there.",
        choices=PHASE_TIMES,
        metavar="HOW",
    )
    diagnose: bool = True

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            InputError: no solver, or an unknown kind of derivatives or approach.
        """
        if not isinstance(self.solver, Solver):
            raise InputError(
                f"solver is {shown(self.solver)}; give a Solver, as solver_by_name('sqp')"
            )
        check_settings(self)


@dataclass(frozen=True)
class Search:
    """How walks are searched for, who is told of it, and what ends it.

    Attributes:
        options: solver, refinement, approach, kind of derivatives.
        on_progress: makes the progress callback of a walk; None: nobody is told.
        stop: asked at every iteration; where it says True, the best walk until then is kept.
    """

    options: DesignOptions = field(default_factory=DesignOptions)
    on_progress: MakeProgress | None = None
    stop: Stop = never

    def __post_init__(self) -> None:
        """Check the kind of the options."""
        must_be(self.options, DesignOptions, "options", "DesignOptions(...)")

    def changed(self, **options: object) -> Search:
        """Return the same search with other options."""
        return replace(self, options=replace(self.options, **options))  # type: ignore[arg-type]

    @property
    def quiet(self) -> Search:
        """The same of which nobody is told."""
        return replace(self, on_progress=None)

    @property
    def ends(self) -> StopCallback:
        """What a solver asks whether to stop."""
        return stopping(self.stop)

    def callback(self, problem: WalkProblem) -> ProgressCallback | None:
        """Return the progress callback of a walk."""
        return None if self.on_progress is None else self.on_progress(problem)
