"""One self-contained page with the walking robot; it opens in any browser, without a network.

Beside the robot are the curves of what every joint and foot does over a period of the walk. Unlike
the figures, which compare the stance leg with the swing leg over one step, they follow the joints
of the robot, so that a cursor can move with the walk. The page of a simulated walk shows it beside
the designed one, with its pushes, and what came of it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from gaitopt.atomic import write_atomically
from gaitopt.bounds import STEPS, at_most, fixed
from gaitopt.contact import BOTH_FEET
from gaitopt.design.shadow_prices import SETTING
from gaitopt.design.summary import (
    by_motion,
    linkage_motors,
    named_groups,
    payload_words,
    proof_rows,
    summarise,
)
from gaitopt.errors import GaitoptError
from gaitopt.escape import filled_template, html_text
from gaitopt.gait.result import Gait, Recorded, ground_of
from gaitopt.gait.trajectory import TrajectorySamples
from gaitopt.gait.transition import Transition
from gaitopt.importers.report import findings_of
from gaitopt.mechanics.spatial import upright
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments
from gaitopt.units import motion_words
from gaitopt.view.animation import DEFAULT_STEPS, PUSH, Replay, Scene, build_beside, build_scene
from gaitopt.view.page_parts import Page, Section, table_text
from gaitopt.view.robot_shapes import RobotShapes
from gaitopt.view.stick_figures import contact_colour, contact_words, contacts, flat_contact
from gaitopt.view.viewer import Node, RecordingWindow, data_text, packed_viewer, page_file

POINTS = 301  # of a period
Record = dict[str, Any]


def curves(gait: Recorded) -> Record:
    """Return the curves of a gait over its period, or of a transition, as data for charts.

    Returns:
        `period` and `step` [s], `time` (N,) [s], and `tabs`: for each a name and its panels. A
        panel has a title, a unit, lines (name, side, values; points x and y where it is no curve
        over time), limits, and the joints that it is about. Values are arrays (N,), NaN where
        there is none.
    """
    trajectory = gait.trajectory
    times, before = _instants(gait)
    samples = trajectory.at(times, before=before)
    rows = [trajectory.joint_names.index(name) for name in gait.joint_names]
    torque, rate, angle = (values[:, rows] for values in (samples.torque, samples.dq, samples.q))
    torque_limit = gait.joint_limit("torque")
    pairs = named_groups(gait)
    quantities: tuple[tuple[str, str, Array, Array | None, Array | None], ...] = (
        ("torque", "N·m", torque, torque_limit, None),
        ("speed", "rad/s", rate, gait.joint_limit("speed"), None),
        ("power", "W", torque * rate, None, None),
        ("angle", "rad", angle, None, None),
        ("torque over speed", "N·m over rad/s", torque, torque_limit, rate),
    )
    linked = _linkages(gait, torque, rate, angle)
    tabs = [
        {
            "name": name,
            "panels": [
                *(_joints(gait, *pair, unit, y, limits, x) for pair in pairs),
                *(
                    panels[name] | {"unit": motion_words(unit, slides=slides)}
                    for slides, panels in linked
                ),
            ],
        }
        for name, unit, y, limits, x in quantities
    ]
    tabs.append({"name": "ground", "panels": list(_ground(gait, samples))})
    return {
        "period": trajectory.period,
        "step": trajectory.period if isinstance(gait, Transition) else trajectory.step_duration,
        "time": times,
        "tabs": tabs,
    }


def _instants(gait: Recorded) -> tuple[Array, Array]:
    """Return times [s] of a period, two where it jumps, and whether each is the end of a phase."""
    trajectory = gait.trajectory
    jumps = trajectory.changes
    inner = np.linspace(0.0, trajectory.period, POINTS)
    inner = inner[np.abs(inner[:, None] - jumps).min(axis=1) > 1e-9]
    times = np.concatenate([inner, jumps, jumps[:-1]])
    before = np.concatenate(
        [np.zeros(len(inner)), np.ones(len(jumps)), np.zeros(len(jumps) - 1)]
    ).astype(bool)
    order = np.lexsort([~before, times])
    return times[order], before[order]


def _joints(
    gait: Recorded,
    title: str,
    group: tuple[int, ...],
    unit: str,
    y: Array,
    limits: Array | None,
    x: Array | None,
) -> Record:
    """Return the panel of a pair of joints: y (N, J) over time, or over x (N, J)."""
    lines = []
    sides = ("stance", "swing") if len(group) > 1 else ("",)
    for joint, side in zip(group, sides, strict=True):
        line: Record = {"name": gait.joint_names[joint], "side": side, "y": y[:, joint]}
        lines.append(line if x is None else {**line, "x": x[:, joint]})
    limit = None if limits is None else float(np.min(limits[list(group)]))
    return _panel(title, unit, lines, [gait.joint_names[j] for j in group], _bounds(limit))


def _linkages(
    gait: Recorded, torque: Array, rate: Array, q: Array
) -> list[tuple[bool, dict[str, Record]]]:
    """Return for each motor of a linkage whether it slides, and its panels, but for their unit.

    Panels are by the names of tabs.
    """
    found = []
    for title, pair, k in linkage_motors(gait):
        linkage = pair[0].linkage
        limits = {"torque": linkage.torque[k], "speed": linkage.speed[k]}
        limits["torque over speed"] = limits["torque"]
        each = [group.values(torque, rate, q) for group in pair]
        panels: dict[str, Record] = {}
        for name in ("torque", "speed", "power", "angle", "torque over speed"):
            lines = []
            for of, group, side in zip(each, pair, ("stance", "swing"), strict=True):
                line: Record = {"name": f"{linkage.motors[k]}, {group.names[-1]}", "side": side}
                line["y"] = of[name.split()[0]][:, k]
                lines.append(line if " " not in name else {**line, "x": of["speed"][:, k]})
            joints = [joint for group in pair for joint in group.names]
            bounds = _bounds(limits.get(name))
            panels[name] = {"title": title, "joints": joints, "limits": bounds, "lines": lines}
        found.append((linkage.slides(k), panels))
    return found


def _ground(gait: Recorded, samples: TrajectorySamples) -> Iterable[Record]:
    """Yield panels of force, friction and centre of pressure of both feet."""
    force = samples.force
    for axis, title in ((2, "vertical force"), (0, "forward force"), (1, "force to the left")):
        feet = _each_foot(gait)
        lines = [{"name": foot, "side": s, "y": force[:, k, axis]} for k, foot, s in feet]
        yield _panel(title, "N", lines)
    normal = samples.wrench[..., 2]
    tangential = np.hypot(samples.wrench[..., 0], samples.wrench[..., 1])
    used = np.where(samples.contact & (normal > 0.0), tangential / np.where(normal, normal, 1), 0.0)
    lines = [{"name": foot, "side": side, "y": used[:, k]} for k, foot, side in _each_foot(gait)]
    limits = _bounds(gait.number("task", "margins", "friction"))
    yield _panel("friction used", "", lines, limits=limits)
    for k, foot, side in _each_foot(gait):
        toe, heel, left, right = gait.trajectory.body.sole_rectangle[k]
        x, y = samples.pressure[:, k].T
        lines = [{"name": foot, "side": side, "x": x, "y": y}]
        box = [float(edge) for edge in (heel, right, toe, left)]
        yield _panel(f"centre of pressure, {foot}", "m", lines, box=box)


def _panel(
    title: str,
    unit: str,
    lines: Sequence[Record],
    joints: Sequence[str] = (),
    limits: Sequence[float] = (),
    **box: object,
) -> Record:
    own = {"joints": joints, "limits": limits}
    return {"title": title, "unit": unit, **own, **box, "lines": lines}


def _each_foot(gait: Recorded) -> Iterable[tuple[int, str, str]]:
    names = (gait.stance_sole, gait.swing_sole_frame)
    for k, side in enumerate(("stance", "swing")):
        yield k, names[k].replace("_sole", " foot").replace("_", " "), side


def _bounds(limit: float | None) -> list[float]:
    """Return the values of a symmetric limit, none where there is none."""
    return [-limit, limit] if limit is not None and np.isfinite(limit) and limit > 0.0 else []


_DECIMALS = 4  # of limits, in SI units


@checked_arguments
def write_page(
    gait: Gait | Transition,
    path: str | Path,
    steps: int = DEFAULT_STEPS,
    package_dirs: tuple[str | Path, ...] = (),
) -> Path:
    """Write a page with the robot walking, complete in one file.

    The robot walks beside the curves of its joints and of the ground, the motors, and the proof; a
    cursor in the curves moves with the walk, and moves the walk when it is dragged.
    `page.html#t=0.35&paused&tab=power&theme=dark` opens it at an instant.

    Args:
        gait: one step, or a transition, of which all is shown.
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


