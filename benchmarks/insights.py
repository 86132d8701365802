"""What designers would guess, and what the optimum says: the study of docs/insights.md.

    python benchmarks/insights.py [--quick] [--only NAME]    run it, one walk after the other
    python benchmarks/insights.py --write                    make the page and its picture of the results

Each question has a guess that was written down before its walks were designed, and variants that are
options of `gaitopt optimise`, so that each number can be made again by the command in the table.
"""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from common import RESULTS, arguments, save
from tables import table

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.cli.config import option_words
from gaitopt.cli.request import make_request
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.errors import GaitoptError
from gaitopt.view.figure_style import LIMIT, SWING, label_axes, new_figure, styled
from gaitopt.view.figures import rendered

ROOT = Path(__file__).parents[1]
PAGE, PICTURE = ROOT / "docs" / "insights.md", ROOT / "docs" / "images" / "insights.png"
ROBOTS: dict[str, dict[str, Any]] = {
    "biped13": {"speed": 0.8},
    "g1": {"robot": "g1", "speed": 0.6},
    "talos": {"robot": "talos", "speed": 0.5},
}
FEET = {
    "biped13": ("left_foot", "right_foot"),
    "g1": ("left_ankle_roll_link", "right_ankle_roll_link"),
    "talos": ("leg_left_6_link", "leg_right_6_link"),
}


@dataclass(frozen=True)
class Question:
    """A question with its guess.

    Attributes:
        name: short.
        asked: as a designer would ask it.
        guess: what experience says, written before the study.
        said: what the study says, written after it.
        variants: options by label; a function of the robot's name returns them.
    """

    name: str
    asked: str
    guess: str
    said: str
    variants: dict[str, Any] = field(default_factory=dict)


def _sole(longer: float) -> Any:
    def options(name: str) -> dict[str, Any]:
        sole = robot_by_name(name).sole
        more = (longer - 1.0) * (sole.toe - sole.heel) / 2.0
        sides = (sole.toe + more, sole.heel - more, sole.left, sole.right)
        return {"sole": ",".join(f"{side:.4f}" for side in sides)}

    return options


def _load(share: float, where: str) -> Any:
    def options(name: str) -> dict[str, Any]:
        mass = share * robot_by_name(name).mass
        if where == "feet":
            return {"payload": tuple(f"{mass / 2.0:.3f}kg@{link}" for link in FEET[name])}
        return {"payload": (f"{mass:.3f}kg@{where}",)}

    return options


def _armature(value: float) -> Any:
    return lambda name: {"armature": {"*": value}}


def _duration(factor: float) -> Any:
    def options(name: str) -> dict[str, Any]:
        usual = make_request(ROBOTS[name], None).task.duration
        return {"duration": round(factor * usual, 4)}

    return options


QUESTIONS = (
    Question(
        "sole length",
        "Does a longer sole make walking cheaper?",
        "Yes: the centre of pressure has more room, so the ankle can do more.",
        "",
        {"20 % shorter": _sole(0.8), "20 % longer": _sole(1.2)},
    ),
    Question(
        "heavy feet",
        "What costs more: 4 % of the mass on the feet, or the same on the torso?",
        "The feet, by far: they are swung to and fro.",
        "",
        {"on the torso": _load(0.04, "torso"), "on the feet": _load(0.04, "feet")},
    ),
    Question(
        "knee reserve",
        "What does it cost to keep the knees bent by 0.3 rad more?",
        "Tens of percent: a bent stance knee carries the weight all the time.",
        "",
        {"knee 0.2 rad": {"knee_flexion": 0.2}, "knee 0.4 rad": {"knee_flexion": 0.4}},
    ),
    Question(
        "cadence",
        "At the same speed, fewer long steps or more short ones?",
        "There is an optimum near the usual cadence; 15 % to either side costs some percent.",
        "",
        {"steps 15 % shorter in time": _duration(0.85), "15 % longer": _duration(1.15)},
    ),
    Question(
        "rotor inertia",
        "Do heavier rotors, or higher gear ratios, make the walk dearer?",
        "Yes: they must be sped up and slowed down in every step.",
        "",
        {
            "0.001 kg·m²": _armature(1e-3),
            "0.01 kg·m²": _armature(1e-2),
            "0.1 kg·m²": _armature(0.1),
        },
    ),
    Question(
        "slope",
        "Is it cheaper to walk down 5 % than on the level?",
        "Yes: gravity pushes.",
        "",
        {"5 % up": {"slope": 0.05}, "5 % down": {"slope": -0.05}},
    ),
    Question(
        "toe-off",
        "Does turning about the toe at the end of the step help?",
        "A little, a few percent, at high speed only.",
        "",
        {"toe-off": {"toe_off": 0.7}},
    ),
    Question(
        "clearance",
        "What does lifting the swing foot 5 cm instead of 3 cm cost?",
        "Some percent.",
        "",
        {"5 cm": {"clearance": 0.05}, "8 cm": {"clearance": 0.08}},
    ),
    Question(
        "friction",
        "How much dearer is a floor with half the friction?",
        "Hardly: walking needs a quarter of the usual friction.",
        "",
        {"0.35": {"friction": 0.35}, "0.2": {"friction": 0.2}},
    ),
    Question(
        "upright trunk",
        "What does it cost to keep the trunk still?",
        "It is nearly free, or even saves effort.",
        "",
        {"roll and pitch within 1 degree": {"trunk_roll": 0.0175, "trunk_pitch": 0.0175}},
    ),
    Question(
        "one motor for all joints",
        "How weak may one motor type be that drives every joint?",
        "At the largest torque of the free optimum; any less is infeasible.",
        "",
        {"60 % of the peak": {"share": 0.6}, "40 % of the peak": {"share": 0.4}},
    ),
    Question(
        "robust margins",
        "What do margins cost with which the walk survives feedback (preset robust)?",
        "Ten to twenty percent.",
        "",
        {"preset robust": {"preset": "robust"}},
    ),
)


