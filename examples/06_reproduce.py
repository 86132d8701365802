"""Compute costs of the paper again, beside those that it prints, and draw a step at 1.0 m/s.

The paper's whole section 6 takes minutes: `python -m reproduction`; docs/reproduction.md shows it
beside what is printed. `--only` takes parts of it, as here, or as `--only table3,fig5`.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # the reproduction is no part of what pip installs

from reproduction.__main__ import main  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "reproduction"

code = main(["--only", "fig7,fig4", "--quiet", "--output", str(RESULTS)])
for figure in sorted(RESULTS.rglob("*.png")):
    print(f"wrote {figure}")
sys.exit(code)