@checked_arguments
def page_text(
    gait: Gait | Transition, steps: int = DEFAULT_STEPS, package_dirs: tuple[str | Path, ...] = ()
) -> Page:
    """Return the text of the page of `write_page`; a notebook shows it.

    Raises:
        InputError: steps < 1.
        RobotError: the robot cannot be drawn.
    """
    recorder = RecordingWindow()
    scene = build_scene(Node(recorder), gait, steps, tuple(map(str, package_dirs)))
    return gait_page(gait, scene, recorder.text(), steps)


def gait_html(gait: Gait | Transition) -> str | None:
    """Return the page of a walk in a frame; None where the robot cannot be drawn."""
    try:
        return page_text(gait)._repr_html_()
    except GaitoptError:
        return None


def gait_page(
    gait: Gait | Transition,
    scene: Scene,
    commands: str,
    steps: int,
    extra: Mapping[str, str] | None = None,
) -> Page:
    """Return the text of the page of a gait in a scene.

    Args:
        commands: that draw the scene, packed.
        steps: that it shows.
        extra: more parts of the page, by their marks.
    """
    data = {**film(gait, scene, steps), "curves": curves(gait), "motion": scene.motion}
    return _page_of({**headline(gait), **details(gait, scene)}, data, commands, extra)


def _page_of(
    words: Mapping[str, str],
    data: Mapping[str, object],
    commands: str,
    extra: Mapping[str, str] | None = None,
) -> Page:
    """Return the text of a page of words by their places, data, packed commands and more parts."""
    parts = {
        **{f"@{name.upper()}@": text for name, text in words.items()},
        "@DATA@": data_text(data).replace("<", "\\u003c"),  # ends no script
        "@LOAD@": page_file("load.js"),
        "@CHART@": page_file("chart.js"),
        "@FIT@": page_file("fit.js"),
        "@COMMANDS@": commands,
        "@MESHCAT@": packed_viewer(),
        "@SLIDERS@": "",
        "@WIRE@": "",
        **(extra or {}),
    }
    return Page(filled_template(page_file("page.html"), parts))


