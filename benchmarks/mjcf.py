"""MJCF files beside MuJoCo: random ones by their seed, or all humanoids in given directories.

Printed is the largest relative difference of every quantity, over all files and postures: mass
matrix, bias forces, placements of the bodies, ranges, forces, passive joints, shapes.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[1] / "tests"))

RANDOM = 500
"""Random files."""
POSTURES = 20
"""Random postures of each file."""
TOLERANCE = 1e-9
"""Relative; corners of meshes, which MuJoCo has in single precision, are not held to it."""


def compared(path: Path, seed: int, postures: int) -> dict[str, Any]:
    """Compare one file, and tell how it went."""
    from mjcf_oracle import compare

    from gaitopt.errors import GaitoptError

    began = time.perf_counter()
    try:
        worst = compare(path, seed, postures).worst
    except GaitoptError as error:
        return {"refused": str(error)}
    except ValueError as error:  # a part of a scene, say, that does not stand alone
        return {"refused": f"by MuJoCo: {' '.join(str(error).split())}"}
    return {"worst": worst, "seconds": time.perf_counter() - began}


def random_files(count: int, postures: int) -> dict[str, dict[str, Any]]:
    """Compare random files."""
    from mjcf_generator import write_random_mjcf

    results = {}
    for seed in range(count):
        with tempfile.TemporaryDirectory() as folder:
            path = write_random_mjcf(Path(folder), seed)
            results[f"seed {seed}"] = compared(path, seed, postures)
    return results


def files_below(folders: list[Path], postures: int) -> dict[str, dict[str, Any]]:
    """Compare every MJCF file in some directories."""
    results = {}
    for folder in folders:
        for path in sorted(folder.rglob("*.xml")):
            if "<mujoco" in path.read_text(encoding="utf-8", errors="replace")[:4000]:
                results[str(path.relative_to(folder))] = compared(path, 0, postures)
    return results


def table(results: dict[str, dict[str, Any]]) -> str:
    """Return what came out, as a table of Markdown."""
    sound = {name: r["worst"] for name, r in results.items() if "worst" in r}
    quantities = sorted({q for worst in sound.values() for q in worst})
    lines = [
        "| quantity | files | largest relative difference | in |",
        "| --- | ---: | ---: | --- |",
    ]
    for quantity in quantities:
        values = {name: worst[quantity] for name, worst in sound.items() if quantity in worst}
        name = max(values, key=lambda n: values[n])
        lines.append(f"| {quantity} | {len(values)} | {values[name]:.1e} | {name} |")
    refused = {name: r["refused"] for name, r in results.items() if "refused" in r}
    lines += ["", f"{len(sound)} files compared, {len(refused)} refused"]
    lines += [f"- {name}: {text}" for name, text in refused.items()]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path, help="directories with MJCF files")
    parser.add_argument("--count", type=int, default=RANDOM, help="random files, without folders")
    parser.add_argument("--postures", type=int, default=POSTURES)
    parser.add_argument("--json", action="store_true", help="print every number")
    given = parser.parse_args()
    if given.folders:
        results = files_below(given.folders, given.postures)
    else:
        results = random_files(given.count, given.postures)
    print(json.dumps(results, indent=1) if given.json else table(results))
    worst = [
        value
        for result in results.values()
        for quantity, value in result.get("worst", {}).items()
        if "single" not in quantity
    ]
    sys.exit(0 if worst and max(worst) < TOLERANCE else 1)


if __name__ == "__main__":
    main()
