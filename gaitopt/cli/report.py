"""A gait as tables for people, and what is odd about its robot."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from gaitopt.cli.config import SCHEMA, Settings, option_words
from gaitopt.cli.display import (
    ABSENT,
    BAR,
    NARROW,
    WIDTH,
    bar,
    facts_grid,
    fixed,
    headline,
    new_table,
    number,
    screen,
    share,
    warn,
)
from gaitopt.cli.request import Request
from gaitopt.design.shadow_prices import SETTING
from gaitopt.design.summary import by_motion, proof_rows, summarise
from gaitopt.escape import printable
from gaitopt.gait.presets import foreign_margins
from gaitopt.gait.result import Gait, Recorded
from gaitopt.importers.report import Finding, findings_of
from gaitopt.units import motion_words

_PRICES = 6
"""Numbers whose worth is shown, those of the greatest effect."""


def certificate_table(solver: Mapping[str, Any], certificate: Mapping[str, Any]) -> Table:
    """Return the table of a gait's solver and certificate records (of `summarise`)."""
    table = new_table("Proof", "check", "result", ">allowed")
    for row in proof_rows(solver, certificate):
        table.add_row(*row)
    style = "bold green" if certificate["certified"] else "bold yellow"
    table.add_row(
        "verdict", Text(printable(str(certificate["verdict"] or ABSENT)), style=style), ""
    )
    return table


def print_gait(console: Console, gait: Gait) -> None:
    """Print everything a roboticist asks of a gait."""
    facts: Any = summarise(gait)
    width = min(console.width, WIDTH)
    for part in (
        _headline(facts, width),
        _walk(facts, width),
        *_motors([*facts["joints"], *facts["linkages"]], bars=width >= WIDTH),
        _ground(facts["contact"], facts["impact"]),
        *_prices(facts["shadow_prices"]),
        certificate_table(facts["solver"], facts["certificate"]),
    ):
        console.print(part, width=width)
        console.print()


def _headline(facts: Any, width: int) -> RenderableType:
    certified = facts["certificate"]["certified"]
    verdict = ("certified", "bold green") if certified else ("not certified", "bold yellow")
    speed = facts["walk"]["speed_m_per_s"]
    name = facts["robot"]["name"] or "the robot"
    return headline(f"{name} walks at {fixed(speed, 3)} m/s", verdict, width)


def _walk(facts: Any, width: int) -> Table:
    walk, robot, contact = facts["walk"], facts["robot"], facts["contact"]
    transport = walk["costs_of_transport"]
    found = [
        (
            f"cost ({walk['cost_words'].removesuffix(' per metre')})",
            number(walk["cost"], walk["cost_unit"], 7),
        ),
        ("transport cost", f"{number(walk['mechanical_cost_of_transport'], '')} mechanical"),
        ("step", f"{fixed(walk['step_length_m'], 3)} m in {fixed(walk['step_duration_s'], 3)} s"),
        ("mechanical work", f"{number(walk['mechanical_work_per_step_J'], 'J')} per step"),
        (
            "robot",
            f"{number(robot['mass_kg'], 'kg', 4)}, legs {number(robot['leg_length_m'], 'm')}",
        ),
        ("cadence", f"{fixed(walk['steps_per_minute'], 0)} steps/min"),
        ("transport cost", f"{number(transport['positive_work'], '')} positive work"),
    ]
    if (electrical := transport["electrical"]) is not None:
        found.append(("transport cost", f"{number(electrical, '')} electrical"))
    elif width >= NARROW:
        found.append(("", ""))
    if (walk["ground"], walk["load"]) != ("level", "none"):
        found += [("ground", walk["ground"]), ("load", printable(walk["load"]))]
    if (begins := contact["foot_turns_from_s"]) is not None:
        found += [
            ("stance foot", f"turns from {fixed(begins, 3)} s"),
            ("angle as it leaves", number(contact["foot_angle_rad"], "rad")),
        ]
    if (flat := contact["flat_from_s"]) is not None:
        found += [
            ("landing", f"on the heel, flat at {fixed(flat, 3)} s"),
            ("angle at landing", number(contact["landing_angle_rad"], "rad")),
        ]
    return facts_grid(found, width)


def _motors(motors: list[Mapping[str, Any]], *, bars: bool) -> Iterator[Table]:
    """Yield the table of joints and motors that turn, and that of motors that slide, if any."""
    length = BAR if bars else 0
    for slides, own in by_motion(motors):
        words = partial(motion_words, slides=slides)
        heads = (
            ">peak\nN·m", ">RMS\nN·m", "torque\nof limit, N·m", ">peak\nrad/s",
            "speed\nof limit, rad/s", ">peak\nW",
        )  # fmt: skip
        title = "Linear motors" if slides else "Motors"
        table = new_table(title, "joint", "leg", *map(words, heads), keys=2)
        for i, one in enumerate(own):
            table.add_row(
                printable(one["joint"]) if i % 2 == 0 else "",
                one["leg"],
                fixed(one[words("peak_torque_Nm")], 1),
                fixed(one[words("rms_torque_Nm")], 1),
                bar(one[words("torque_used")], one[words("torque_limit_Nm")], length),
                fixed(one[words("peak_speed_rad_per_s")], 2),
                bar(one["speed_used"], one[words("speed_limit_rad_per_s")], length),
                fixed(one["peak_power_W"], 0),
            )
        yield table