def doubtful(verdict: str) -> str:
    """Return the verdict on a walk that is not certified, as HTML: in red."""
    return f'<span class="doubt">{html_text(verdict)}</span>'


def headline(gait: Gait | Transition, whose: str = "") -> dict[str, str]:
    """Return what a page says first of a gait: HTML by name of its place.

    Args:
        gait: the gait.
        whose: what its speed, step and cost are called in front, where the page has others too.
    """
    told = {name: f"{whose} {name}".strip() for name in ("speed", "step", "cost")}
    rows = (f"<div><dt>{told.get(k, k)}</dt><dd>{html_text(v)}</dd></div>" for k, v in facts(gait))
    verdict = str(gait.fact("certificate", "verdict") or "no certificate")
    name, way = gait.text("robot"), gait.words if isinstance(gait, Transition) else f"at {gait.way}"
    return {
        "title": html_text(f"{name or 'Walking'}{' walks' if name else ''} {way}"),
        "verdict": html_text(verdict) if gait.certified else doubtful(verdict),
        "facts": "".join(rows),
    }


def details(gait: Gait | Transition, scene: Scene) -> dict[str, str]:
    """Return the rest that a page says, likewise: tables, notes, and what the picture means."""
    right, left = (foot.replace(" sole", " leg") for foot in _feet(gait))
    note = f"<p>{html_text(scene.shapes.note)}</p>" if scene.shapes.note else ""
    return {
        "tables": "".join(map(table_text, _sections(gait))),
        "notes": note + _robot(gait),
        "standing": ";\n     ".join(_mark(contact) for contact in contacts(gait)),
        "span": "all of it" if isinstance(gait, Transition) else "a whole period",
        "right": html_text(right),
        "left": html_text(left),
        "scale": f"{0.1 / scene.force_scale:.4g}",
    }


