"""`gaitopt live`: a page whose sliders are answered with the walk of their settings."""

from __future__ import annotations

import math
import shlex
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import count
from os.path import exists
from pathlib import Path
from typing import Any

import numpy as np
import typer

from gaitopt.bounds import shown
from gaitopt.cli.command_options import LiveOptions
from gaitopt.cli.config import SCHEMA, Settings, option_words
from gaitopt.cli.request import Request, make_request, make_robot, make_task
from gaitopt.cli.results import require_writable, write_results
from gaitopt.design.certificate import worst_rows
from gaitopt.design.pipeline import Design
from gaitopt.design.replanner import NONE, Plan, Replanner
from gaitopt.design.starts import many_starts
from gaitopt.errors import EvaluationError, InputError
from gaitopt.escape import html_text
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.gait.terrain import Level, Slope
from gaitopt.model.overrides import TORSO
from gaitopt.model.robot import Robot
from gaitopt.tolerances import SAME
from gaitopt.view.animation import Scene, build_scene
from gaitopt.view.live_server import Message, Slider, serve
from gaitopt.view.page import curves, details, doubtful, film, gait_page, headline
from gaitopt.view.scene_server import LOCAL, is_local
from gaitopt.view.viewer import Node, RecordingWindow, page_file

STEPS = 2  # that the page shows; every answer carries them
PATIENCE = 0.3  # s that a walk may take before newer settings end it
SEARCH = 3.0  # s for a walk from a first guess
HALVINGS = 6  # of the way back to settings that walk
LOAD = "load"
FOLLOWS = "optimal at the samples; its certificate follows"

_RANGES = {  # share of the first walk's value, then of the slider's step
    "speed": (0.3, 1.8, 0.01),
    "duration": (0.6, 1.6, 0.005),
}
_LIMITS = {  # from, to, step
    "slope": (-0.17, 0.17, 0.005),
    "friction": (0.2, 1.2, 0.01),
    "clearance": (0.0, 0.1, 0.001),
    "cop_margin": (0.0, 0.03, 0.0005),
    "knee_flexion": (0.0, 0.6, 0.01),
}


