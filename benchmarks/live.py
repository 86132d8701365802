"""How soon a page of `gaitopt live` shows the walk of a slider: in a real browser, move by move.

    python benchmarks/live.py [--quick] [--moves 500]

Needs Chromium. A move ends when the page shows the curves of its settings, or says why there is no
walk; then comes the next one, of a slider drawn at random, by up to three of its steps.
"""

from __future__ import annotations

import asyncio
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, save

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "view"))

from browser import opened

ROBOTS = {"biped13": (), "g1": ("--robot", "g1", "--speed", "0.6")}
SETTLES = 3.0  # s after which a resting page must be certified again
MOVE = """(() => {
  const inputs = [...document.querySelectorAll('#sliders input')];
  const input = inputs[%d %% inputs.length];
  const value = Number(input.value) + %d * Number(input.step);
  const inside = Math.min(Math.max(value, Number(input.min)), Number(input.max));
  // near where it began: a walk through all of the box spends its time where there is no walk
  const first = Number(input.defaultValue), reach = 6 * Number(input.step);
  input.value = Math.min(Math.max(inside, first - reach), first + reach);
  input.oninput();
  return inputs.length;
})()"""
SEEN = "({number: gaitoptLive.number, seen: gaitoptLive.seen, kind: gaitoptLive.kind})"


async def driven(url: str, moves: int, folder: Path, errors: list[str]) -> dict[str, Any]:
    """Move the sliders of a page and return how long each answer took."""
    rng = np.random.default_rng(0)
    async with opened(url, folder) as page:
        await page.wait_for("!!window.gaitoptLive && !!document.querySelector('.foot span')")
        await page.value("window.addEventListener('error', e => (window.wrong = e.message)); 0")
        await asyncio.sleep(1.0)
        none, before = 0, await page.value("performance.memory.usedJSHeapSize")
        for number in range(1, moves + 1):
            await page.value(MOVE % (rng.integers(100), rng.integers(-3, 4)))
            await page.wait_for(f"gaitoptLive.seen >= {number}")
            none += (await page.value(SEEN))["kind"] == "none"
            wrong = await page.value("window.wrong || ''")
            if wrong:
                errors.append(wrong)
        await asyncio.sleep(SETTLES)
        verdict = await page.value("document.getElementById('verdict').textContent")
        return {
            "delays": await page.value("gaitoptLive.delays"),
            "without_walk": none,
            "verdict_at_rest": verdict,
            "heap_mb": [
                before / 1e6,
                (await page.value("performance.memory.usedJSHeapSize")) / 1e6,
            ],
        }


def measured(name: str, words: tuple[str, ...], moves: int) -> dict[str, Any]:
    """Return the figures of a robot."""
    errors: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "gaitopt", "live", "--port", "0", "-o", f"{folder}/kept"]
        process = subprocess.Popen(
            [*command, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        url = re.search(r"http://\S+", process.stdout.readline())
        assert url is not None
        began = time.perf_counter()
        found = asyncio.run(driven(url[0], moves, Path(folder), errors))
        seconds = time.perf_counter() - began
        code = process.wait(30.0)
    delays = np.array(found.pop("delays"))
    return {
        "robot": name, "moves": moves, "answers": len(delays), "errors": errors,
        "ms": {f"p{p}": float(np.percentile(delays, p)) for p in (50, 90, 99)},
        "seconds": seconds, "exit_code_after_closing": code, **found,
    }  # fmt: skip


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--moves", type=int, default=500)
    asked = parser.parse_args()
    moves = 20 if asked.quick else asked.moves
    save("live", [measured(name, words, moves) for name, words in ROBOTS.items()], asked.quick)


if __name__ == "__main__":
    main()