def film(gait: Gait | Transition, scene: Scene, steps: int) -> dict[str, object]:
    """Return what a page must know of the steps that it shows."""
    whole = isinstance(gait, Transition)
    return {
        "duration": gait.trajectory.period if whole else gait.duration * steps,
        "step": gait.trajectory.period if whole else gait.duration,
        "phases": list(_phases(gait)),
        "feet": _feet(gait),
        "robots": scene.robots,
    }


def _sections(gait: Gait | Transition) -> Iterator[Section]:
    """Yield the tables of the page: steps of a transition, motors, proof, what limits cost."""
    known: Any = summarise(gait)
    if isinstance(gait, Transition):
        yield _steps(known["transition"])
    for slides, own in by_motion((*known["joints"], *known["linkages"])):
        words = partial(motion_words, slides=slides)
        heads = (">peak\nN·m", ">RMS\nN·m", ">of limit", ">peak\nrad/s", ">of limit", ">peak\nW")
        yield Section(
            "Linear motors" if slides else "Motors",
            ("joint", "leg", *map(words, heads)),
            tuple(
                (
                    one["joint"], one["leg"], fixed(one[words("peak_torque_Nm")], 1),
                    fixed(one[words("rms_torque_Nm")], 1), _share(one[words("torque_used")]),
                    fixed(one[words("peak_speed_rad_per_s")], 2), _share(one["speed_used"]),
                    fixed(one["peak_power_W"], 0),
                )
                for one in own
            ),
        )  # fmt: skip
    proof, verdict = known["certificate"], known["certificate"]["verdict"] or "no certificate"
    rows = (*proof_rows(known["solver"], proof), ("verdict", str(verdict), ""))
    yield Section("Proof", ("check", "result", ">allowed"), rows)
    prices = tuple(_prices(known.get("shadow_prices")))
    if prices:
        columns = ("number", ">value", ">one unit more changes the cost by")
        yield Section("What limits cost", columns, prices)


def _steps(known: Any) -> Section:
    """Return the table of the steps of a transition."""
    rows = []
    for number, one in enumerate(known["steps"]):
        contact, impact = one["contact"], one["impact"]
        edges = contact["cop_to_edge_mm"] or {}
        rows.append(
            (
                str(number + 1), fixed(one["duration_s"], 3), fixed(one["step_length_m"], 3),
                fixed(one["peak_torque_Nm"], 1), _fixed(contact["friction_used"], 2),
                _fixed(min(edges.values(), default=None), 1),
                fixed(impact["vertical_impulse_Ns"], 2),
            )
        )  # fmt: skip
    columns = (
        "step", ">duration\ns", ">length\nm", ">peak torque\nN·m", ">friction\nused",
        ">pressure to\nthe edge, mm", ">landing\nN·s",
    )  # fmt: skip
    return Section("Steps", columns, tuple(rows))


def _prices(records: Any) -> Iterator[tuple[str, str, str]]:
    """Yield what the numbers that the walk presses on are worth; nothing of a damaged record."""
    with suppress(KeyError, TypeError, ValueError):
        for one in records or ():
            per = f"{one['cost_unit']} per {one['unit'] or 'unit'}"
            words, name = one["words"], one["name"]
            yield (
                f"{words} ({name})" if one["kind"] == SETTING else f"{name}, {words} limit",
                # limits of the height of a foot that lands go to zero: no such fine digits
                f"{round(float(one['value']), _DECIMALS) + 0.0:.4g} {one['unit']}",
                f"{float(one['cost_per_unit']):+.3g} {per}",
            )


def _fixed(value: float | None, decimals: int) -> str:
    return "-" if value is None else fixed(value, decimals)