def _prices(records: Any) -> list[Table]:
    """Return what the numbers that a walk presses on are worth, as a table if there are any."""
    table = new_table("What limits cost", "number", ">value", ">one unit more changes the cost by")
    try:
        for price in [one for one in records or () if one["kind"] == SETTING][:_PRICES]:
            per = f"{price['cost_unit']} per {price['unit'] or 'unit'}"
            table.add_row(
                f"{printable(price['words'])} ({printable(price['name'])})",
                number(price["value"], printable(price["unit"]), 4),
                f"{price['cost_per_unit']:+.3g} {printable(per)}",
            )
    except (KeyError, TypeError, ValueError):  # a file says whatever it likes
        return []
    return [table] if table.row_count else []


def _ground(contact: Mapping[str, Any], impact: Mapping[str, Any]) -> Table:
    table = new_table(
        "Ground", "centre of pressure\nto the edge, mm", ">front", ">rear", ">left", ">right",
        "friction\nused", "vertical\npush",
    )  # fmt: skip
    low, high = contact["least_vertical_force_N"], contact["largest_vertical_force_N"]
    push = f"{fixed(impact['vertical_impulse_Ns'], 2)} N·s"
    push = "none, at zero speed" if impact["at_zero_speed"] else push
    rows = [
        ("stance foot", contact, f"{fixed(low, 0)} to {fixed(high, 0)} N"),
        ("landing foot", impact, push),
    ]
    if (rear := impact["rear_foot"]) is not None:
        rows.append(("rear foot, impact", rear, f"{rear['vertical_impulse_Ns']:.2g} N·s"))
    if (flat := impact["foot_flat"]) is not None:
        rows.append(("as it lies flat", flat, f"{fixed(flat['vertical_impulse_Ns'], 2)} N·s"))
    if (front := contact["front_foot"]) is not None:
        low, high = front["least_vertical_force_N"], front["largest_vertical_force_N"]
        rows.append(("front foot, both stand", front, f"{fixed(low, 0)} to {fixed(high, 0)} N"))
    for name, facts, vertical in rows:
        edges = facts["cop_to_edge_mm"] or {}
        distances = [fixed(edges.get(edge), 1) for edge in ("front", "rear", "left", "right")]
        used = share(facts["friction_used"], facts["friction_limit"])
        table.add_row(name, *distances, used, vertical)
        for phase in contact["phases"] if facts is contact and len(contact["phases"]) > 1 else ():
            low, high = phase["least_vertical_force_N"], phase["largest_vertical_force_N"]
            name = f"  {printable(phase['contact'])} from {fixed(phase['begin_s'], 3)} s"
            used = share(phase["friction_used"], contact["friction_limit"])
            table.add_row(name, "", "", "", "", used, f"{fixed(low, 0)} to {fixed(high, 0)} N")
    return table


_FINDING_STYLES = {"warning": "bold yellow", "changed": "cyan"}  # printed in full
_NAME = re.compile("'[^']*'")
_RECORDED = "the record 'findings' of the gait has them"


def print_findings(console: Console, findings: Iterable[Finding], all_of_them: str) -> None:
    """Print what is worth a look and what was changed, and how much was guessed.

    Args:
        all_of_them: where to see every finding.
    """
    known = list(findings)
    for how, style in _FINDING_STYLES.items():
        for subject, text in _gathered(f for f in known if f.how == how):
            said = Text.assemble((f"{how}:", style), f" {printable(subject)}: {printable(text)}")
            console.print(said)
    topics = dict.fromkeys(f.topic for f in known if f.how == "guessed")
    if topics:
        count = sum(f.how == "guessed" for f in known)
        facts = "1 fact was" if count == 1 else f"{count} facts were"
        line = f"guessed: {facts}, about {', '.join(topics)}; {all_of_them}"
        console.print(line)


def _gathered(findings: Iterable[Finding]) -> list[tuple[str, str]]:
    """Return subject and text of findings; what is the same but for a name is said once."""
    alike: dict[tuple[str, str], list[Finding]] = {}
    for one in findings:
        alike.setdefault((one.topic, _NAME.sub("''", one.text)), []).append(one)
    told = []
    for first, *others in alike.values():
        same = f"; the same at {', '.join(f.subject for f in others)}" if others else ""
        told.append((first.subject, first.text + same))
    return told


def print_doubts(console: Console, request: Request) -> None:
    """Print what is odd, guessed and changed about the robot asked for, and margins not its own."""
    print_findings(console, request.robot.findings, inspect_command(request.settings))
    if foreign := foreign_margins(request.robot, request.task, "--preset humanoid"):
        warn(console, "warning", foreign)


def print_findings_of(gait: Recorded) -> None:
    """Print on stderr what was known about the robot of a gait when it was designed."""
    print_findings(screen(stderr=True), findings_of(gait.fact("findings")), _RECORDED)


def inspect_command(settings: Settings) -> str:
    """Return the sentence that names the command which shows everything about a robot."""
    words = ["gaitopt", "inspect"]
    for name in SCHEMA["robot"]:
        words += option_words(name, settings.get(name))
    return f"all of it: {shlex.join(words)}"
