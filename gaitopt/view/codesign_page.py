"""The report of a co-design: before, after, what moved, what holds it."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gaitopt.atomic import write_atomically
from gaitopt.escape import html_text
from gaitopt.view.figure_style import label_axes, new_figure, rendered, styled
from gaitopt.view.page_parts import Section, table_text

_WALKS = ("walk", "weight", "before", "after", "change", "certified")
_STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:54rem;margin:2rem auto;padding:0 1rem}
table{border-collapse:collapse;margin:1rem 0}td,th{padding:.2rem .8rem;text-align:right;
border-bottom:1px solid #ccc}td:first-child,th:first-child{text-align:left}img{max-width:100%}
@media(prefers-color-scheme:dark){body{background:#16181c;color:#e6e6e6}img{background:#fff}}"""


def write_codesign_page(summary: Mapping[str, Any], path: Path) -> Path:
    """Write the report of a co-design as a page complete in one file.

    Args:
        summary: as `gaitopt codesign` writes it as JSON.
        path: of the page.

    Returns:
        The path written.

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
        table_text(Section("What moved", ("", "of the robot", "begun at", "found", ""), moved)),
        table_text(Section("Before and after", _WALKS, walks)),
        f'<img alt="cost of every walk and of every design" src="data:image/png;base64,{picture}">',
        "<h2>What holds it</h2>",
        "<ul>" + "".join(f"<li>{html_text(text)}</li>" for text in held) + "</ul>",
    ]
    page = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Co-design</title>'
        f"<style>{_STYLE}</style><body>{''.join(parts)}</body></html>\n"
    )
    return write_atomically(path, page.encode())


def codesign_figure(summary: Mapping[str, Any]) -> Figure:
    """Return the costs of every walk before and after, and of every design in turn."""
    figure = new_figure(9.0, 3.2)
    left, right = figure.subplots(1, 2)
    places = np.arange(len(summary["walks"]))
    for k, name in enumerate(("before", "after")):
        values = [walk[name] for walk in summary["walks"]]
        left.bar(places + (k - 0.5) * 0.4, values, 0.4, label=name)
    left.set_xticks(places, [str(k + 1) for k in places])
    label_axes(left, "walk", f"cost [{summary['cost_unit']}]", "every walk")
    left.legend()
    right.plot([trial["cost"] for trial in summary["trials"]], "o-", markersize=3.0)
    label_axes(right, "design", f"cost of all [{summary['cost_unit']}]", "every design in turn")
    return figure
