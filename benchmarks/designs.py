"""Certified designs and next walks beside version 0.1 and the plain path, in turns.

python benchmarks/designs.py --old DIRECTORY [--quick]

DIRECTORY is a clone of version 0.1 (commit 97ed007). Each is a process of its own that works when
it is its turn, so that all of them meet the same machine.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

from common import arguments, save

SPEEDS = (0.6, 0.8, 1.0, 1.2)
"""Of the biped, preset `standard` [m/s]."""
APART = 0.01
"""How much slower the walk is from which the next one is sought [m/s]."""
TURNS, AGAIN = 10, 3
HERE = Path(__file__).parents[1]

WORK = """
import sys, time
from gaitopt import Robot, WalkProblem, biped13, design_gait, preset_task, urdf_text
from gaitopt.nlp import Start
robot = Robot.from_urdf(urdf_text(biped13()), stance_sole="right_sole", swing_sole="left_sole")
speeds, apart, again = SETTINGS
task = lambda speed: preset_task("standard", speed=speed)
try:
    from gaitopt import Replanner
except ImportError:
    from gaitopt.gait.guess import first_guess
    from gaitopt.solvers.sqp import SQP
    design = lambda speed: design_gait(robot, task(speed))
    def solved(speed, start=None):
        walk = WalkProblem(robot, task(speed))
        return SQP().solve(walk, start or Start(first_guess(walk)))
    known = {s: solved(s - apart) for s in speeds}
    following = lambda s: solved(s, Start(known[s].x, known[s].multipliers))
else:
    design = lambda speed: design_gait(robot, task(speed), starts=1)
    known = {}
    for s in speeds:
        planner = Replanner()
        for _ in range(2):
            planner.replan(robot, task(s - apart))
        known[s] = planner, planner.last
    def following(speed):
        planner, planner.last = known[speed]
        return planner.replan(robot, task(speed))
def least(function, speed, times):
    taken = []
    for _ in range(times):
        began = time.process_time()
        function(speed)
        taken.append(time.process_time() - began)
    return min(taken)
for line in sys.stdin:
    print(*(least(design, s, 1) for s in speeds), *(least(following, s, again) for s in speeds))
    sys.stdout.flush()
"""


def measured(old: str, turns: int) -> dict[str, dict[str, list[list[float]]]]:
    """Return processor times of designs and next walks, turn after turn, at each speed [s]."""
    sources = {"0.1": (old, "1"), "plain path": (HERE, "0"), "gaitopt": (HERE, "1")}
    found: dict[str, dict[str, list[list[float]]]] = {
        name: {"design": [], "next walk": []} for name in sources
    }
    with ExitStack() as stack, tempfile.TemporaryDirectory() as modules:
        workers = {
            name: stack.enter_context(_worker(Path(path).resolve(), wanted, modules))
            for name, (path, wanted) in sources.items()
        }
        for turn in range(turns + 1):
            for name, worker in workers.items():
                assert worker.stdin is not None
                assert worker.stdout is not None
                print(file=worker.stdin, flush=True)
                times = [float(word) for word in worker.stdout.readline().split()]
                if turn:  # the first time all is made that is kept
                    found[name]["design"].append(times[: len(SPEEDS)])
                    found[name]["next walk"].append(times[len(SPEEDS) :])
        for worker in workers.values():
            assert worker.stdin is not None
            worker.stdin.close()
    return found


def _worker(path: Path, wanted: str, modules: str) -> subprocess.Popen[str]:
    environment = {
        **os.environ, "PYTHONPATH": str(path), "GAITOPT_COMPILED": wanted,
        "PYTHONPYCACHEPREFIX": modules, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
    }  # fmt: skip
    work = f"SETTINGS = {SPEEDS!r}, {APART!r}, {AGAIN!r}\n{WORK}"
    return subprocess.Popen(
        [sys.executable, "-c", work], env=environment, cwd=modules, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--old", required=True, help="directory of a clone of version 0.1")
    options = parser.parse_args()
    data = measured(options.old, 1 if options.quick else TURNS)
    save("designs", {"speeds": SPEEDS, **data}, options.quick)


if __name__ == "__main__":
    main()
