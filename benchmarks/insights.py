"""What designers would guess, and what the optimum says: the study of docs/insights.md.

    python benchmarks/insights.py [--quick]                  run it
    python benchmarks/insights.py --only NAME                renew the answer to one question
    python benchmarks/insights.py --write                    make the page and its picture

insights.toml has the questions, with a guess each that was written down before the walks were
designed. Variants are options of `gaitopt optimise`, so that each number can be made again.
"""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
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
from gaitopt.importers.text_files import parse_toml
from gaitopt.view.figure_style import LIMIT, SWING, label_axes, new_figure, rendered, styled

ROOT = Path(__file__).parents[1]
TEXTS = Path(__file__).with_suffix(".toml")
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


def _sole(longer: float) -> Any:
    def options(name: str) -> dict[str, Any]:
        sole = robot_by_name(name).sole
        more = (longer - 1.0) * sole.length / 2.0
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


VARIANTS: dict[str, dict[str, Any]] = {
    "sole length": {"20 % shorter": _sole(0.8), "20 % longer": _sole(1.2)},
    "heavy feet": {"on the torso": _load(0.04, "torso"), "on the feet": _load(0.04, "feet")},
    "knee reserve": {"knee 0.2 rad": {"knee_flexion": 0.2}, "knee 0.4 rad": {"knee_flexion": 0.4}},
    "cadence": {"steps 15 % shorter in time": _duration(0.85), "15 % longer": _duration(1.15)},
    "rotor inertia": {
        "0.001 kg·m²": _armature(1e-3),
        "0.01 kg·m²": _armature(1e-2),
        "0.1 kg·m²": _armature(0.1),
    },
    "slope": {"5 % up": {"slope": 0.05}, "5 % down": {"slope": -0.05}},
    "toe-off": {"toe-off": {"toe_off": 0.7}},
    "clearance": {"5 cm": {"clearance": 0.05}, "8 cm": {"clearance": 0.08}},
    "friction": {"0.35": {"friction": 0.35}, "0.2": {"friction": 0.2}},
    "upright trunk": {
        "roll and pitch within 1 degree": {"trunk_roll": 0.0175, "trunk_pitch": 0.0175}
    },
    "one motor for all joints": {
        "60 % of the peak": {"share": 0.6},
        "40 % of the peak": {"share": 0.4},
    },
    "robust margins": {"preset robust": {"preset": "robust"}},
}


@dataclass(frozen=True)
class Question:
    """A question, the guess that was written down before the study, and what came of it."""

    name: str
    asked: str
    guess: str
    said: str


QUESTIONS = tuple(
    Question(name, **record) for name, record in parse_toml(TEXTS.read_bytes(), TEXTS.name).items()
)


HEAD = """\
Questions that designers answer from experience, with the guess as it was written down before the
walks were designed, and the optimum's answer for three robots. Every number is the cost of a walk
(squared torque per metre) against that of the same robot as it is. The commands make those of G1
again. Made by `benchmarks/insights.py`.
"""


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
    turn = gait.meta.get("phase_times")
    if turn is not None:  # of both walks, for they have the same limits
        row |= {"against": turn["flat_cost"]}
    return {
        **row,
        "verdict": found.certificate.verdict,
        "cost": gait.cost if turn is None else turn["cost"],
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
            for label, variant in VARIANTS[question.name].items():
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
    percent = 100.0 * (row["cost"] / row.get("against", usual["cost"]) - 1.0)
    mark = "" if row["verdict"] == "certified" else " (not certified)"
    return f"{percent:+.1f} %{mark}"


def text(rows: list[dict[str, Any]]) -> str:
    """Return the page."""
    usual = {r["robot"]: r for r in rows if r["question"] == ""}
    parts = [
        "# What one would guess wrongly\n",
        HEAD,
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
            f"**The optimum.** {question.said.strip()}\n",
            table(
                ("", *usual),
                [
                    (label, *(change(rows, name, question.name, label) for name in usual))
                    for label in VARIANTS[question.name]
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
    names = [(q.name, label) for q in QUESTIONS for label in VARIANTS[q.name]]
    known = {(r["robot"], r["question"], r["variant"]): r for r in rows}
    with styled():
        figure = new_figure(9.0, 0.2 * len(names) + 1.2)
        panels = figure.subplots(1, len(ROBOTS), sharey=True)
        for axes, robot in zip(panels, ROBOTS, strict=True):
            usual = known[robot, "", "as it is"]["cost"]
            for row, key in enumerate(names):
                other = known[(robot, *key)]
                if other["cost"] is None:
                    axes.text(2.0, row, "no walk", fontsize=6.0, va="center", color=LIMIT)
                    continue
                percent = 100.0 * (other["cost"] / other.get("against", usual) - 1.0)
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
    rows = run(asked.quick, asked.only)
    if asked.only is not None and not asked.quick:  # the others stay as they are
        new = [row for row in rows if row["question"]]
        keys = {(row["robot"], row["question"]) for row in new}
        kept = json.loads((RESULTS / "insights.json").read_text())["data"]
        rows = [row for row in kept if (row["robot"], row["question"]) not in keys] + new
    save("insights", rows, asked.quick)


if __name__ == "__main__":
    main()
