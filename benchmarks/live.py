"""How soon a page of `gaitopt live` shows the walk of a slider: in a real browser, move by move.

    python benchmarks/live.py [--quick] [--moves 500]

Needs Chromium. A move ends when the page has the curves of its settings, or says why there is no
walk; then comes the next one, of a slider drawn at random, by up to three of its steps. Every
`RESTS` moves the page is left alone until its walk is certified; whatever is shown as certified is
held against the settings that were sent for it. Memory is read after a collection of garbage.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, save

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "view"))

from browser import Page, opened

ROBOTS = {"biped13": (), "g1": ("--robot", "g1", "--speed", "0.6")}
RESTS = 25  # moves after which the page may rest
READY = "!!window.gaitoptLive && !!document.querySelector('.foot span')"
PROBE = """(() => {
  window.bench = { errors: [], painted: [], certified: [], sent: {} };
  addEventListener("error", event => bench.errors.push(event.message));
  addEventListener("unhandledrejection", event => bench.errors.push(String(event.reason)));
  const text = name => document.getElementById(name).textContent;
  let seen = 0;
  Object.defineProperty(gaitoptLive, "seen", { get: () => seen, set: number => {
    if (number > seen) requestAnimationFrame(() => setTimeout(
      () => bench.painted.push(performance.now() - bench.sent[number].at)));
    seen = number;
  } });
  new MutationObserver(() => {
    if (text("verdict") !== "certified") return;
    bench.certified.push({ number: gaitoptLive.shown, title: text("title"), facts: text("facts"),
                           period: gaitoptLive.curves.curves.period });
  }).observe(document.getElementById("verdict"), { childList: true });
})()"""
MOVE = """(() => {
  const inputs = [...document.querySelectorAll('#sliders input')];
  const input = inputs[%d %% inputs.length];
  const value = Number(input.value) + %d * Number(input.step);
  const inside = Math.min(Math.max(value, Number(input.min)), Number(input.max));
  // near where it began: a walk through all of the box spends its time where there is no walk
  const first = Number(input.defaultValue), reach = 6 * Number(input.step);
  input.value = Math.min(Math.max(inside, first - reach), first + reach);
  delete input.dataset.value;
  const settings = Object.fromEntries(
    inputs.map(one => [one.name, Number(one.dataset.value ?? one.value)]));
  bench.sent[gaitoptLive.number + 1] = { at: performance.now(), ...settings };
  input.oninput();
})()"""
AT_REST = """document.getElementById('verdict').textContent !==
  'optimal at the samples; its certificate follows' && !document.body.matches('.behind')"""


async def driven(url: str, moves: int, folder: Path, process: int) -> dict[str, Any]:
    """Move the sliders of a page and return how long each answer took, and what it left behind."""
    rng = np.random.default_rng(0)
    async with opened(url, folder) as page:
        await page.wait_for(READY)
        await page.value(PROBE)
        none, memory = 0, []
        for number in range(1, moves + 1):
            await page.value(MOVE % (rng.integers(100), rng.integers(-3, 4)))
            await page.wait_for(f"gaitoptLive.seen >= {number}")
            none += await page.value("gaitoptLive.kind") == "none"
            if number % RESTS == 0:
                await page.wait_for(AT_REST)
            if number in (moves // 5, moves):
                memory.append(await footprint(page, process))
        await page.wait_for(AT_REST)
        found = await page.value("bench")
        return {
            "delays": await page.value("gaitoptLive.delays"),
            "painted": found["painted"],
            "errors": found["errors"],
            "without_walk": none,
            "certified": len(found["certified"]),
            "stale": sum(stale(one, found["sent"]) for one in found["certified"]),
            "memory": memory,
        }


async def footprint(page: Page, process: int) -> dict[str, float]:
    """Return what page and server hold."""
    await page.call("HeapProfiler.collectGarbage")
    await page.call("Performance.enable")
    known = {
        one["name"]: one["value"] for one in (await page.call("Performance.getMetrics"))["metrics"]
    }
    status = Path(f"/proc/{process}/status").read_text()
    return {
        "page_heap_mb": known["JSHeapUsedSize"] / 1e6,
        "page_nodes": known["Nodes"],
        "page_listeners": known["JSEventListeners"],
        "server_mb": int(re.search(r"VmRSS:\s+(\d+)", status)[1]) / 1024.0,  # type: ignore[index]
    }


def stale(shown: dict[str, Any], sent: dict[str, dict[str, float]]) -> bool:
    """Whether what is shown as certified is not the walk of the settings sent for it."""
    settings = sent[str(shown["number"])]
    speed = float(re.search(r" at (\S+) m/s", shown["title"])[1])  # type: ignore[index]
    duration = float(re.search(r" m in (\S+) s", shown["facts"])[1])  # type: ignore[index]
    return not (
        np.isclose(speed, settings["speed"], atol=5e-4)
        and np.isclose(duration, settings["duration"], atol=6e-4)
        and np.isclose(shown["period"], 2.0 * settings["duration"], atol=1e-9)
    )


@contextlib.contextmanager
def served(words: tuple[str, ...], folder: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A running `gaitopt live`, and its address."""
    command = [sys.executable, "-m", "gaitopt", "live", "--port", "0", "-o", f"{folder}/kept"]
    process = subprocess.Popen(
        [*command, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        assert found is not None
        yield process, found[0]
    finally:
        process.kill()
        process.wait()


async def interrupted(url: str, folder: Path, process: subprocess.Popen[str]) -> dict[str, float]:
    """Press Ctrl-C while the page is open and answers."""
    async with opened(url, folder) as page:
        await page.wait_for(READY)
        await page.value(PROBE)
        await page.value(MOVE % (0, 3))
        process.send_signal(signal.SIGINT)
        began = time.perf_counter()
        while process.poll() is None and time.perf_counter() - began < 60.0:
            await asyncio.sleep(0.01)
        return {"exit_code": process.returncode, "seconds": time.perf_counter() - began}


def measured(name: str, words: tuple[str, ...], moves: int) -> dict[str, Any]:
    """Return the figures of a robot."""
    with tempfile.TemporaryDirectory() as folder, served(words, folder) as (process, url):
        began, before = time.perf_counter(), processor(process.pid)
        found = asyncio.run(driven(url, moves, Path(folder), process.pid))
        seconds, used = time.perf_counter() - began, processor(process.pid) - before
        closed = time.perf_counter()
        closing = {"exit_code": process.wait(60.0), "seconds": time.perf_counter() - closed}
    with tempfile.TemporaryDirectory() as folder, served(words, folder) as (process, url):
        interrupt = asyncio.run(interrupted(url, Path(folder), process))
    return {
        "robot": name, "moves": moves, "priority": os.nice(0),
        "curves_ms": shares(found.pop("delays")), "painted_ms": shares(found.pop("painted")),
        "seconds": seconds, "server_processor_s": used, **found,
        "after_closing": closing, "after_interrupt": interrupt,
    }  # fmt: skip


def processor(process: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def shares(values: list[float]) -> dict[str, float]:
    """Return number and percentiles of what was measured."""
    return {
        "count": len(values),
        **{f"p{p}": float(np.percentile(values, p)) for p in (50, 90, 99)},
    }


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--moves", type=int, default=500)
    asked = parser.parse_args()
    moves = 20 if asked.quick else asked.moves
    save("live", [measured(name, words, moves) for name, words in ROBOTS.items()], asked.quick)


if __name__ == "__main__":
    main()
