"""`gaitopt requirements`: what each motor must deliver over a set of gaits, and in which one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from gaitopt.actuators.motors import MotorTable, read_motors
from gaitopt.cli.command_options import RequirementsOptions
from gaitopt.cli.display import ABSENT, NARROW, new_table, screen, warn
from gaitopt.cli.report import print_findings_of
from gaitopt.cli.results import require_files
from gaitopt.design.requirements import (
    FIGURES,
    UNITS,
    USES,
    MotorLoop,
    MotorRequirement,
    motor_uses,
    own_motor_loops,
    requirements_of,
    worst_case,
)
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.result import Gait
from gaitopt.sweep.library import open_library
from gaitopt.units import RPM, motion_words
from gaitopt.view.requirements_file import check_suffix, write_requirements

_HEADERS = {
    "peak_torque": "peak\nN·m",
    "speed_at_peak_torque": "at\nrpm",
    "peak_speed": "peak\nrpm",
    "torque_at_peak_speed": "at\nN·m",
    "rms_torque": "RMS\nN·m",
    "peak_power": "power\nW",
    "regenerated_power": "regen.\nW",
    "duty": "duty\n%",
}
_USES = {
    "ratio": "gear\nratio",
    "peak_torque": "peak\nN·m",
    "peak_share": "of peak\n%",
    "rms_torque": "RMS\nN·m",
    "rms_share": "of cont.\n%",
    "peak_speed": "peak\nrpm",
    "voltage_share": "voltage\n%",
    "copper_loss": "loss\nW",
}
_SCALES = {"speed_at_peak_torque": RPM, "peak_speed": RPM, "duty": 0.01}
_COMPARED = tuple(name for name in FIGURES if not name.startswith(("speed_at", "torque_at")))
"""What a change of is told: not what happens to go with a peak."""
_SHARES = {
    "peak_share": "its motor's peak torque",
    "rms_share": "its motor's continuous torque: too hot",
    "voltage_share": "its motor's voltage",
}
_FULL = 1.0 + 1e-6  # of a limit: what is certified may lie on it
_TITLE = "What each motor must deliver over a stride, at its joint or at the crank that it turns"
_ZERO = 1e-9  # of any unit: nothing to compare with


def run(asked: RequirementsOptions) -> None:
    """Print requirements on motors, compare those of two designs, write and draw them."""
    output, figure = asked.output, asked.figure
    require_files((output, "--output"), (figure, "--figure"))
    if output is not None:
        check_suffix(output)
    if figure is not None:
        from gaitopt.view.figure_style import kind_of

        kind_of(figure)
    table = None if asked.motors is None else read_motors(asked.motors)
    loops, other = _loops(asked.gait, table), _loops(asked.against, table)
    out = screen()
    width = min(out.width, NARROW)
    each = requirements_of(loops)
    worst = worst_case(each)
    _print_requirements(out, worst, _TITLE)
    uses = [] if table is None else motor_uses(loops, table)
    if uses:
        used = worst_case(uses, USES)
        out.print(use_table(used), width=width)
        out.print()
        beyond = overloads(used)
        for line in beyond:
            warn(out, "too much", line)
        if beyond:
            out.print()
    if len(loops) > 1:
        numbers = {label: str(number) for number, label in enumerate(loops, 1)}
        out.print(deciding_table(worst, numbers), width=width)
        out.print()
        for label, number in numbers.items():
            out.print(f"{number}: {label}", soft_wrap=True)
    if other:
        theirs = worst_case(requirements_of(other))
        _print_requirements(out, theirs, "The other design")
        out.print(difference_table(worst, theirs), width=width)
        out.print()
    if output is not None:
        out.print(f"wrote {write_requirements(each, worst, output, uses)}", soft_wrap=True)
    if figure is not None:
        from gaitopt.view.comparison_figures import write_torque_speed_figure

        out.print(f"wrote {write_torque_speed_figure(loops, figure, table)}", soft_wrap=True)


def _loops(paths: Sequence[Path], table: MotorTable | None) -> dict[str, list[MotorLoop]]:
    """Return the loops of all gaits in files and libraries, by label."""
    gaits = gaits_of(paths)
    for gait in list(gaits.values())[:1]:
        print_findings_of(gait)
    return {label: own_motor_loops(gait, table) for label, gait in gaits.items()}


def gaits_of(paths: Sequence[Path]) -> dict[str, Gait]:
    """Return all gaits of files and libraries, by label.

    Raises:
        GaitFileError: a path is neither, a gait is damaged, or a library has none.
        InputError: a gait is given twice.
    """
    gaits: dict[str, Gait] = {}
    for path in paths:
        for label, gait in _gaits_in(path).items():
            if label in gaits:
                raise InputError(f"the gait '{label}' is given twice; give it once")
            gaits[label] = gait
    return gaits


def _gaits_in(path: Path) -> dict[str, Gait]:
    if not path.is_dir():
        return {str(path): load_gait(path)}
    library = open_library(path)
    done = [point for point in library.grid.order if library.states[point].row is not None]
    if not done:
        raise GaitFileError(f"'{path}' holds no gait yet; give its gaitopt sweep again")
    return {f"{path}: {library.grid.name(point)}": library.gait(point) for point in sorted(done)}


def _print_requirements(out: Console, worst: Sequence[MotorRequirement], title: str) -> None:
    """Print what motors must deliver, a line each: those that turn, then those that slide."""
    for slides in (False, True):
        own = [one for one in worst if one.slides == slides]
        heads = [motion_words(_HEADERS[name], slides=slides) for name in FIGURES]
        if slides:
            title, heads = "Linear motors", [head.replace("rpm", "m/s") for head in heads]
        table = new_table(title, "motor", *(f">{head}" for head in heads))
        for one in own:
            cells = (_cell(name, one.values[name], slides=slides) for name in FIGURES)
            table.add_row(one.motor, *cells)
        if own:
            out.print(table, width=min(out.width, NARROW))
            out.print()


def use_table(worst: Sequence[MotorRequirement]) -> Table:
    """Return the table of what motors must deliver before their gears, and of their limits."""
    table = new_table(
        "Before the gear, and shares of the motor's limits", "motor",
        *(f">{header}" for header in _USES.values()),
    )  # fmt: skip
    for one in worst:
        table.add_row(one.motor, *(_use(name, one.values[name]) for name in _USES))
    return table


def _use(name: str, value: float) -> str:
    if name.endswith("_share"):
        return f"{100.0 * value:.0f}"
    return f"{value / RPM:.0f}" if name == "peak_speed" else f"{value:.3g}"


def overloads(worst: Sequence[MotorRequirement]) -> list[str]:
    """Return a sentence for every limit of a motor that the gaits are beyond."""
    return [
        f"{one.motor} takes {100.0 * one.values[name]:.0f} % of {what}"
        for one in worst
        for name, what in _SHARES.items()
        if one.values[name] > _FULL
    ]


def deciding_table(worst: Sequence[MotorRequirement], numbers: Mapping[str, str]) -> Table:
    """Return the table of the gaits that decide, by their numbers."""
    table = new_table(
        "In which gait", "motor", *(f">{_HEADERS[name].split()[0]}" for name in FIGURES)
    )
    for one in worst:
        table.add_row(one.motor, *(numbers[one.gaits[name]] for name in FIGURES))
    return table


def difference_table(worst: Sequence[MotorRequirement], other: Sequence[MotorRequirement]) -> Table:
    """Return the table of how much more the other design asks of each motor [%]."""
    own, theirs = ({(one.motor, one.slides): one.values for one in of} for of in (worst, other))
    headers = (f">{_HEADERS[name].split()[0]}\n%" for name in _COMPARED)
    table = new_table("How much more the other design asks", "motor", *headers)
    for motor in dict.fromkeys([*own, *theirs]):
        cells = (_change(own.get(motor), theirs.get(motor), name) for name in _COMPARED)
        table.add_row(motor[0], *cells)
    return table


def _cell(name: str, value: float, *, slides: bool) -> str:
    if slides and "rad" in UNITS[name]:
        return f"{value:.3f}"
    shown = value / _SCALES.get(name, 1.0)
    return f"{shown:.1f}" if shown < 100.0 else f"{shown:.0f}"


def _change(own: Mapping[str, float] | None, other: Mapping[str, float] | None, name: str) -> str:
    if own is None or other is None or own[name] < _ZERO:
        return ABSENT
    return f"{100.0 * (other[name] / own[name] - 1.0):+.1f}"
