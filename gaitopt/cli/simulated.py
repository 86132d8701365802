"""Simulated walks as a page and as a film."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from rich.table import Table

from gaitopt.atomic import taken_by
from gaitopt.cli.results import require_writable
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.simulate.battery import PUSHED, Battery, directions
from gaitopt.simulate.disturbance import Push
from gaitopt.simulate.mujoco_model import SimulatedRobot, simulated_robot
from gaitopt.simulate.reference import both_feet
from gaitopt.simulate.walk import SimulatedWalk
from gaitopt.view.animation import Replay, ShownPush
from gaitopt.view.page import write_simulated_page
from gaitopt.view.page_parts import Section

FRAMES = 30.0  # Hz, of the postures that are kept for them


def require_views(page: Path | None, video: Path | None) -> None:
    """Check, before any work, that a page and a video can be written, where they are wanted.

    Raises:
        InputError: the directory cannot be written, the kind is unknown, or ffmpeg is not there.
    """
    for path, option in ((page, "--page"), (video, "--video")):
        if path is not None:
            if reason := taken_by(path):
                raise InputError(f"{option} {path}: {reason}; give the name of a file")
            require_writable(path.absolute().parent, option)
    if video is not None:
        from gaitopt.view.video import require_ffmpeg

        require_ffmpeg(video)


def replays(gait: Gait, walk: SimulatedWalk, tried: Battery | None) -> list[Replay]:
    """Return what can be shown: the undisturbed walk, the disturbed ones, the hardest pushes."""
    robot = simulated_robot(gait.trajectory.body)
    found = [_replay(robot, "undisturbed", walk)]
    if tried is not None:
        found += [_replay(robot, one.check.name, one.walk) for one in tried.checks]
        along = directions(gait)
        for limit in tried.pushes:
            if limit.walk is not None:
                x, y, z = (limit.impulse * along[limit.direction]).tolist()
                push, name = Push((x, y, z), step=PUSHED), f"{limit.impulse:.0f} N·s"
                name = f"pushed {limit.direction}, {name}"
                found.append(_replay(robot, name, limit.walk, _shown(gait, limit.walk, push)))
    return found


def _shown(gait: Gait, walk: SimulatedWalk, push: Push) -> ShownPush:
    landed = float(walk.times[: push.step].sum()) - both_feet(gait.trajectory)
    begins = landed + push.phase * gait.duration
    return ShownPush(begins, push.impulse)


def _replay(robot: SimulatedRobot, name: str, walk: SimulatedWalk, *pushes: ShownPush) -> Replay:
    ending = walk.ending.value if walk.walked else f"{walk.ending.value} in step {walk.steps + 1}"
    configuration = robot.configuration(walk.motion[:, 1:])
    return Replay(name, ending, walk.motion[:, 0], configuration, pushes)


def write_views(
    gait: Gait,
    shown: list[Replay],
    tables: Iterable[Table],
    page: Path | None,
    video: Path | None,
) -> Iterator[Path]:
    """Write the page and the video that are wanted; each path is told as it is written.

    Raises:
        InputError: there are too many steps, or a file cannot be written.
        RobotError: the robot cannot be drawn.
    """
    if page is not None:
        yield write_simulated_page(gait, shown, map(_section, tables), page)
    if video is not None:
        from gaitopt.view.video import write_video

        yield write_video(gait, [one for one in shown if one.pushes or one is shown[0]], video)


def _section(table: Table) -> Section:
    """Return a table of the terminal as one of the page."""
    heads = [f"{'>' if c.justify == 'right' else ''}{c.header}" for c in table.columns]
    rows = zip(*([str(cell) for cell in column.cells] for column in table.columns), strict=True)
    return Section(str(table.title), tuple(heads), tuple(rows))