def _share(used: float | None) -> str:
    return "no limit" if used is None else f"{100.0 * used:.0f} %"


def facts(gait: Gait | Transition) -> list[tuple[str, str]]:
    """Return what is known about a gait or a transition, for people: name, and value with unit."""
    cost, mass = gait.cost, gait.number("mass")
    way: list[tuple[str, object]]
    if isinstance(gait, Transition):
        way = [
            ("from", gait.ends[0]),
            ("to", gait.ends[1]),
            ("steps", f"{len(gait.steps)} in {fixed(gait.duration, 3)} s"),
        ]
    else:
        way = [
            ("speed", gait.way),
            ("step", f"{fixed(gait.step_length, 3)} m in {fixed(gait.duration, 3)} s"),
            ("ground", ground_of(gait).words or None),
            ("landing", _landing(gait)),
            ("stance foot", _stance(gait)),
        ]
    known = [
        *way,
        ("load", payload_words(gait) or None),
        ("mass", None if mass is None else f"{fixed(mass, 2)} kg"),
        ("cost", None if cost is None else f"{cost:.6g} {gait.cost_unit}"),
        ("solver", gait.fact("status")),
    ]
    return [(name, str(value)) for name, value in known if value is not None]


def _mark(contact: str) -> str:
    """Return the line that explains the colour of a contact."""
    colour = f'<span class="mark" style="background:{contact_colour(contact)}"></span>'
    return f"{colour} foot {html_text(contact_words(contact))}"


def _phases(gait: Gait | Transition) -> Iterator[dict[str, object]]:
    """Yield the phases that the bar under the time repeats, over a step, or over a transition."""
    # The feet change roles where the bar is repeated.
    if not isinstance(gait, Transition):
        for phase in gait.phases:
            begin, end = phase.begin / gait.duration, phase.end / gait.duration
            yield _phase(phase.contact, (begin, end), 0, contact_words(phase.contact))
        return
    trajectory = gait.trajectory
    ends = trajectory.breaks / trajectory.period
    names = gait.phase_names
    middle = trajectory.at(0.5 * (ends[1:] + ends[:-1]) * trajectory.period)
    for k, name in enumerate(names):
        contact, foot = flat_contact(middle.contact[k]), int(middle.standing[k])
        yield _phase(contact, (ends[k], ends[k + 1]), foot, name)


def _phase(contact: str, shares: tuple[float, float], foot: int, words: str) -> dict[str, object]:
    return {
        "words": html_text(words), "colour": contact_colour(contact), "begin": shares[0],
        "end": shares[1], "foot": foot, "both": contact == BOTH_FEET,
    }  # fmt: skip


def _feet(gait: Recorded) -> list[str]:
    """Return what the feet are called, the one that stands first before the other."""
    return [name.replace("_", " ") for name in (gait.stance_sole, gait.swing_sole_frame)]


def _stance(gait: Gait) -> str | None:
    """Return how the stance foot turns, None where it stands flat until the impact."""
    if not gait.turning:
        return None
    angle = np.degrees(gait.foot_angle)
    when = "as it leaves" if gait.closing else "at the impact"
    return f"{gait.foot_contact} from {fixed(gait.turns_at, 3)} s, {fixed(angle, 1)}° {when}"


def _landing(gait: Gait) -> str | None:
    """Return how the foot lands, None where it does flat."""
    if not gait.lands_on_line:
        return None
    angle = np.degrees(gait.landing_angle)
    flat = f"flat at {fixed(gait.flat_from, 3)} s"
    return f"{gait.landing_contact}, {fixed(angle, 1)}° at the impact, {flat}"


def _robot(gait: Recorded) -> str:
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


_PUSHED = f'<span class="mark" style="background:{PUSH}"></span> push, at the pelvis'


