"""Read a walk at any instants: base, joints, torques, ground forces, as a controller wants them."""

from pathlib import Path

from gaitopt import Robot, biped13, design_gait, export, preset_task, urdf_text

RESULTS = Path(__file__).parent / "results"
RESULTS.mkdir(exist_ok=True)

robot = Robot.from_urdf(urdf_text(biped13()))
gait = design_gait(robot, preset_task("standard", robot, speed=1.0)).gait

walk = gait.trajectory
samples = walk.at(walk.times(rate=500.0, strides=2))  # four steps at 500 Hz
ahead = samples.base_position[-1, 0] - samples.base_position[0, 0]
speed = ahead / (samples.time[-1] - samples.time[0])
print(f"{len(samples.time)} instants, mean speed {speed:.2f} m/s")
print(
    f"vertical ground force {samples.force[:, :, 2].sum(axis=1).min():.0f} to "
    f"{samples.force[:, :, 2].sum(axis=1).max():.0f} N"
)

print(export(gait, RESULTS / "walk.csv", both_legs=True))  # the samples of the gait file
# motions in a reader's own form and order of joints: docs/motions.md
print(export(gait, RESULTS / "mujoco.npz", format="mujoco", rate=500.0, strides=2))
print(export(gait, RESULTS / "tracker.npz", format="motion", strides=20, joints="isaac"))
