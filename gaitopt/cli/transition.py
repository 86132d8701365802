"""`gaitopt transition`: from standing to a walk and back, and from one walk to another."""

from __future__ import annotations

from pathlib import Path

import typer

from gaitopt.cli.process import ExitCode
from gaitopt.cli.show import loaded
from gaitopt.design.transition import TransitionDesign, design_transition
from gaitopt.errors import InputError
from gaitopt.motions.export import export_transition, form_for

STANDING = "standing"


def run(
    begin: str,
    finish: str,
    output: Path,
    *,
    steps: int,
    duration: str | None,
    stretch: float,
    name: str,
    rate: float | None,
    joints: str | None,
) -> None:
    """Design a transition and write its motion.

    Args:
        begin, finish: gait files, or "standing".
        output: file for the motion.
        steps, stretch: as of `design_transition`.
        duration: of the steps [s], one or several joined by commas; None: searched.
        name: of the format of the motion.
        rate, joints: as of `gaitopt.export_transition`.

    Raises:
        GaitoptError: a gait cannot be read, there is no transition, or it cannot be written.
        InputError: the file or a duration is none that can be.
    """
    if not form_for(output, name).sampled:
        raise InputError(f"format '{name}' has curves of a walk; choose one with samples")
    files = [Path(end) for end in (begin, finish) if end != STANDING]
    if any(output.exists() and one.exists() and output.samefile(one) for one in files):
        raise InputError(f"'{output}' is one of the gaits; give another file to write")
    before, after = (None if end == STANDING else loaded(Path(end)) for end in (begin, finish))
    lasts = _durations(duration)
    found = design_transition(before, after, steps=steps, durations=lasts, stretch=stretch)
    for line in _lines(found):
        typer.echo(line)
    written = export_transition(found.transition, output, format=name, rate=rate, joints=joints)
    typer.echo(f"wrote {written}")
    if not found.certificate.certified:
        raise typer.Exit(ExitCode.NOT_CERTIFIED)


def _durations(text: str | None) -> tuple[float, ...] | float | None:
    if text is None:
        return None
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(
            f"--duration is '{text}'; give seconds, one for all steps or one for each: 0.3,0.4"
        ) from error
    return values[0] if len(values) == 1 else values


def _lines(found: TransitionDesign) -> list[str]:
    """Return what a person wants to know of a transition."""
    result, certificate, solution = found.transition, found.certificate, found.solution
    lines = [f"{result.words}, {len(result.steps)} steps in {result.duration:.3f} s"]
    lengths = result.meta["step_lengths"]
    assert isinstance(lengths, list)
    for number, (step, length) in enumerate(zip(result.steps, lengths, strict=True)):
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