def walk(name: str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return what came of a walk: verdict, cost, largest torque and speed, and its command."""
    given = {**ROBOTS[name], **changes}
    words = ["gaitopt", "optimise"]
    for key, value in given.items():
        words += option_words(key, value)
    row: dict[str, Any] = {"robot": name, "command": shlex.join(words)}
    try:
        request = make_request(given, None)
        found = design_gait(request.robot, request.task, request.options, starts=request.starts)
    except GaitoptError as error:
        return {**row, "verdict": str(error).partition("\n")[0][:120], "cost": None}
    gait = found.gait
    return {
        **row,
        "verdict": found.certificate.verdict,
        "cost": gait.cost,
        "torque": float(np.abs(gait.torque).max()),
        "speed": float(np.abs(gait.dq).max()),
        "turns": bool(gait.turning),
    }


def run(quick: bool, only: str | None) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    for name in list(ROBOTS)[: 1 if quick else None]:
        usual = walk(name, {})
        rows.append({"question": "", "variant": "as it is", **usual})
        for question in QUESTIONS[: 1 if quick else None]:
            if only not in (None, question.name):
                continue
            for label, variant in question.variants.items():
                changes = variant(name) if callable(variant) else dict(variant)
                if "share" in changes:
                    changes = {"torque_limit": round(changes["share"] * usual["torque"], 2)}
                row = walk(name, changes)
                rows.append({"question": question.name, "variant": label, **row})
                print(name, question.name, label, row["verdict"], row["cost"], flush=True)
    return rows


def change(rows: list[dict[str, Any]], robot: str, question: str, variant: str) -> str:
    """Return the change of the cost [%] as text, or why there is none."""
    known = {(r["robot"], r["question"], r["variant"]): r for r in rows}
    usual, row = known[robot, "", "as it is"], known[robot, question, variant]
    if row["cost"] is None:
        return "no walk"
    percent = 100.0 * (row["cost"] / usual["cost"] - 1.0)
    mark = "" if row["verdict"] == "certified" else " (not certified)"
    return f"{percent:+.1f} %{mark}"


def text(rows: list[dict[str, Any]]) -> str:
    """Return the page."""
    usual = {r["robot"]: r for r in rows if r["question"] == ""}
    parts = [
        "# What one would guess wrongly\n",
        "Questions that designers answer from experience, with the guess as it was written down\n"
        "before the walks were designed, and the optimum's answer for three robots. Every number is\n"
        "the cost of a walk (squared torque per metre) against that of the same robot as it is. The\n"
        "commands make those of G1 again. Made by `benchmarks/insights.py`.\n",
        "![Changes of the cost](images/insights.png)\n",
        table(
            ("robot", "walk", "cost [N²·m·s]", "largest torque [N·m]"),
            [
                (n, f"{r['command']}", f"{r['cost']:.1f}", f"{r['torque']:.1f}")
                for n, r in usual.items()
            ],
        ),
    ]
    for number, question in enumerate(QUESTIONS, 1):
        parts += [
            f"\n## {number}. {question.asked}\n",
            f"**Guess.** {question.guess}\n",
            f"**The optimum.** {question.said}\n",
            table(
                ("", *usual),
                [
                    (label, *(change(rows, name, question.name, label) for name in usual))
                    for label in question.variants
                ],
            ),
        ]
        commands = [
            r["command"] for r in rows if r["question"] == question.name and r["robot"] == "g1"
        ]
        parts.append("\n```\n" + "\n".join(commands) + "\n```\n")
    return "\n".join(parts)


def picture(rows: list[dict[str, Any]]) -> bytes:
    """Return bars of the changes of the cost, a panel for each robot."""
    names = [(q.name, label) for q in QUESTIONS for label in q.variants]
    known = {(r["robot"], r["question"], r["variant"]): r for r in rows}
    with styled():
        figure = new_figure(9.0, 0.2 * len(names) + 1.2)
        panels = figure.subplots(1, len(ROBOTS), sharey=True)
        for axes, robot in zip(panels, ROBOTS, strict=True):
            usual = known[robot, "", "as it is"]["cost"]
            for row, key in enumerate(names):
                cost = known[(robot, *key)]["cost"]
                if cost is None:
                    axes.text(2.0, row, "no walk", fontsize=6.0, va="center", color=LIMIT)
                    continue
                percent = 100.0 * (cost / usual - 1.0)
                axes.barh(
                    row, np.clip(percent, -60.0, 100.0), color=LIMIT if percent > 0 else SWING
                )
                if percent > 100.0:
                    axes.text(98.0, row, f"+{percent:.0f} %", fontsize=6.0, va="center", ha="right",
                              color="white")  # fmt: skip
            axes.set_yticks(range(len(names)), [f"{q}: {v}" for q, v in names], fontsize=6.5)
            axes.set_xlim(-60.0, 100.0)
            label_axes(axes, "change of the cost [%]", "", robot)
        panels[0].invert_yaxis()
    return rendered(figure, "png")


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--only")
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    small_matrices()
    if asked.write:
        rows = json.loads((RESULTS / "insights.json").read_text())["data"]
        PAGE.write_text(text(rows), encoding="utf-8")
        PICTURE.write_bytes(picture(rows))
        return
    save("insights", run(asked.quick, asked.only), asked.quick or asked.only is not None)


if __name__ == "__main__":
    main()
