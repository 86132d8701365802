"""`gaitopt transition`: from standing to a walk and back, and from one walk to another."""

from __future__ import annotations

from os.path import exists
from pathlib import Path

import typer

from gaitopt.cli.command_options import TransitionOptions
from gaitopt.cli.display import ProgressDisplay, screen
from gaitopt.cli.process import ExitCode, print_error, refuse_options, stop_on_interrupt
from gaitopt.cli.results import require_files
from gaitopt.cli.show import loaded
from gaitopt.design.transition import TransitionDesign, design_transition
from gaitopt.errors import InputError, StoppedError, did_you_mean
from gaitopt.gait.result import Gait
from gaitopt.gait.transition import save_transition
from gaitopt.gait.transition_problem import STRETCH
from gaitopt.nlp import Status
from gaitopt.units import read_quantity

STANDING = "standing"
_SUFFIX = ".npz"


def run(asked: TransitionOptions) -> None:
    """Design a transition and write its file.

    Raises:
        InputError: the file or a duration is none that can be.
    """
    begin, finish, output = asked.begin, asked.finish, asked.output
    if output.suffix.lower() != _SUFFIX:
        raise InputError(
            f"cannot write '{output}': files of transitions end in {_SUFFIX}; gaitopt export makes "
            "motions of them"
        )
    require_files((output, "--output"))
    files = [Path(end) for end in (begin, finish) if end != STANDING]
    if any(exists(output) and exists(one) and output.samefile(one) for one in files):
        raise InputError(f"'{output}' is one of the gaits; give another file to write")
    if STANDING not in (begin, finish):
        given = {f"--stretch {asked.stretch:g}": asked.stretch != STRETCH}
        refuse_options(given, f"where the robot stands, with '{STANDING}' at one end")
    before, after = _end(begin), _end(finish)
    found = _designed(asked, before, after)
    for line in _lines(found):
        typer.echo(line)
    typer.echo(f"wrote {save_transition(found.transition, output)}")
    if not found.certificate.certified:
        raise typer.Exit(ExitCode.NOT_CERTIFIED)
    if found.solution.status is Status.INTERRUPTED:
        raise typer.Exit(ExitCode.INTERRUPTED)


def _designed(
    asked: TransitionOptions, before: Gait | None, after: Gait | None
) -> TransitionDesign:
    """Return the transition, its search shown on the screen."""
    errors, durations = screen(stderr=True), _durations(asked.duration)
    try:
        with (
            stop_on_interrupt(announce=not errors.is_terminal) as stop,
            ProgressDisplay(errors, stop, quiet=False) as progress,
        ):
            found = design_transition(
                before, after, steps=asked.steps, durations=durations, shift=asked.shift,
                stretch=asked.stretch, on_progress=progress, stop=stop,
            )  # fmt: skip
            progress.finish(found.solution, found.transition.cost_unit)
    except StoppedError:
        print_error("interrupted before there was a result; nothing was written")
        raise typer.Exit(ExitCode.INTERRUPTED) from None
    return found


def _end(text: str) -> Gait | None:
    if text == STANDING:
        return None
    if not exists(text):
        raise InputError(
            f"there is no such file as '{text}'; {did_you_mean(text, [STANDING])}give '{STANDING}' "
            "or a gait file, that gaitopt optimise --output wrote"
        )
    return loaded(Path(text))


def _durations(text: str | None) -> tuple[float, ...] | float | None:
    if text is None:
        return None
    try:
        values = tuple(read_quantity(part, "s") for part in text.split(","))
    except ValueError as error:
        raise InputError(
            f"--duration is '{text}'; give seconds, one for all steps or one for each: 0.3,0.4"
        ) from error
    return values[0] if len(values) == 1 else values


def _lines(found: TransitionDesign) -> list[str]:
    """Return what a person wants to know of a transition."""
    result, certificate, solution = found.transition, found.certificate, found.solution
    lines = [f"{result.words}, {len(result.steps)} steps in {result.duration:.3f} s"]
    if result.shift is not None:
        lines.append(f"  weight shift: {result.shift.duration:.3f} s")
    for number, (step, length) in enumerate(zip(result.steps, result.step_lengths, strict=True)):
        peak = float(abs(step.torque).max())
        lines.append(
            f"  step {number + 1}: {step.duration:.3f} s, {length:.3f} m, "
            f"largest torque {peak:.1f} N·m"
        )
    lines.append(
        f"cost {result.cost:.6g} {result.cost_unit}, {certificate.verdict} "
        f"({solution.iterations} iterations, {solution.seconds:.1f} s)"
    )
    return lines