class LiveWalk:
    """A robot whose walk follows its settings; the session of a page.

    Attributes:
        sliders: that the page shows.
    """

    def __init__(self, settings: Settings, config: Path | None, output: Path) -> None:
        """Design the first walk.

        Raises:
            GaitoptError: the settings cannot be used, or there is no such walk.
        """
        self._request = make_request(settings, config)
        self._output = output
        request = self._request
        found = many_starts(
            request.robot, request.task, request.options, count=request.starts, start=request.start
        )
        self._design: Design = found.design
        self._planner = Replanner(request.options)
        self._planner.replan(request.robot, request.task)
        self.sliders = tuple(_sliders(request))
        first = {one.name: one.value for one in self.sliders}
        self._walking = first  # the last settings with a walk
        self._designed = first  # those of the last certified walk
        self._robots: dict[float, Robot] = {0.0: request.robot}
        self._scene: Scene | None = None

    def page(self) -> str:
        """Return the page with the last certified walk."""
        recorder = RecordingWindow()
        gait = self._design.gait
        scene = build_scene(Node(recorder), gait, STEPS)
        self._scene = scene
        extra = {"@SLIDERS@": self._form(), "@WIRE@": page_file("live.js")}
        return gait_page(gait, scene, recorder.text(), STEPS, extra)

    def answers(self, settings: Mapping[str, float], stop: Callable[[], bool]) -> Iterator[Message]:
        """Yield the walk, or why there is none; then its certificate, or settings that walk."""
        before = self._walking
        plan = self._plan(settings, stop)
        if not plan.answered:
            # A plan is late for newer settings, which have no use of its answer, or by SEARCH.
            if plan.outcome == NONE or not stop():
                yield from self._refusal(plan, before, settings, stop)
            return
        self._walking = dict(settings)
        told = f"{1e3 * plan.seconds:.0f} ms, {self._command(settings)}"
        yield from self._walk(plan.gait(), told, verdict=html_text(FOLLOWS))
        if stop():
            return
        try:
            design = plan.complete(self._request.options, stop)
        except EvaluationError as error:
            verdict = doubtful(f"optimal at the samples, no certificate: {error}")
            yield {"kind": "proof", "words": {"verdict": verdict}}
            return
        if not stop():
            self._design, self._designed = design, dict(settings)
            yield from self._walk(design.gait, told)

    def save(self) -> Message:
        """Write the last certified walk into a directory of its own."""
        if not self._design.proven:
            return {"kind": "saved", "text": "the walk is not certified; nothing was kept"}
        folder = next(path for k in count(1) if not exists(path := self._output / f"walk-{k}"))
        request = replace(self._request, robot=self._design.problem.robot,
                          task=self._design.problem.task)  # fmt: skip
        list(write_results(self._design.gait, request, folder, page=False, figures=False))
        return {
            "kind": "saved",
            "text": f"kept in {folder}; again: {self._command(self._designed, folder)}",
        }

    def _plan(self, settings: Mapping[str, float], stop: Callable[[], bool]) -> Plan:
        """Return the plan of settings; newer ones end it only when it takes long."""
        robot, given = self._robot(settings[LOAD]), self._given(settings)
        task = make_task(given, robot)
        began = time.perf_counter()

        def ends() -> bool:
            return stop() and time.perf_counter() - began > PATIENCE

        return self._planner.replan(robot, task, deadline=SEARCH, stop=ends)

    def _robot(self, load: float) -> Robot:
        if load not in self._robots:
            first = self._robots[0.0]
            given = {**self._request.settings, "payload": self._payloads(load)}
            self._robots = {0.0: first, load: make_robot(given)}
        return self._robots[load]

    def _payloads(self, load: float) -> tuple[str, ...]:
        own = tuple(self._request.settings.get("payload", ()))
        return (*own, f"{load:g}kg@{TORSO}") if load > 0.0 else own

    def _given(self, settings: Mapping[str, float]) -> Settings:
        """Return the settings of the command line with those of the sliders."""
        # A slider at its beginning is left out where that is what the settings give without it:
        # some defaults follow others, as the duration of a step follows the speed.
        own = [one for one in self.sliders if one.name != LOAD]
        moved = {one.name: settings[one.name] for one in own if settings[one.name] != one.value}
        given = {**self._request.settings, **moved}
        task = make_task(given, self._request.robot)
        kept = {
            one.name: one.value
            for one in own
            if one.name not in moved and _value(task, one.name) not in (None, one.value)
        }
        return {**given, **kept}

    def _command(self, settings: Mapping[str, float], kept: Path | None = None) -> str:
        """Return the command that makes a walk of settings, the one of a folder if there is one."""
        words = ["gaitopt", "optimise"]
        given = {**self._given(settings), "payload": self._payloads(settings[LOAD])}
        if kept is not None:  # other first guesses may lead to another walk
            own = given.items()
            given = {k: v for k, v in own if k not in ("starts", "seed", "sigma")}
            given["start"] = kept / "gait.npz"
        known = {name for section in SCHEMA.values() for name in section}
        for name, value in given.items():
            if name in known and value not in ((), [], {}):
                words += option_words(name, value)
        return shlex.join(words)

    def _refusal(
        self,
        plan: Plan,
        before: Mapping[str, float],
        settings: Mapping[str, float],
        stop: Callable[[], bool],
    ) -> Iterator[Message]:
        """Yield what stops the walk, and how far the slider that was moved could go."""
        within = "" if plan.outcome == NONE else f" found within {SEARCH:g} s"
        why = f"no walk{within}: {_stopped_by(plan)}"
        yield {"kind": "none", "text": why}
        moved = [one for one in self.sliders if before[one.name] != settings[one.name]]
        if len(moved) != 1:
            return
        (one,) = moved
        good, bad = before[one.name], settings[one.name]
        for _ in range(HALVINGS):
            middle = one.step * round((good + bad) / 2.0 / one.step)  # where the slider can stand
            if not min(good, bad) < middle < max(good, bad):
                break
            if stop():
                return
            near = self._plan({**before, one.name: middle}, stop)
            good, bad = (middle, bad) if near.answered else (good, middle)
        if not stop():
            yield {"kind": "none", "text": f"{why}; {one.words} can be {good:.4g} {one.unit}"}

    def _walk(self, gait: Gait, told: str, **words: str) -> Iterator[Message]:
        """Yield the curves of a walk, which are wanted first, then its picture and tables."""
        words = {**headline(gait), **words}
        yield {"kind": "walk", "curves": curves(gait), "words": words, "text": told}
        recorder = RecordingWindow()
        drawn = None if self._scene is None else self._scene.shapes
        scene = build_scene(Node(recorder), gait, STEPS, drawn=drawn)
        yield {
            "kind": "motion", "data": film(gait, scene, STEPS), "words": details(gait, scene),
            "commands": recorder.text(), "motion": scene.motion,
        }  # fmt: skip

    def _form(self) -> str:
        rows = "".join(
            f'<label><span>{html_text(one.words)}</span><input type="range" name="{one.name}" '
            f'min="{one.low:g}" max="{one.high:g}" step="{one.step:g}" '
            f'value="{self._designed[one.name]:.12g}" data-value="{self._designed[one.name]!r}" '
            f'data-unit="{html_text(one.unit)}">'
            "<span></span></label>"
            for one in self.sliders
        )
        told = '<span id="told" role="status">move a slider: the walk follows</span>'
        return (
            f'<div id="sliders"><div>{rows}</div><p>{told}<button id="save">keep</button></p></div>'
        )


