"""Compute a table of the paper again and print it beside the printed one.

Everything of the paper's section 6 takes minutes: `python -m reproduction`; a part, as here, seconds.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # the reproduction is no part of what pip installs

from reproduction.__main__ import main  # noqa: E402

sys.exit(main(["--only", "table3", "--quiet", "--output", str(Path(__file__).parent / "results")]))
