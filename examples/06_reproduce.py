"""Compute figures of the paper again: one step at 1.0 m/s, and the force of the ground.

The paper's whole section 6 takes minutes: `python -m reproduction`; docs/reproduction.md shows it
beside what is printed. `--only` takes parts of it, as here, or as `--only table3,fig7`.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # the reproduction is no part of what pip installs

from reproduction.__main__ import main  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "reproduction"

code = main(["--only", "fig4,fig5", "--quiet", "--output", str(RESULTS)])
for figure in sorted(RESULTS.rglob("*.png")):
    print(f"{figure.name}: {figure.stat().st_size // 1000} kB")
sys.exit(code)