def simulated_page(gait: Gait, replays: Sequence[Replay], tables: Iterable[Section]) -> Page:
    """Return a page on which a robot walks as simulated, and a pale one beside it as designed.

    Args:
        gait: as designed.
        replays: what was simulated; buttons choose between them.
        tables: what was measured.

    Raises:
        InputError: there are too many steps.
        RobotError: the robot cannot be drawn.
    """
    steps = int(np.ceil(max(one.time[-1] for one in replays) / gait.duration))
    at_most(steps, STEPS, "steps on a page", "simulate fewer --steps")
    recorder = RecordingWindow()
    drawn: RobotShapes | None = None
    films: list[Record] = []
    first: Scene | None = None
    for replay in replays:
        window = recorder if drawn is None else RecordingWindow()
        viewer = Node(window)
        scene = build_beside(viewer, gait, replay, steps, drawn)
        drawn, first = scene.shapes, first or scene
        words = {"verdict": html_text(f"{replay.name}: {replay.ending}")}
        films.append({
            "name": replay.name, "motion": scene.motion, "words": words,
            "duration": replay.time[-1], "curves": replay_curves(gait, replay),
        })  # fmt: skip
    assert first is not None
    said = headline(gait, "designed")
    pushed = any(replay.pushes for replay in replays)
    words = {
        **said, **details(gait, first), **films[0]["words"],
        "title": f"{said['title']}, simulated", "span": "all of it",
        "right": "as simulated", "left": "as designed, pale in the picture",
        "tables": "".join(map(table_text, tables)),
    }  # fmt: skip
    words["standing"] += "; these as designed" + (f"; {_PUSHED}" if pushed else "")
    data = {
        **film(gait, first, 1), "duration": replays[0].time[-1],
        "curves": films[0]["curves"], "films": films,
    }  # fmt: skip
    extra = {"@SLIDERS@": _buttons(films), "@WIRE@": page_file("replay.js")}
    return _page_of(words, data, recorder.text(), extra)


def _buttons(films: Sequence[Record]) -> str:
    """Return a button for each walk, none where there is one alone."""
    if len(films) < 2:
        return ""
    names = "".join(f"<button>{html_text(one['name'])}</button>" for one in films)
    return f'<div id="replays" role="group" aria-label="what is shown">{names}</div>'


def replay_curves(gait: Gait, replay: Replay) -> Record:
    """Return curves of a walk beside those of the design, as `curves` does."""
    body, times = gait.trajectory.body, replay.time
    designed = gait.trajectory.at(times).configuration
    both = (("simulated", "stance", replay.configuration), ("designed", "swing", designed))

    def panel(title: str, unit: str, values: Sequence[Array], joints: Sequence[str]) -> Record:
        lines = [
            {"name": name, "side": side, "y": y}
            for (name, side, _), y in zip(both, values, strict=True)
        ]
        return _panel(title, unit, lines, joints)

    bases = [configuration[:, :3] for _, _, configuration in both]
    tilts = [_tilt(gait, configuration) for _, _, configuration in both]
    climb = np.outer(times / times[-1], designed[-1, :3] - designed[0, :3])[:, 2]
    ahead = bases[0][:, 0] - bases[1][:, 0]
    trunk = [
        panel("base ahead of the design", "m", [ahead, np.zeros_like(ahead)], []),
        panel("base to the left", "m", [base[:, 1] for base in bases], []),
        panel("rise of the base", "m",
              [base[:, 2] - designed[0, 2] - climb for base in bases], []),
        panel("tilt of the base", "rad", tilts, []),
    ]  # fmt: skip
    joints = [
        panel(name, "rad", [c[:, 7 + row] for _, _, c in both], [name])
        for row, name in enumerate(body.joint_names)
        if row in body.moving
    ]
    return {
        "period": times[-1], "step": gait.duration, "time": times,
        "tabs": [{"name": "base", "panels": trunk}, {"name": "angle", "panels": joints}],
    }  # fmt: skip


def _tilt(gait: Gait, configurations: Array) -> Array:
    """Return by how much the base leans from where it is upright [rad], shape (N,)."""
    body = gait.trajectory.body
    up = upright(body.gravity).T @ np.array([0.0, 0.0, 1.0])
    own = body.heading[:, 2]
    turned = np.array([pin.Quaternion(q).matrix() @ own for q in configurations[:, 3:7]])
    return np.asarray(np.arccos(np.clip(turned @ up, -1.0, 1.0)))
