"""The report of a co-design: before, after, what moved, what holds it."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from gaitopt.atomic import write_atomically
from gaitopt.bounds import percentage
from gaitopt.escape import html_text
from gaitopt.view.figure_style import (
    GREY,
    SWING,
    label_axes,
    name_on_figure,
    new_figure,
    rendered,
    styled,
)
from gaitopt.view.page_parts import Section, table_text

_NUMBERS = ("", ">of the robot", ">begun at", ">found", "unit")
_WALKS = ("walk", ">weight", ">before", ">after", ">change", "certified")
_MOTORS = ("motor", ">peak torque", ">peak speed", ">RMS torque", ">peak power")
_STYLE = """:root{color-scheme:light dark}
body{font:.875rem/1.45 system-ui,sans-serif;max-width:54rem;margin:0 auto;padding:0 1rem 2rem}
h1{font-size:1.25rem}h2{font-size:.94rem;margin:26px 0 6px}.table{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{text-align:left;vertical-align:top;padding:3px 14px 3px 0;border-bottom:1px solid #8884}
th{font-weight:normal;opacity:.7}.number{text-align:right}.number,.short{white-space:nowrap}
.pictures{display:flex;flex-wrap:wrap;gap:10px;margin:10px 0}
img{flex:1 1 22rem;min-width:0;max-width:100%;border-radius:8px;object-fit:contain}
ul{padding-left:1.4em}"""
_SEEN = 0.5  # %, of a change that is told
_BAR = 0.32  # inch of a walk, both bars


def write_codesign_page(summary: Mapping[str, Any], path: Path) -> Path:
    """Write the report of a co-design as a page complete in one file.

    Args:
        summary: as `gaitopt codesign` writes it as JSON.

    Raises:
        InputError: the file cannot be written.
    """
    unit, share = summary["cost_unit"], summary["after"] / summary["before"] - 1.0
    moved = tuple(
        (name.replace("_", " "), f"{one['of_the_robot']:.4g}", f"{one['begun_at']:.4g}",
         f"{one['found']:.4g}", one["unit"])
        for name, one in summary["parameters"].items()
    )  # fmt: skip
    walks = tuple(
        (walk["walk"], f"{walk['weight']:g}", f"{walk['before']:.5g}", f"{walk['after']:.5g}",
         f"{100.0 * (walk['after'] / walk['before'] - 1.0):+.1f} %",
         "yes" if walk["certified"] else "no")
        for walk in summary["walks"]
    )  # fmt: skip
    motors = tuple((name, *before_and_after(one)) for name, one in summary["motors"].items())
    with styled():
        pictures = [_picture(draw(summary)) for draw in (walks_figure, designs_figure)]
    held = summary["held"] or ["No range holds it: the gradient vanishes inside all of them."]
    parts = [
        f"<h1>Co-design of {html_text(summary['robot'])}</h1>",
        f"<p>Cost of all walks: {summary['before']:.6g} to {summary['after']:.6g} "
        f"{html_text(unit)}, {100.0 * share:+.2f} %, in {len(summary['trials'])} designs and "
        f"{summary['evaluations']} evaluations of walks.</p>",
        table_text(Section("What moved", _NUMBERS, moved)),
        table_text(Section(f"Cost of a walk before and after, {unit}", _WALKS, walks)),
        f'<div class="pictures"><img alt="cost of every walk" src="{pictures[0]}">'
        f'<img alt="cost of every design" src="{pictures[1]}"></div>',
        table_text(
            Section("What the motors must deliver, the most over all walks", _MOTORS, motors)
        ),
        "<h2>What holds it</h2>",
        "<ul>" + "".join(f"<li>{html_text(text)}</li>" for text in held) + "</ul>",
        "<p>All of what the motors must deliver, here in the first walk: "
        "<code>gaitopt requirements before/1.npz --against after/1.npz</code></p>",
    ]
    page = (
        '<!doctype html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Co-design of {html_text(summary['robot'])}</title>"
        f"<style>{_STYLE}</style><body>{''.join(parts)}</body></html>\n"
    )
    return write_atomically(path, page.encode())


def before_and_after(motor: Mapping[str, Any]) -> Iterator[str]:
    """Yield each figure of a motor: before -> after, its change below."""
    for name, before in motor["before"].items():
        after, unit = motor["after"][name], motor["units"][name]
        change = percentage(before, after, motor["largest"][name])
        told = f"\n{change:+.0f} %" if change is not None and abs(change) >= _SEEN else ""
        yield f"{before:.3g} \u2192 {after:.3g} {unit}{told}"


def _picture(figure: Figure) -> str:
    return "data:image/png;base64," + base64.b64encode(rendered(figure, "png")).decode()


def walks_figure(summary: Mapping[str, Any]) -> Figure:
    """Return the costs of every walk before and after."""
    names = [name_on_figure(walk["walk"]) for walk in summary["walks"]]
    figure = new_figure(4.5, max(3.0, 1.2 + _BAR * len(names)))
    axes, places = figure.subplots(), np.arange(len(names))
    for k, (name, colour) in enumerate((("before", GREY), ("after", SWING))):
        values = [walk[name] for walk in summary["walks"]]
        axes.barh(places + (k - 0.5) * 0.4, values, 0.4, label=name, color=colour)
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    label_axes(axes, f"cost [{summary['cost_unit']}]", "", "every walk")
    figure.legend(loc="outside lower left", ncols=2)
    return figure


def designs_figure(summary: Mapping[str, Any]) -> Figure:
    """Return the cost of all walks with every design in turn."""
    figure = new_figure(4.5, 3.0)
    axes = figure.subplots()
    axes.plot([trial["cost"] for trial in summary["trials"]], "o-", markersize=3.0, color=SWING)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    label_axes(axes, "design", f"cost of all [{summary['cost_unit']}]", "every design in turn")
    return figure
