"""Design the walk of the thirteen-link biped at 1 m/s, prove it, read what its motors deliver."""

from pathlib import Path

from gaitopt import (
    Robot,
    biped13,
    design_gait,
    preset_task,
    save_gait,
    summarise,
    urdf_text,
    write_page,
)

RESULTS = Path(__file__).parent / "results"

robot = Robot.from_urdf(urdf_text(biped13()))
found = design_gait(robot, preset_task("standard", robot, speed=1.0))

print(f"{robot.name}: {found.gait.cost:.0f} N²·m·s, {found.certificate.verdict}")
for motor in summarise(found.gait)["motors"]:
    print(
        f"{motor['joint']:12} {motor['peak_torque_Nm']:6.1f} N·m at most, "
        f"{motor['peak_speed_rad_per_s']:5.2f} rad/s at most"
    )

RESULTS.mkdir(exist_ok=True)
save_gait(found.gait, RESULTS / "walk.npz")
write_page(found.gait, RESULTS / "walk.html")
print("watch it: results/walk.html")
