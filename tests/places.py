"""Where the files are that tests read."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
DATA = ROOT / "tests" / "data"
CASES = DATA / "cases"
REFERENCE = DATA / "reference_biped13.npz"
LIBRARY_0_1 = DATA / "library_0.1"
SWING_HEIGHT = DATA / "plugins" / "swing_height.py"
EXAMPLES = ROOT / "examples"
DOCS = ROOT / "docs"
