"""What is known about a robot, said before every answer: what `gaitopt inspect` says, in short."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable

from rich.console import Console
from rich.text import Text

from gaitopt.cli.config import SCHEMA, Settings
from gaitopt.gait.result import Gait
from gaitopt.importers.report import Finding, findings_of
from gaitopt.view.visible import visible

_STYLES = {"warning": "bold yellow", "changed": "cyan"}  # these are told in full
_NAME = re.compile("'[^']*'")
_RECORDED = "the record 'findings' of the gait has them"


def tell_robot(console: Console, findings: Iterable[Finding], all_of_them: str) -> None:
    """Print what is worth a look and what was changed, and how much was guessed.

    Args:
        console: where to.
        findings: about the robot.
        all_of_them: where to see every finding.
    """
    known = list(findings)
    for how, style in _STYLES.items():
        for subject, text in _gathered(f for f in known if f.how == how):
            said = Text.assemble((f"{how}:", style), f" {visible(subject)}: {visible(text)}")
            console.print(said, soft_wrap=True)
    topics = dict.fromkeys(f.topic for f in known if f.how == "guessed")
    if topics:
        count = sum(f.how == "guessed" for f in known)
        facts = "1 fact was" if count == 1 else f"{count} facts were"
        line = f"guessed: {facts}, about {', '.join(topics)}; {all_of_them}"
        console.print(line, soft_wrap=True)


def _gathered(findings: Iterable[Finding]) -> list[tuple[str, str]]:
    """Return subject and text of findings; what is the same but for a name is said once."""
    alike: dict[tuple[str, str], list[Finding]] = {}
    for one in findings:
        alike.setdefault((one.topic, _NAME.sub("''", one.text)), []).append(one)
    told = []
    for first, *others in alike.values():
        same = f"; the same at {', '.join(f.subject for f in others)}" if others else ""
        told.append((first.subject, first.text + same))
    return told


def tell_robot_of(console: Console, gait: Gait) -> None:
    """Print what was known about the robot of a gait when it was designed."""
    tell_robot(console, findings_of(gait.fact("findings")), _RECORDED)


def inspect_command(settings: Settings) -> str:
    """Return the sentence that names the command which shows everything about a robot."""
    words = ["gaitopt", "inspect"]
    for name in SCHEMA["robot"]:
        values = settings.get(name)
        for value in values if isinstance(values, list | tuple) else [values]:
            if value is not None:
                words += [f"--{name.replace('_', '-')}", str(value)]
    return f"all of it: {shlex.join(words)}"
