"""A video of simulated walks beside the designed one: stick figures, made into a film by ffmpeg."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait, ground_of
from gaitopt.mechanics.spatial import upright
from gaitopt.nlp import Array
from gaitopt.view.animation import PUSH, PUSH_SEEN, Replay
from gaitopt.view.figure_style import (
    GREY,
    GROUND,
    STANCE,
    SWING,
    TRUNK,
    leg_names,
    new_figure,
    styled,
)
from gaitopt.view.stick_figures import StickFigures, stick_figures, trunk_top

KINDS = (".mp4", ".webm", ".gif")
RATE = 25  # pictures a second
_WIDTH, _HEIGHT, _DPI = 9.6, 5.4, 100  # inch
_TALL, _BELOW = 2.3, 0.25  # of the picture, in heights of the hips; below the ground
_ARROW = 0.6  # of a push, in heights of the hips
_SIDE, _FRONT = 0, 1  # the axis that is seen from left to right
_EDGES = {_SIDE: ([0, 1], [2, 3]), _FRONT: ([0, 2], [1, 3])}  # corners at either end of a sole


def require_ffmpeg(path: Path) -> str:
    """Return where ffmpeg is, for a video of the kind that a path asks for.

    Raises:
        InputError: it is not there, or the kind is unknown.
    """
    if path.suffix.lower() not in KINDS:
        raise InputError(
            f"a video '{path.name}' cannot be made; end its name in {', '.join(KINDS)}"
        )
    found = shutil.which("ffmpeg")
    if found is None:
        raise InputError(
            "a video is made by ffmpeg, which is not there; install it (apt install ffmpeg, "
            "brew install ffmpeg), or ask for a page, which needs no other program"
        )
    return found


def write_video(gait: Gait, replays: Sequence[Replay], path: Path) -> Path:
    """Write a video of simulated walks one after the other, from the right and from behind.

    Args:
        gait: as designed, grey.
        replays: what was simulated.

    Raises:
        InputError: there is no ffmpeg, it cannot make this kind, or the path cannot be written.
        RobotError: the robot cannot be read.
    """
    program = require_ffmpeg(path)
    size = f"{round(_WIDTH * _DPI)}x{round(_HEIGHT * _DPI)}"
    colours = [] if path.suffix.lower() == ".gif" else ["-pix_fmt", "yuv420p"]
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / f"video{path.suffix.lower()}"
        command = [
            program, "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgba", "-s", size,
            "-r", str(RATE), "-i", "-", *colours, str(target),
        ]  # fmt: skip
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            assert process.stdin is not None
            for picture in pictures(gait, replays):
                process.stdin.write(picture)
        except BrokenPipeError:
            pass  # what it says follows
        except BaseException:
            process.kill()
            process.communicate()
            raise
        said = process.communicate()[1].decode(errors="replace").strip().splitlines()
        if process.returncode != 0:
            why = said[-1] if said else f"it ended with {process.returncode}"
            raise InputError(f"ffmpeg cannot make '{path.name}': {why}; try another of its kinds")
        return write_atomically(path, target.read_bytes())


def pictures(gait: Gait, replays: Sequence[Replay]) -> Iterator[bytes]:
    """Yield the pictures of a video, RGBA.

    Raises:
        RobotError: the robot cannot be read.
    """
    top = trunk_top(gait)
    with styled():
        for replay in replays:
            film = _Film(gait, replay, top)
            for index in range(len(film.time)):
                yield film.picture(index)


class _Film:
    """The pictures of one walk."""

    def __init__(self, gait: Gait, replay: Replay, top: Array) -> None:
        body = gait.trajectory.body
        self._level = upright(body.gravity)
        self.time = np.arange(replay.time[0], replay.time[-1], 1.0 / RATE)
        rows = np.searchsorted(replay.time, self.time)
        designed = gait.trajectory.at(self.time).configuration
        self._walks = tuple(
            stick_figures(body, configurations, top).turned(self._level)
            for configurations in (designed, replay.configuration[rows])
        )
        self._name, self._pushes = f"{replay.name}: {replay.ending}", replay.pushes
        self._hips = float(self._walks[0].trunk[0, 0, 2] - self._walks[0].soles[0, 0, :, 2].mean())
        self._figure = new_figure(_WIDTH, _HEIGHT, layout=None)
        self._figure.set_dpi(_DPI)
        self._canvas = FigureCanvasAgg(self._figure)
        self._views = [
            _View(self._figure, (0.0, 0.0, 0.66, 0.9), _SIDE, self._hips),
            _View(self._figure, (0.67, 0.0, 0.33, 0.9), _FRONT, self._hips),
        ]
        self._views[0].draw_ground(self._ground(gait))
        self._title = self._figure.text(0.02, 0.94, "", fontsize=11)
        self._figure.text(0.98, 0.94, "from the right, from behind", ha="right", color=GREY)
        names = (*leg_names(gait), "trunk", "as designed")
        lines = [
            Line2D([], [], color=colour, linewidth=4.0, solid_capstyle="round", label=name)
            for name, colour in zip(names, (STANCE, SWING, TRUNK, GREY), strict=True)
        ]
        self._figure.legend(
            handles=lines, ncols=len(lines), loc="upper left", bbox_to_anchor=(0.01, 0.93),
            frameon=False, handlelength=1.0, borderaxespad=0.0,
        )  # fmt: skip

    def _ground(self, gait: Gait) -> Array:
        """Return points of the ground from the right, shape (m, 3)."""
        ground, steps = ground_of(gait), int(np.ceil(self.time[-1] / gait.duration))
        outline = ground.along(-4, steps + 6, gait.step_length)
        if not ground.shaped:
            outline = np.array([[-1e3, 0.0], [1e3, 0.0]])
        points = np.column_stack([outline[:, 0], np.zeros(len(outline)), outline[:, 1]])
        return np.asarray(points @ self._level.T)

    def picture(self, index: int) -> bytes:
        """Return a picture, RGBA."""
        time, (designed, walked) = float(self.time[index]), self._walks
        middle = designed.trunk[:, 0]
        share = time / self.time[-1]
        target = (1.0 - share) * middle[0] + share * middle[-1]
        push = next((p for p in self._pushes if p.begins <= time < p.begins + PUSH_SEEN), None)
        arrow = np.zeros(3)
        if push is not None and (size := float(np.linalg.norm(push.impulse))) > 0.0:
            arrow = self._level @ np.array(push.impulse) * (_ARROW * self._hips / size)
        for view in self._views:
            view.show(designed, walked, index, target, arrow)
        self._title.set_text(f"{self._name}   t = {time:.2f} s")
        self._canvas.draw()  # type: ignore[no-untyped-call]
        return bytes(self._canvas.buffer_rgba())  # type: ignore[no-untyped-call]


class _View:
    """The robots from one side."""

    def __init__(
        self, figure: Figure, place: tuple[float, float, float, float], axis: int, hips: float
    ) -> None:
        self._axis, self._hips = axis, hips
        axes: Axes = figure.add_axes(place)
        axes.set_axis_off()
        axes.set_aspect("equal", adjustable="box")
        self._axes = axes
        self._half = 0.5 * _TALL * hips * place[2] * _WIDTH / (place[3] * _HEIGHT)
        pale = [GREY, GREY, GREY]
        self._parts = [
            [axes.plot([], [], "o-", color=c, linewidth=w, markersize=w, alpha=a,
                       solid_capstyle="round")[0] for c in colours]
            for colours, w, a in ((pale, 2.5, 0.7), ([SWING, STANCE, TRUNK], 4.0, 1.0))
        ]  # fmt: skip
        self._soles = [
            [
                axes.plot([], [], color=c, linewidth=w, alpha=a, solid_joinstyle="round")[0]
                for c in colours[:2]
            ]
            for colours, w, a in ((pale, 2.0, 0.7), ([SWING, STANCE], 3.0, 1.0))
        ]
        self._push = axes.plot([], [], color=PUSH, linewidth=5.0, marker=None)[0]
        self._head = axes.plot([], [], "o", color=PUSH, markersize=9.0)[0]
        (self._ground,) = axes.plot([], [], color=GROUND, linewidth=2.0, zorder=0)
        self._marks = axes.plot([], [], "|", color=GROUND, markersize=12.0, zorder=0)[0]

    def draw_ground(self, points: Array) -> None:
        """Draw the ground that is seen from the right, shape (m, 3)."""
        self._ground.set_data(points[:, 0], points[:, 2])
        if len(points) == 2:  # of a plane one sees that it moves by its marks
            x = np.arange(points[0, 0], points[1, 0], 0.5)
            self._marks.set_data(x, np.interp(x, points[:, 0], points[:, 2]))

    def show(
        self, designed: StickFigures, walked: StickFigures, index: int, target: Array, push: Array
    ) -> None:
        """Show one instant: two stick figures, and a push as it is drawn [m], 0 for none."""
        axis = self._axis
        for sticks, parts, soles in zip((designed, walked), self._parts, self._soles, strict=True):
            for leg in (1, 0):
                points = sticks.legs[index, leg]
                parts[1 - leg].set_data(points[:, axis], points[:, 2])
                edges = [sticks.soles[index, leg, edge].mean(axis=0) for edge in _EDGES[axis]]
                foot = np.array([points[0], *edges, points[0]])
                soles[1 - leg].set_data(foot[:, axis], foot[:, 2])
            first, second = sticks.legs[index, :, -1]
            trunk = np.array([first, second, *sticks.trunk[index]])
            parts[2].set_data(trunk[:, axis], trunk[:, 2])
        pelvis = walked.trunk[index, 0]
        tail = pelvis - push
        self._push.set_data([tail[axis], pelvis[axis]], [tail[2], pelvis[2]])
        self._head.set_data([pelvis[axis]] if push.any() else [], [pelvis[2]] if push.any() else [])
        low = target[2] - (1.0 + _BELOW) * self._hips
        middle = target[axis]
        ends = (middle - self._half, middle + self._half)
        self._axes.set_xlim(*(ends if axis == _SIDE else ends[::-1]))
        self._axes.set_ylim(low, low + _TALL * self._hips)
        if axis == _FRONT:
            level = target[2] - self._hips
            self._ground.set_data([middle - self._half, middle + self._half], [level, level])
