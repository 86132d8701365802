"""A page with a robot standing at its reference posture, and what is known about it."""

from __future__ import annotations

from pathlib import Path

from gaitopt.atomic import write_atomically
from gaitopt.view.inspection import Inspection
from gaitopt.view.inspection_scene import draw_inspection
from gaitopt.view.inspection_tables import Section, sections
from gaitopt.view.meshcat_quiet import meshcat
from gaitopt.view.page_fit import FIT
from gaitopt.view.recorder import Recorder, viewer_script
from gaitopt.view.visible import filled, on_page

_SHORT = 24  # characters; a longer text may be broken

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>@TITLE@</title>
<style>
  html, body { margin: 0; height: 100%; color: #1d2730; font: 14px/1.45 system-ui, sans-serif; }
  body { display: flex; }
  #pane { flex: 0 0 34vw; height: 100vh; overflow: hidden; position: relative; }
  #facts { flex: 1; min-width: 0; height: 100vh; overflow: auto; padding: 0 24px;
           box-sizing: border-box; }
  .table { overflow-x: auto; }
  h1 { font-size: 20px; margin: 18px 0 6px; } h2 { font-size: 15px; margin: 20px 0 4px; }
  table { border-collapse: collapse; width: 100%; }
  th, td { text-align: left; vertical-align: top; padding: 3px 12px 3px 0; }
  th { color: #5a6b7a; font-weight: normal; border-bottom: 1px solid #c3ccd4; }
  td { border-bottom: 1px solid #edf0f2; overflow-wrap: anywhere; }
  td:first-child { white-space: nowrap; }
  .short { white-space: nowrap; }
  .number { text-align: right; white-space: nowrap; } th.number { white-space: pre-line; }
  .guessed, .warning { background: #fff3cd; } .changed { background: #e3f1fa; }
  .given { background: #e4f4ea; }
  .refusal { background: #fbe3e6; border-left: 4px solid #b00020; padding: 8px 12px; }
  .legend { color: #5a6b7a; font-size: 12px; }
  @media (max-width: 900px) {
    body { flex-direction: column; } #pane { flex: 0 0 50vh; height: 50vh; }
    #facts { height: auto; min-height: 0; padding: 0 12px; }
    th, td { padding-right: 8px; }
  }
</style>
</head>
<body>
<div id="pane"></div>
<div id="facts"><h1>@TITLE@</h1>@REFUSAL@@TABLES@
<p class="legend">Arrows: axes of the leg joints, orange right, blue left; green: the soles.
Mouse: turn, shift, zoom.</p></div>
<script>const commands = @COMMANDS@;</script>
<script>@MESHCAT@</script>
<script>
"use strict";
const viewer = new MeshCat.Viewer(document.getElementById("pane"));
for (const command of commands) {
  viewer.handle_command_bytearray(Uint8Array.from(atob(command), c => c.charCodeAt(0)));
}
viewer.gui.domElement.style.display = "none";
@FIT@
measure();
fit();
</script>
</body>
</html>
"""


def write_inspection(inspection: Inspection, path: str | Path) -> Path:
    """Write a page with the robot and everything known about it, complete in one file.

    Args:
        inspection: of the robot, which may be refused.
        path: the .html file.

    Returns:
        The path written.

    Raises:
        InputError: the path cannot be written.
    """
    return write_atomically(path, inspection_text(inspection).encode("utf-8"))


def inspection_text(inspection: Inspection) -> str:
    """Return the text of the page of `write_inspection`."""
    recorder = Recorder()
    draw_inspection(meshcat.Visualizer(window=recorder), inspection)
    refusal = on_page(inspection.refusal)
    parts = {
        "@TITLE@": on_page(inspection.title),
        "@REFUSAL@": f'<p class="refusal">{refusal}</p>' if refusal else "",
        "@TABLES@": "".join(map(_table, sections(inspection))),
        "@FIT@": FIT,
        "@COMMANDS@": recorder.text(),
        "@MESHCAT@": viewer_script(),
    }
    return filled(_PAGE, parts)


def _table(section: Section) -> str:
    classes = [' class="number"' if name.startswith(">") else "" for name in section.columns]
    heads = "".join(
        f"<th{kind}>{'<br>'.join(map(on_page, name.removeprefix('>').splitlines()))}</th>"
        for kind, name in zip(classes, section.columns, strict=True)
    )
    how = section.how or ("",) * len(section.rows)
    rows = "".join(
        f'<tr class="{sure}">{_cells(row, classes)}</tr>'
        for row, sure in zip(section.rows, how, strict=True)
    )
    head = f"<tr>{heads}</tr>" if any(section.columns) else ""
    table = f'<div class="table"><table>{head}{rows}</table></div>'
    return f"<h2>{on_page(section.title)}</h2>{table}"


def _cells(row: tuple[str, ...], classes: list[str]) -> str:
    short = ' class="short"'
    return "".join(
        f"<td{kind or short if len(cell) < _SHORT else kind}>{on_page(cell)}</td>"
        for kind, cell in zip(classes, row, strict=True)
    )
