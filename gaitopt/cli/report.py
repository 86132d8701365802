"""A gait as tables for people: the walk, the motors, the ground, the proof."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console, RenderableType
from rich.rule import Rule
from rich.table import Table
from rich.text import Text

from gaitopt.cli.cells import BAR, bar, fixed, new_table, number, share
from gaitopt.cli.proof import proof_table
from gaitopt.cli.screen import WIDTH
from gaitopt.design.summary import summarise
from gaitopt.gait.result import Gait
from gaitopt.view.visible import visible


def print_gait(console: Console, gait: Gait) -> None:
    """Print everything a roboticist asks of a gait."""
    facts: Any = summarise(gait)
    width = min(console.width, WIDTH)
    for part in (
        _headline(facts),
        _walk(facts),
        _joints(facts["joints"], bars=width >= WIDTH),
        _ground(facts["contact"], facts["impact"]),
        proof_table(facts["solver"], facts["certificate"]),
    ):
        console.print(part, width=width)
        console.print()


def _headline(facts: Any) -> RenderableType:
    certified = facts["certificate"]["certified"]
    verdict = ("certified", "bold green") if certified else ("not certified", "bold yellow")
    speed = facts["walk"]["speed_m_per_s"]
    name = visible(facts["robot"]["name"] or "") or "the robot"
    return Rule(Text.assemble((f"{name} walks at {speed:.3f} m/s", "bold"), "  ", verdict))


def _walk(facts: Any) -> Table:
    walk, robot = facts["walk"], facts["robot"]
    table = Table.grid(padding=(0, 2))
    for style, width in (("dim", 9), ("bold", 18), ("dim", 14), ("bold", 13)):
        table.add_column(style=style, min_width=width)
    table.add_row(
        "cost (squared torque)", number(walk["cost_N2ms"], "N²·m·s", 7),
        "mechanical cost of transport", number(walk["mechanical_cost_of_transport"], ""),
    )  # fmt: skip
    table.add_row(
        "step", f"{walk['step_length_m']:.3f} m in {walk['step_duration_s']:.3f} s",
        "mechanical work per step", number(walk["mechanical_work_per_step_J"], "J"),
    )  # fmt: skip
    table.add_row(
        "robot", f"{number(robot['mass_kg'], 'kg', 4)}, legs {number(robot['leg_length_m'], 'm')}",
        "cadence", f"{walk['steps_per_minute']:.0f} steps/min",
    )  # fmt: skip
    return table


def _joints(joints: list[Mapping[str, Any]], *, bars: bool) -> Table:
    length = BAR if bars else 0
    table = new_table(
        "Motors", "joint", "leg", ">peak\nN·m", ">RMS\nN·m", "torque\nof limit, N·m",
        ">peak\nrad/s", "speed\nof limit, rad/s", ">peak\nW",
    )  # fmt: skip
    for i, joint in enumerate(joints):
        table.add_row(
            visible(joint["joint"]) if i % 2 == 0 else "",
            joint["leg"],
            f"{joint['peak_torque_Nm']:.1f}",
            f"{joint['rms_torque_Nm']:.1f}",
            bar(joint["torque_used"], joint["torque_limit_Nm"], length),
            f"{joint['peak_speed_rad_per_s']:.2f}",
            bar(joint["speed_used"], joint["speed_limit_rad_per_s"], length),
            f"{joint['peak_power_W']:.0f}",
        )
    return table


def _ground(contact: Mapping[str, Any], impact: Mapping[str, Any]) -> Table:
    table = new_table(
        "Ground", "", ">CoP to edge, mm\nfront", ">\nrear", ">\nleft", ">\nright",
        "friction\nused", "vertical\npush",
    )  # fmt: skip
    low, high = contact["least_vertical_force_N"], contact["largest_vertical_force_N"]
    rows = (
        ("stance foot", contact, f"{low:.0f} to {high:.0f} N"),
        ("landing foot, impact", impact, f"{impact['vertical_impulse_Ns']:.2f} N·s"),
    )
    for name, facts, vertical in rows:
        edges = facts["cop_to_edge_mm"] or {}
        distances = [fixed(edges.get(edge), 1) for edge in ("front", "rear", "left", "right")]
        used = share(facts["friction_used"], facts["friction_limit"])
        table.add_row(name, *distances, used, vertical)
    return table