def run_live(settings: Settings, asked: LiveOptions) -> None:
    """Serve the page until it is closed, or Ctrl-C."""
    require_writable(asked.output)
    session = LiveWalk(settings, asked.config, asked.output)
    host = LOCAL if asked.host is None else asked.host

    def ready(url: str) -> None:
        if not is_local(host):
            typer.echo("note: other machines can reach this page too", err=True)
        typer.echo(f"live at {url} (Ctrl-C or closing the page ends it)")

    serve(session, host, asked.port, on_ready=ready, stay=asked.stay)


def _sliders(request: Request) -> Iterator[Slider]:
    task = request.task
    for name, (low, high, step) in _RANGES.items():
        value = float(getattr(task, name))
        if value != 0.0:  # a walk in place keeps its speed: of nothing there is no share
            low, high = sorted((low * value, high * value))
            yield _slider(name, value, low, high, step)
    fixed = () if isinstance(task.ground, Level | Slope) and task.turn_rate == 0.0 else ("slope",)
    for name, (low, high, step) in _LIMITS.items():
        known = None if name in fixed else _value(task, name)
        if known is not None:
            yield _slider(name, known, min(low, known), max(high, known), step)
    most = 0.25 * request.robot.mass
    yield Slider(LOAD, "load on the torso", "kg", 0.0, round(most, 1), 0.1, 0.0)
    torque = request.robot.limits.torque
    if task.margins.torque_limit is None and np.isfinite(torque).all():
        most = float(torque.max())
        yield _slider("torque_limit", most, 0.1 * most, most, 0.01 * most)


def _value(task: Task, name: str) -> float | None:
    """Return the value of a setting, None where it is off."""
    known: Any = task.margin(name) if name in SCHEMA["margins"] else getattr(task, name)
    return None if known is None else float(known)


def _slider(name: str, value: float, low: float, high: float, step: float) -> Slider:
    low, high = step * math.floor(low / step + SAME), step * math.ceil(high / step - SAME)
    unit = next(one[name].unit for one in SCHEMA.values() if name in one)
    words = name.replace("_", " ").replace("cop", "CoP")
    return Slider(
        name, words, (unit or "").split(" ")[0], min(low, value), max(high, value), step, value
    )


def _stopped_by(plan: Plan) -> str:
    """Say which limit stops a walk."""
    if plan.solution is None:
        return plan.reason
    try:
        return worst_rows(plan.problem, plan.solution.x)[0].sentence
    except (EvaluationError, InputError) as error:
        return str(error) or shown(plan.reason)
