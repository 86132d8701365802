"""The commands, each with its help and the options that are its own, beside the settings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gaitopt.dataclass import dataclass
from gaitopt.settings import entry

ASKED, METHOD, RESULTS = "What is asked", "Method", "Results"
DESIGN = "Design"
"""Headings of the help."""

_CONFIG = "TOML file with any of these options; the command line wins."
_PLUGIN = "Python file with its own constraints, cost or terrain; it is run."
_QUIET = "Print nothing but errors."
_OUTPUT: dict[str, Any] = {"short": "-o", "written": True}
_PAGE: dict[str, Any] = {"written": True, "suffixes": (".html", ".htm")}
_TOML: dict[str, Any] = {"written": True, "suffixes": (".toml",)}
_DIRECTORY: dict[str, Any] = {**_OUTPUT, "metavar": "DIR"}
_GAIT = "The file of a gait or a transition, .npz."
_HOST = "Address to listen on; by default 127.0.0.1: this machine alone."
_PORT = "Port to listen on; by default a free one from 7000 on."


@dataclass(frozen=True)
class OptimiseOptions:
    """Design the gait that walks at a given speed for the least effort."""

    fastest: bool = entry(False, "Search the fastest walk, from this speed up.", panel=ASKED)
    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    output: Path | None = entry(
        None, "Directory for gait, page and tables.", **_DIRECTORY, panel=RESULTS
    )
    page: bool = entry(True, "Write the page of the walking robot.", panel=RESULTS)
    figures: bool = entry(
        False,
        "Write the figures of the gait; its page has the curves, gaitopt plot draws them later.",
        panel=RESULTS,
        negatable=True,
    )
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


@dataclass(frozen=True)
class SweepOptions:
    """Design gaits over speeds and other quantities, each from its neighbour."""

    output: Path = entry(..., "Gait library; one that exists goes on.", **_DIRECTORY, panel="Sweep")
    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


@dataclass(frozen=True)
class CompareOptions:
    """Solve one walk by several solvers from the same start."""

    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    output: Path | None = entry(
        None, "Directory for comparison.json and convergence.png.", **_DIRECTORY, panel=RESULTS
    )
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


@dataclass(frozen=True)
class LibraryOptions:
    """List a gait library, draw it, or design a gait between its gaits; compare two."""

    directory: tuple[Path, ...] = entry(
        ..., "A gait library, made by gaitopt sweep, or two to compare.", argument=True,
        metavar="DIR",
    )  # fmt: skip
    where: tuple[str, ...] = entry(
        (), 'Only gaits of which this is true, as "speed>0.8".', metavar="TEST"
    )
    columns: str | None = entry(
        None, "What to show of the index beside what was swept, as cost,friction_used; 'list' "
        "tells what there is.", metavar="NAMES",
    )  # fmt: skip
    plot: Path | None = entry(
        None, "Draw cost and peak torques over what was swept: .png, .svg or .pdf.", written=True
    )
    at: tuple[str, ...] = entry(
        (), "Design the gait between the stored ones, as speed=0.83.", metavar="NAME=VALUE"
    )
    plugin: Path | None = entry(None, _PLUGIN)
    output: Path | None = entry(
        None, "Gait file to write the gait of --at to.", **_OUTPUT, suffixes=(".npz",)
    )


@dataclass(frozen=True)
class RequirementsOptions:
    """Say what each motor must deliver over a set of gaits, and in which of them."""

    gait: tuple[Path, ...] = entry(
        ..., "Gait files, .npz, or gait libraries.", argument=True, metavar="GAIT|LIBRARY"
    )
    against: tuple[Path, ...] = entry(
        (), "Gait or library of another design, to compare.", metavar="GAIT|LIBRARY"
    )
    motors: Path | None = entry(
        None, "Motors and gears of the joints, TOML; the table tells the shares of their limits."
    )
    output: Path | None = entry(
        None, "File to write the table to: .csv, .toml or .xlsx.", **_OUTPUT
    )
    figure: Path | None = entry(
        None, "File to draw torque over speed into: .png, .svg or .pdf.", written=True
    )


@dataclass(frozen=True)
class SensitivityOptions:
    """Say what a centimetre, a kilogram or a limit more would do to the cost of a gait."""

    gait: Path = entry(..., "A gait file, .npz.", argument=True, metavar="GAIT")
    plugin: Path | None = entry(None, _PLUGIN)
    most: int = entry(20, "How many lines to show.", metavar="N")
    output: Path | None = entry(None, "Write all of them: .csv.", **_OUTPUT, metavar="FILE")


@dataclass(frozen=True)
class SizeOptions:
    """Choose motors from a catalogue and gear ratios that serve a set of gaits."""

    gait: tuple[Path, ...] = entry(
        ..., "Gait files, .npz, or gait libraries.", argument=True, metavar="GAIT|LIBRARY"
    )
    catalogue: Path = entry(..., "Motors and gears to choose from, TOML.")
    output: Path = entry(
        ..., "Directory for motors.toml and the gaits designed again.", **_DIRECTORY
    )
    aim: str = entry(
        "mass",
        "What is to be least, mass or (copper) loss.",
        choices=("mass", "loss"),
        metavar="WHAT",
    )
    reserve: float = entry(
        1.1, "Of torque, heat and voltage, over what the gaits ask.", metavar="FACTOR"
    )


@dataclass(frozen=True)
class CodesignOptions:
    """Choose lengths, masses and gear ratios of a robot together, for a weighted set of walks."""

    output: Path = entry(
        ...,
        "Directory for robot, walks and report; trials that are there go on.",
        **_DIRECTORY,
        panel=DESIGN,
    )
    vary: tuple[str, ...] = entry(
        (), "What to choose: shin=25cm:35cm, motors.knee.ratio=6:12; a third number: the start.",
        metavar="NAME=LOWER:UPPER", panel=DESIGN,
    )  # fmt: skip
    keep_leg: bool = entry(False, "Thigh and shin together stay as long as they are.", panel=DESIGN)
    speeds: str | None = entry(
        None, "Speeds of the walks it is for, FIRST:LAST:STEP or a list.", metavar="M/S",
        panel=DESIGN,
    )  # fmt: skip
    walk: tuple[str, ...] = entry(
        (), "A further walk, as 'speed=0.6 slope=10% payload=5kg@torso weight=2'.",
        metavar="NAME=VALUE...", panel=DESIGN,
    )  # fmt: skip
    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


@dataclass(frozen=True)
class InspectOptions:
    """Say what gaitopt understood of a robot, what it guessed, and what is wrong with the file."""

    html: Path | None = entry(
        None, "Write a page with the robot standing and these tables.", panel=RESULTS, **_PAGE
    )
    write_choices: Path | None = entry(
        None,
        "Write what was found or guessed, to edit; then --choices FILE.",
        panel=RESULTS,
        **_TOML,
    )


@dataclass(frozen=True)
class RobotsOptions:
    """List the robots that can be asked for by name."""


@dataclass(frozen=True)
class UrdfOptions:
    """Write the URDF of a biped (by default of the thirteen-link one)."""

    output: Path | None = entry(
        None,
        "File to write the URDF to; by default the terminal.",
        **_OUTPUT,
        panel=RESULTS,
        suffixes=(".urdf", ".xml"),
    )
    write_spec: Path | None = entry(
        None, "File to write the parameter table to instead, to edit.", panel=RESULTS, **_TOML
    )


@dataclass(frozen=True)
class CheckOptions:
    """Compute a gait or a transition again, from its parameters alone, and certify it."""

    gait: Path = entry(..., _GAIT, argument=True, metavar="GAIT")
    plugin: Path | None = entry(None, _PLUGIN)


@dataclass(frozen=True)
class SimulateOptions:
    """Walk a gait in MuJoCo under feedback, and let MuJoCo check its numbers."""

    gait: Path = entry(..., "A gait file, .npz.", argument=True, metavar="GAIT")
    steps: int = entry(20, "How many steps to walk.")
    controller: str = entry(
        "whole-body", "Feedback that keeps it on its feet: whole-body or joint-pd.", metavar="NAME"
    )
    friction: float = entry(0.8, "Coefficient of friction of the simulated ground.", metavar="MU")
    thorough: bool = entry(
        False, "Try pushes, masses, ground, friction, delay, rotors, noise and starts."
    )
    output: Path | None = entry(None, "Directory to write summary.json to.", **_DIRECTORY)
    page: Path | None = entry(
        None, "Page to write: the walk beside the designed one, with the pushes of --thorough.",
        metavar="FILE", **_PAGE,
    )  # fmt: skip
    video: Path | None = entry(
        None, "The same as a film, .mp4, .webm or .gif; needs ffmpeg.", metavar="FILE", written=True
    )
    quiet: bool = entry(False, _QUIET, short="-q")


@dataclass(frozen=True)
class PlayOptions:
    """Watch a gait or a transition in the browser."""

    gait: Path = entry(..., _GAIT, argument=True, metavar="GAIT")
    html: Path | None = entry(None, "Write a page instead, complete in one file.", **_PAGE)
    steps: int | None = entry(None, "How many steps to show.")
    package_dir: tuple[Path, ...] = entry((), "Directory with the packages of the meshes.")
    host: str | None = entry(None, _HOST, metavar="ADDRESS")
    port: int | None = entry(None, _PORT)


@dataclass(frozen=True)
class LiveOptions:
    """Serve a page whose sliders are answered with the walk of their settings, at once."""

    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    output: Path = entry(
        Path("live"), "Directory for walks that are kept.", **_DIRECTORY, panel=RESULTS
    )
    host: str | None = entry(None, _HOST, metavar="ADDRESS", panel=RESULTS)
    port: int | None = entry(None, _PORT, panel=RESULTS)
    stay: bool = entry(False, "Go on when the page is closed.", panel=RESULTS)


@dataclass(frozen=True)
class PlotOptions:
    """Draw the figures of a gait or a transition."""

    gait: Path = entry(..., _GAIT, argument=True, metavar="GAIT")
    output: Path | None = entry(
        None, "Directory for the figures; by default 'figures' next to the gait.", **_DIRECTORY
    )
    format: tuple[str, ...] = entry(
        (), "Form of the figures: png (default), svg or pdf.", metavar="KIND"
    )


@dataclass(frozen=True)
class ExportOptions:
    """Write a gait, a transition, or a library for controllers, engines and learners."""

    gait: Path = entry(
        ..., "The file of a gait or a transition, or a gait library, all of which is written.",
        argument=True, metavar="GAIT",
    )  # fmt: skip
    format: str | None = entry(
        None,
        "Form: motion, mujoco, pinocchio, csv, g1-csv, bezier, json; mjcf: robot and walk.",
        metavar="NAME",
    )
    rate: float | None = entry(None, "Samples a second; each format has its default.", "Hz")
    strides: float | None = entry(None, "Strides of two steps; by default 1.", metavar="N")
    joints: str | None = entry(
        None,
        "Order of the joints: gait, mujoco, isaac, g1, mjcf (that of --format mjcf), or their "
        "names joined by commas.",
        metavar="ORDER",
    )
    output: Path | None = entry(
        None, "File, or directory for a library; without --format the suffix chooses the form: "
        ".csv, .json, .yaml.", **_OUTPUT,
    )  # fmt: skip
    both_legs: bool = entry(
        False, "Without --format: add the mirror image of the step: a whole stride."
    )


@dataclass(frozen=True)
class TransitionOptions:
    """Design the steps from standing to a walk, back, or from one walk to another."""

    begin: str = entry(
        ..., "What it leads from: a gait file, or 'standing'.", argument=True, metavar="FROM"
    )
    finish: str = entry(
        ..., "What it leads to: a gait file, or 'standing'.", argument=True, metavar="TO"
    )
    output: Path = entry(
        ..., "File to write, .npz: for gaitopt check, play, plot and export.", **_OUTPUT
    )
    steps: int = entry(3, "Number of steps between.", metavar="N")
    duration: str | None = entry(
        None, "Duration of each step, as 0.4 or 0.3,0.4; by default it is searched.", metavar="S"
    )
    shift: float = entry(
        0.0,
        "From standing: time in which the weight moves over one foot while both stand; "
        "searched with the duration of the first step.",
        "s",
    )
    stretch: float = entry(
        0.96, "Of the legs of a robot that stands: distance of hip and ankle over their length.",
        metavar="RATIO",
    )  # fmt: skip


@dataclass(frozen=True)
class ReproduceOptions:
    """Compute the paper's section 6 again, as `python -m reproduction` in the sources."""

    output: Path = entry(..., "Directory for reproduction.md, figures and numbers.", **_DIRECTORY)
    only: str | None = entry(None, "Only some tables and figures, as table3,fig7.", metavar="PARTS")
    quiet: bool = entry(False, _QUIET, short="-q")
