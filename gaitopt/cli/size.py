"""`gaitopt size`: motors from a catalogue and gear ratios that serve a set of gaits."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import tomli_w

from gaitopt.actuators.motors import Motor, MotorTable, motors_of
from gaitopt.atomic import make_directory, write_atomically
from gaitopt.cli.command_options import SizeOptions
from gaitopt.cli.display import NARROW, new_table, screen
from gaitopt.cli.process import stop_on_interrupt
from gaitopt.cli.requirements import gaits_of
from gaitopt.cli.results import keep_files, require_writable
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import small_matrices
from gaitopt.design.sizing import Choice, read_catalogue, size
from gaitopt.errors import InputError
from gaitopt.gait.gait_file import save_gait

MOTOR_FILE = "motors.toml"
_MOST_RESERVE = 10.0


def run(asked: SizeOptions) -> None:
    """Choose motors, design the gaits again with them, and write both.

    Raises:
        InputError: bad input, no motor serves, or a file cannot be written.
    """
    directory, reserve = asked.output, asked.reserve
    if not 1.0 <= reserve <= _MOST_RESERVE:
        raise InputError(f"--reserve is {reserve:g}; give 1 (none) to {_MOST_RESERVE:g}")
    require_writable(directory)
    known = read_catalogue(asked.catalogue)
    gaits = gaits_of(asked.gait)
    names = [f"{number}.npz" for number in range(1, len(gaits) + 1)]
    keep_files(directory, (MOTOR_FILE, *names), (*asked.gait, asked.catalogue), _head("size"))
    out = screen()

    def told(choices: tuple[Choice, ...]) -> None:
        names = ", ".join(
            f"{one.motor} {one.drive.motor.name} {one.drive.ratio:.3g}" for one in choices
        )
        out.print(f"chosen: {names}", soft_wrap=True)

    with stop_on_interrupt() as stop, small_matrices():
        found = size(
            gaits, known, DesignOptions(), aim=asked.aim, reserve=reserve, on_round=told, stop=stop
        )
    table = new_table(
        "Motors and gears that serve all gaits", "joints", "motor", ">ratio", ">peak\n%",
        ">RMS\n%", ">voltage\n%", ">loss\nW",
    )  # fmt: skip
    for one in found.choices:
        shares = (one.peak_share, one.rms_share, one.voltage_share)
        table.add_row(
            one.motor, one.drive.motor.name, f"{one.drive.ratio:.4g}",
            *(f"{100.0 * share:.0f}" for share in shares), f"{one.loss:.1f}",
        )  # fmt: skip
    out.print(table, width=min(out.width, NARROW))
    loss = sum(len(one.joints) * one.loss for one in found.choices)
    out.print(f"motors of both sides: {found.mass:.3g} kg, {loss:.3g} W copper loss in the mean")
    if not found.settled:
        out.print(
            f"after {found.rounds} rounds the gaits would still choose other motors; those in the "
            "table serve the gaits written",
            soft_wrap=True,
        )
    make_directory(directory)
    text = motors_text(found.table, "size")
    motors_of(text)
    written = write_atomically(directory / MOTOR_FILE, text.encode())  # first: it marks the others
    for name, (label, gait) in zip(names, found.gaits.items(), strict=True):
        verdict = "certified" if gait.certified else "not certified"
        path = save_gait(gait, directory / name)
        out.print(f"{path}: {label}, {gait.cost:.6g} {gait.cost_unit}, {verdict}", soft_wrap=True)
    out.print(f"wrote {written}", soft_wrap=True)


def motors_text(table: MotorTable, command: str) -> str:
    """Return drives as a table of motors, `motors.toml`.

    Args:
        command: that chose them.
    """
    used = {one.motor.name: one.motor for one in table.drives}
    motors = {
        name: {part.name: getattr(motor, part.name) for part in fields(Motor)
               if part.name != "name"}
        for name, motor in used.items()
    }  # fmt: skip
    drives: list[dict[str, Any]] = [
        {
            "joints": one.joints, "motor": one.motor.name, "ratio": one.ratio,
            "efficiency": one.efficiency, "friction": one.friction,
        }
        for one in table.drives
    ]  # fmt: skip
    return _head(command) + tomli_w.dumps({"motors": motors, "drives": drives})


def _head(command: str) -> str:
    return f"# Motors and gears that gaitopt {command} chose; for --motors. SI units.\n\n"
