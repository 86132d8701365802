"""One self-contained page with the walking robot; it opens in any browser, without a network."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np

from gaitopt.atomic import write_atomically
from gaitopt.design.summary import payload_words
from gaitopt.escape import filled_template, html_text
from gaitopt.gait.ground import ground_of
from gaitopt.gait.result import Gait
from gaitopt.importers.report import findings_of
from gaitopt.view.animation import DEFAULT_STEPS, build_scene
from gaitopt.view.contacts import contact_colour, contact_words, contacts
from gaitopt.view.viewer import Recorder, meshcat, page_file, viewer_script


def write_page(
    gait: Gait,
    path: str | Path,
    steps: int = DEFAULT_STEPS,
    package_dirs: tuple[str, ...] = (),
) -> Path:
    """Write a page with the robot walking, complete in one file.

    The page has buttons for play, pause, slow motion and time; `page.html#t=0.35&paused` opens
    it at an instant.

    Args:
        gait: one step.
        path: the .html file.
        steps: how many to show.
        package_dirs: where to look for meshes named `package://...` in the URDF.

    Returns:
        The path written.

    Raises:
        InputError: steps < 1, or the path cannot be written.
        RobotError: the robot cannot be drawn.
    """
    return write_atomically(path, page_text(gait, steps, package_dirs).encode("utf-8"))


def page_text(gait: Gait, steps: int = DEFAULT_STEPS, package_dirs: tuple[str, ...] = ()) -> str:
    """Return the text of the page of `write_page`.

    Raises:
        InputError: steps < 1.
        RobotError: the robot cannot be drawn.
    """
    recorder = Recorder()
    scene = build_scene(meshcat.Visualizer(window=recorder), gait, steps, package_dirs)
    parts = {
        "@TITLE@": html_text(_title(gait)),
        "@FACTS@": "".join(f"<dt>{k}</dt><dd>{html_text(v)}</dd>" for k, v in facts(gait)),
        "@DURATION@": json.dumps(gait.duration * steps),
        "@STEP@": json.dumps(gait.duration),
        "@NOTE@": f"<p>{html_text(scene.note)}</p>" if scene.note else "",
        "@ROBOT@": _robot(gait),
        "@STANDING@": "<br>\n     ".join(_mark(contact) for contact in contacts(gait)),
        "@PHASES@": json.dumps(_phases(gait)),
        "@FEET@": json.dumps([html_text(foot) for foot in _feet(gait)]),
        "@SCALE@": f"{0.1 / scene.force_scale:.4g}",
        "@FIT@": page_file("fit.js"),
        "@COMMANDS@": recorder.text(),
        "@MESHCAT@": viewer_script(),
    }
    return filled_template(page_file("page.html"), parts)


def facts(gait: Gait) -> list[tuple[str, str]]:
    """Return what is known about a gait, for people: name, and value with unit."""
    cost, mass = gait.cost, gait.number("mass")
    known = [
        ("speed", f"{gait.speed:.3g} m/s"),
        ("step", f"{gait.step_length:.3f} m in {gait.duration:.3f} s"),
        ("ground", ground_of(gait).words or None),
        ("load", payload_words(gait) or None),
        ("mass", None if mass is None else f"{mass:.2f} kg"),
        ("cost", None if cost is None else f"{cost:.6g} {gait.cost_unit}"),
        ("stance foot", _stance(gait)),
        ("solver", gait.fact("status")),
        ("certificate", gait.fact("certificate", "verdict")),
    ]
    return [(name, str(value)) for name, value in known if value is not None]


def _mark(contact: str) -> str:
    """Return the line that explains the colour of a contact."""
    colour = f'<span class="mark" style="background:{contact_colour(contact)}"></span>'
    return f"{colour} foot {html_text(contact_words(contact))}"


def _phases(gait: Gait) -> list[dict[str, object]]:
    """Return the phases of a step for the bar under the time: words, colour, end as a share."""
    return [
        {
            "words": html_text(contact_words(phase.contact)),
            "colour": contact_colour(phase.contact),
            "end": phase.end / gait.duration,
        }
        for phase in gait.phases
    ]


def _feet(gait: Gait) -> list[str]:
    """Return what the feet are called, the one that stands first before the other."""
    return [name.replace("_", " ") for name in (gait.stance_sole, gait.swing_sole_frame)]


def _stance(gait: Gait) -> str | None:
    """Return how the stance foot turns, None where it stands flat until the impact."""
    if not gait.turning:
        return None
    angle = np.degrees(gait.foot_angle)
    return f"{gait.foot_contact} from {gait.turns_at:.3f} s, {angle:.1f}° at the impact"


def _robot(gait: Gait) -> str:
    """Return what is odd, changed and guessed about the robot, folded up; empty if nothing is."""
    known = findings_of(gait.fact("findings"))
    told = [f for how in ("warning", "changed", "guessed") for f in known if f.how == how]
    if not told:
        return ""
    words = {"warning": "warnings", "changed": "changes", "guessed": "guesses"}
    counts = Counter(f.how for f in told)
    head = ", ".join(f"{words[how]}: {count}" for how, count in counts.items())
    rows = "".join(f"<li>{f.how}: {html_text(f.subject)}: {html_text(f.text)}</li>" for f in told)
    return f"<details><summary>about the robot: {head}</summary><ul>{rows}</ul></details>"


def _title(gait: Gait) -> str:
    name = gait.text("robot")
    return f"{name or 'Walking'}{' walks' if name else ''} at {gait.speed:.3g} m/s"
