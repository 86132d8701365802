"""Thousands of damaged inputs: refused in words or read as they are, soon, and in little memory.

Files (URDF, MJCF, TOML, gait files, libraries) and command lines are changed at random, each by
the seed and its number alone, so that one can be tried again: `--only 4711`. Every mutation runs in
a process that may die of it. Robots that are read are compared with MuJoCo, or with a strict reader
where MuJoCo refuses a file or reads it otherwise than the URDF standard.

A run that was ended goes on where it was: `--state FILE` has a line per mutation.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import multiprocessing
import os
import re
import resource
import shutil
import sys
import tempfile
import threading
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from common import save

sys.path.append(str(Path(__file__).parents[1] / "tests"))

SEED, COUNT = 10, 20_000
MOST_SECONDS = 20.0
"""Of processor, of one mutation."""
MOST_WALL = 400.0  # s, after which a process is ended: the machine may be busy
MOST_MEMORY = 1e9
"""Bytes of memory that one mutation may take beyond what its process had."""
_LIFE = 250  # mutations of one process


def _worker(pipe: Any, inputs: str, seed: int) -> None:
    """Run mutations by their numbers until the pipe ends; the screen goes to a file."""
    from fuzz_cases import run_case

    caught = tempfile.TemporaryFile()  # noqa: SIM115
    for stream in (1, 2):
        os.dup2(caught.fileno(), stream)
    _warm(inputs)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    most = size + int(MOST_MEMORY) + 2**28
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(EOFError):
        while True:
            number = pipe.recv()
            folder = Path(tempfile.mkdtemp(prefix="gaitopt-fuzz-"))
            begun, had = caught.seek(0, os.SEEK_END), _reset_peak()
            try:
                outcome = run_case(number, seed, Path(inputs), folder)
            finally:
                shutil.rmtree(folder, ignore_errors=True)
            taken = _peak() - had
            for own in (sys.stdout, sys.stderr):
                own.flush()
            caught.seek(begun)
            if text := caught.read().decode("utf-8", "replace").strip():
                outcome.findings.append(f"output: {text[:300]!r}")
            if outcome.seconds > MOST_SECONDS:
                outcome.findings.append(f"time: {outcome.seconds:.0f} s of processor")
            if taken > MOST_MEMORY:
                outcome.findings.append(f"memory: {taken / 1e6:.0f} MB")
            pipe.send({"number": number, "memory": taken, **asdict(outcome)})


def _warm(inputs: str) -> None:
    """Import what all need, so that it is not counted."""
    from gaitopt import Robot

    for name in ("mujoco", "gaitopt.cli.app", "gaitopt.cli.request", "gaitopt.view.page"):
        __import__(name)
    Robot.from_urdf(Path(inputs) / "robot.urdf")


def _reset_peak() -> int:
    """Forget the largest memory so far; return what is in use [bytes]."""
    Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def _peak() -> int:
    return _status("VmHWM")


def _status(name: str) -> int:
    text = Path("/proc/self/status").read_text()
    return 1024 * int(re.search(rf"{name}:\s+(\d+)", text)[1])  # type: ignore[index]


class _Hand(threading.Thread):
    """Feeds one process after another, and sees how each ends."""

    def __init__(self, numbers: Any, inputs: Path, seed: int, note: Any) -> None:
        super().__init__(daemon=True)
        self._numbers, self._inputs, self._seed, self._note = numbers, inputs, seed, note

    def run(self) -> None:
        process = pipe = None
        done = 0
        for number in self._numbers:
            if process is None or done >= _LIFE:
                self._end(process, pipe)
                (process, pipe), done = self._begin(), 0
            try:
                pipe.send(number)
                if not pipe.poll(MOST_WALL):
                    self._note(self._fault(number, f"time: no answer in {MOST_WALL:.0f} s"))
                    process.kill()
                    self._end(process, pipe)
                    process = None
                    continue
                self._note(pipe.recv())
                done += 1
            except (EOFError, OSError):
                process.join()
                self._note(self._fault(number, f"crash: the process ended by {process.exitcode}"))
                process = None
        self._end(process, pipe)

    def _begin(self) -> tuple[Any, Any]:
        context = multiprocessing.get_context("spawn")
        own, other = context.Pipe()
        process = context.Process(target=_worker, args=(other, str(self._inputs), self._seed))
        process.start()
        other.close()
        return process, own

    def _end(self, process: Any, pipe: Any) -> None:
        if process is not None:
            pipe.close()
            process.join()

    def _fault(self, number: int, words: str) -> dict[str, Any]:
        from fuzz_cases import Outcome, kind_of

        outcome = Outcome(kind_of(number), "no answer", [words])
        return {"number": number, "memory": 0, **asdict(outcome)}


class _Numbers:
    """What is still to do, for several who ask."""

    def __init__(self, numbers: list[int], until: float) -> None:
        self._left, self._until, self._lock = iter(numbers), until, threading.Lock()

    def __iter__(self) -> _Numbers:
        return self

    def __next__(self) -> int:
        if time.time() > self._until:
            raise StopIteration
        with self._lock:
            return next(self._left)


def run(numbers: list[int], seed: int, state: Path, workers: int, seconds: float) -> None:
    """Run mutations; each adds a line to the state."""
    from fuzz_cases import prepare

    lock = threading.Lock()

    def note(entry: dict[str, Any]) -> None:
        with lock, state.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(entry) + "\n")
        for finding in entry["findings"]:
            print(f"{entry['number']} ({entry['kind']}): {finding}", file=sys.stderr, flush=True)

    with tempfile.TemporaryDirectory(prefix="gaitopt-fuzz-inputs-") as folder:
        prepare(Path(folder) / "inputs")
        shared = _Numbers(numbers, time.time() + seconds)
        hands = [_Hand(shared, Path(folder) / "inputs", seed, note) for _ in range(workers)]
        for hand in hands:
            hand.start()
        for hand in hands:
            hand.join()


def summary(entries: list[dict[str, Any]], seed: int) -> dict[str, Any]:
    """Return counts by kind, the slowest and largest, and every finding."""
    kinds: dict[str, dict[str, Any]] = {}
    for entry in entries:
        kind = kinds.setdefault(
            entry["kind"],
            {"mutations": 0, "results": {}, "findings": 0, "seconds": 0.0, "memory": 0.0},
        )
        kind["mutations"] += 1
        kind["results"][entry["result"]] = kind["results"].get(entry["result"], 0) + 1
        kind["findings"] += bool(entry["findings"])
        kind["seconds"] = max(kind["seconds"], entry["seconds"])
        kind["memory"] = max(kind["memory"], entry["memory"] / 1e6)
    notes = Counter(note for entry in entries for note in entry["notes"])
    return {
        "seed": seed,
        "mutations": len(entries),
        "last": max(entry["number"] for entry in entries),
        "kinds": kinds,
        "notes": dict(notes.most_common(30)),
        "findings": [
            {"number": e["number"], "kind": e["kind"], "finding": finding}
            for e in entries
            for finding in e["findings"]
        ],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="200 mutations; saves nothing")
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", type=int, nargs="+", help="these numbers, none else")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="end after these")
    parser.add_argument("--state", type=Path, help="where to go on, and to note what is done")
    given = parser.parse_args()
    numbers = given.only or list(range(given.first, given.first + given.count))
    if given.quick:
        numbers = numbers[:200]
    with tempfile.TemporaryDirectory() as folder:
        state = given.state or Path(folder) / "state.jsonl"
        before = state.read_text(encoding="utf-8").splitlines() if state.exists() else []
        known = {json.loads(line)["number"] for line in before}
        left = [n for n in numbers if n not in known]
        if left and given.minutes > 0:
            run(left, given.seed, state, given.workers, 60.0 * given.minutes)
        lines = state.read_text(encoding="utf-8").splitlines()
    entries = sorted(map(json.loads, lines), key=lambda entry: int(entry["number"]))
    save("fuzz", summary(entries, given.seed), bool(given.quick or given.only))


if __name__ == "__main__":
    main()
