"""One self-contained page with the walking robot; it opens in any browser, without a network."""

from __future__ import annotations

import base64
import html
import json
from pathlib import Path

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.view.meshcat_quiet import meshcat, umsgpack, zmqserver
from gaitopt.view.page_template import PAGE
from gaitopt.view.scene import FORCE_SCALE, build_scene
from gaitopt.view.walk import DEFAULT_STEPS


class _Recorder:
    """Stands in for MeshCat's window: keeps the drawing commands instead of sending them."""

    def __init__(self) -> None:
        self.commands: list[bytes] = []

    def send(self, command: object) -> None:
        """Keep one command, packed as the viewer reads it."""
        self.commands.append(umsgpack.packb(command.lower()))  # type: ignore[attr-defined]

    def get_image(self) -> None:
        """Do nothing: there is no picture before a browser opens the page."""


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
    recorder = _Recorder()
    build_scene(meshcat.Visualizer(window=recorder), gait, steps, package_dirs)
    commands = [base64.b64encode(c).decode("ascii") for c in recorder.commands]
    # plain replacement: the script and the template are full of braces and percent signs
    parts = {
        "@TITLE@": html.escape(_title(gait)),
        "@FACTS@": "".join(f"<dt>{k}</dt><dd>{html.escape(v)}</dd>" for k, v in facts(gait)),
        "@DURATION@": json.dumps(gait.duration * steps),
        "@STEP@": json.dumps(gait.duration),
        "@SCALE@": f"{0.1 / FORCE_SCALE:.0f}",
        "@COMMANDS@": json.dumps(commands),
        "@MESHCAT@": _viewer_script(),
    }
    text = PAGE
    for mark, part in parts.items():
        text = text.replace(mark, part)
    return text


def facts(gait: Gait) -> list[tuple[str, str]]:
    """Return what is known about a gait, for people: name, and value with unit."""
    cost, mass = gait.cost, gait.number("mass")
    known = [
        ("speed", f"{gait.speed:.3g} m/s"),
        ("step", f"{gait.step_length:.3f} m in {gait.duration:.3f} s"),
        ("mass", None if mass is None else f"{mass:.2f} kg"),
        ("cost", None if cost is None else f"{cost:.6g} N²·m·s"),
        ("solver", gait.fact("status")),
        ("certificate", gait.fact("certificate", "verdict")),
    ]
    return [(name, str(value)) for name, value in known if value is not None]


def _title(gait: Gait) -> str:
    return f"Walking at {gait.speed:.3g} m/s"


def _viewer_script() -> str:
    """Return MeshCat's viewer, which the MeshCat package carries."""
    source = Path(zmqserver.VIEWER_ROOT) / "main.min.js"
    try:
        return source.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(
            "the installed meshcat package lacks its viewer; run: pip install --force-reinstall "
            "'meshcat>=0.3.2'"
        ) from error
