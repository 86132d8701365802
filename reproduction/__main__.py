"""`python -m reproduction`: the paper's section 6 computed again, as a page or part by part."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from gaitopt.cli.results import require_writable
from gaitopt.design.process import small_matrices
from gaitopt.errors import GaitoptError
from reproduction.page import PARTS, part_text, write_figures, write_reproduction
from reproduction.results import Reproduction

OUTPUT = Path("reproduced")
INTERRUPTED = 130  # exit code after Ctrl-C, as of gaitopt


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: by default those of the process.

    Returns:
        The exit code: 0 done, 2 bad input, 3 a walk was not found, 130 interrupted.
    """
    given = _parser().parse_args(arguments)
    try:
        require_writable(given.output)
        with small_matrices():
            _run(given.only, given.output, given.quiet)
    except GaitoptError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("error: interrupted; every file that was written is complete", file=sys.stderr)
        return INTERRUPTED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m reproduction",
        description="Compute the tables and figures of the paper's section 6 beside the printed "
        "ones. Everything takes minutes.",
        epilog="Parts: " + "; ".join(f"{name}: {part.title}" for name, part in PARTS.items()),
    )
    parser.add_argument(
        "--only", type=_parts, metavar="PARTS",
        help="print these parts and write their figures instead of the page, as table3,fig7",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=_directory, default=OUTPUT, metavar="DIR",
        help="for reproduction.md, reproduction.json and figures (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors and parts only")
    return parser


def _parts(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    unknown = [name for name in names if name not in PARTS]
    if unknown or not names:
        given = f"there is no part '{unknown[0]}'" if unknown else "no part is given"
        raise argparse.ArgumentTypeError(f"{given}; parts are {', '.join(PARTS)}")
    return list(dict.fromkeys(names))


def _directory(text: str) -> Path:
    if not text.strip():
        raise argparse.ArgumentTypeError("the name is empty; give a directory")
    return Path(text)


def _run(only: list[str] | None, output: Path, quiet: bool) -> None:
    started = time.monotonic()

    def tell(stage: str) -> None:
        if not quiet:
            print(f"{time.monotonic() - started:5.0f} s  {stage}", file=sys.stderr, flush=True)

    result = Reproduction(tell)
    if only is None:
        written = write_reproduction(result, output)
    else:
        for name in only:
            print(part_text(result, name), end="\n\n", flush=True)
        figures = [figure for name in only for figure in PARTS[name].figures]
        written = write_figures(result, output, figures)
    if quiet:
        return
    if only is None:
        worst = 100.0 * float(abs(result.errors).max())
        print(f"largest error at the speeds of Table 3: {worst:.2f} %")
    for path in written:
        print(f"wrote {path}")


if __name__ == "__main__":
    raise SystemExit(main())
