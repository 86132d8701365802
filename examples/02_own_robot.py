"""Walk the robot of a file: here one that we write first, so that there is a file.

With a robot of your own, no file is written and the path is yours; an MJCF file does as
well. `robot.findings` tells what was found, guessed and changed.
"""

from pathlib import Path

from gaitopt import Robot, biped13, design_gait, preset_task, urdf_text

RESULTS = Path(__file__).parent / "results"
RESULTS.mkdir(exist_ok=True)
file = RESULTS / "robot.urdf"
file.write_text(urdf_text(biped13()), encoding="utf-8")

robot = Robot.from_urdf(file)
print(robot)
for finding in robot.findings:
    print(f"  {finding.subject}: {finding.text}")

found = design_gait(robot, preset_task("humanoid", robot, speed=0.6))
print(f"{found.gait.cost:.0f} N²·m·s at 0.6 m/s, {found.certificate.verdict}")
