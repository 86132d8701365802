"""The report of a co-design: before, after, what moved, what holds it."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from gaitopt.atomic import write_atomically
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
_STYLE = """:root{color-scheme:light dark}
body{font:.875rem/1.45 system-ui,sans-serif;max-width:54rem;margin:0 auto;padding:0 1rem 2rem}
h1{font-size:1.25rem}h2{font-size:.94rem;margin:26px 0 6px}.table{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{text-align:left;vertical-align:top;padding:3px 14px 3px 0;border-bottom:1px solid #8884}
th{font-weight:normal;opacity:.7}.number{text-align:right}.number,.short{white-space:nowrap}
img{width:100%;min-width:40rem;margin:10px 0;border-radius:8px}ul{padding-left:1.4em}"""
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
    with styled():
        picture = base64.b64encode(rendered(codesign_figure(summary), "png")).decode()
    held = summary["held"] or ["No range holds it: the gradient vanishes inside all of them."]
    parts = [
        f"<h1>Co-design of {html_text(summary['robot'])}</h1>",
        f"<p>Cost of all walks: {summary['before']:.6g} to {summary['after']:.6g} "
        f"{html_text(unit)}, {100.0 * share:+.2f} %, in {len(summary['trials'])} designs and "
        f"{summary['evaluations']} evaluations of walks.</p>",
        table_text(Section("What moved", _NUMBERS, moved)),
        table_text(Section(f"Cost of a walk before and after, {unit}", _WALKS, walks)),
        '<div class="table"><img alt="cost of every walk and of every design" '
        f'src="data:image/png;base64,{picture}"></div>',
        "<h2>What holds it</h2>",
        "<ul>" + "".join(f"<li>{html_text(text)}</li>" for text in held) + "</ul>",
        "<p>What each motor must deliver, before and after, here in the first walk: "
        "<code>gaitopt requirements before/1.npz --against after/1.npz</code></p>",
    ]
    page = (
        '<!doctype html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Co-design of {html_text(summary['robot'])}</title>"
        f"<style>{_STYLE}</style><body>{''.join(parts)}</body></html>\n"
    )
    return write_atomically(path, page.encode())


def codesign_figure(summary: Mapping[str, Any]) -> Figure:
    """Return the costs of every walk before and after, and of every design in turn."""
    names = [name_on_figure(walk["walk"]) for walk in summary["walks"]]
    figure = new_figure(9.0, max(3.0, 1.2 + _BAR * len(names)))
    left, right = figure.subplots(1, 2)
    places = np.arange(len(names))
    for k, (name, colour) in enumerate((("before", GREY), ("after", SWING))):
        values = [walk[name] for walk in summary["walks"]]
        left.barh(places + (k - 0.5) * 0.4, values, 0.4, label=name, color=colour)
    left.set_yticks(places, names)
    left.invert_yaxis()
    left.grid(visible=False, axis="y")
    label_axes(left, f"cost [{summary['cost_unit']}]", "", "every walk")
    figure.legend(loc="outside lower left", ncols=2)
    right.plot([trial["cost"] for trial in summary["trials"]], "o-", markersize=3.0, color=SWING)
    right.xaxis.set_major_locator(MaxNLocator(integer=True))
    label_axes(right, "design", f"cost of all [{summary['cost_unit']}]", "every design in turn")
    return figure
