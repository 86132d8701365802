#!/usr/bin/env bash
# Version:  jiminy-py 1.8.13 with numpy 2.2.6
# Does:     a ground of Jiminy gives height and normal of each point. sum_heightmaps adds the heights, as it says, and gives the mean
#           of the normals, made to length 1: of two equal waves the sum is twice as high and as steep as one, and its normal
#           is that of one. random_tile_ground with an orientation turns the tiles and not their normals. The contact
#           forces of the engine go along these normals. Perlin grounds, turned too, and tiles that are not turned have the
#           normals of their heights.
# Guess:    a normal is at a right angle to the ground that the feet stand on.
# Means:    rough terrain is made in this way, waves plus tiles: a foot on a slope of 60 degrees is pushed as on one of 41,
#           so it slips where it should hold, or holds where it should slip, and contact does work where there is no friction.
#           Walks that are tried on it are tried on other ground than is drawn. Take one Perlin ground, or turn the robot, not
#           the tiles. No report was found.
# Seen:     normals against difference quotients of the heights, 200 points: wave, Perlin and upright tiles 0.00 degrees off; tiles
#           turned by 0.4 rad up to 14; sums of two grounds 14 and 16 in the median, 20 at most; a point 1 mm inside, without
#           friction, is pushed 40.9 degrees from upright on a slope of 60.0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check jiminy-py==1.8.13 numpy==2.2.6 2>/dev/null
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import jiminy_py.core as jiminy
import numpy as np

Path("ball.urdf").write_text("""<robot name="ball"><link name="ball"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></robot>""")


def query(ground, x, y):
    heights, normals = np.zeros(2), np.zeros((3, 2), order="F")
    jiminy.query_heightmap(ground, np.asfortranarray([[x, x], [y, y]]), heights, normals)
    return heights[0], normals[:, 0].copy()


def by_difference(ground, x, y, step=1e-5):
    slope_x = (query(ground, x + step, y)[0] - query(ground, x - step, y)[0]) / (2 * step)
    slope_y = (query(ground, x, y + step)[0] - query(ground, x, y - step)[0]) / (2 * step)
    normal = np.array([-slope_x, -slope_y, 1.0])
    return normal / np.linalg.norm(normal)


def pushed(ground, x, y):
    """Direction of the force on a point that is 1 mm inside the ground, without friction and gravity."""
    robot = jiminy.Robot("ball")
    robot.initialize(str(Path("ball.urdf").resolve()), has_freeflyer=True)
    robot.add_contact_points(["ball"])
    engine = jiminy.Engine()
    engine.add_robot(robot)
    options = engine.get_options()
    options["world"]["gravity"][:], options["world"]["groundProfile"] = 0.0, ground
    options["contacts"]["model"], options["contacts"]["friction"] = "spring_damper", 0.0
    engine.set_options(options)
    engine.start(np.array([x, y, query(ground, x, y)[0] - 1e-3, 0.0, 0.0, 0.0, 1.0]), np.zeros(6))
    (state,) = engine.robot_states
    force = state.a[:3].copy()
    engine.stop()
    return force / np.linalg.norm(force)


def angle(one, other):
    return float(np.degrees(np.arccos(np.clip(one @ other, -1.0, 1.0))))


wave, other = jiminy.unidirectional_random_perlin_ground(1.0, 3, 0.4, 1), jiminy.random_perlin_ground(1.0, 3, 1)
size, smooth = np.array([1.0, 0.7]), np.array([0.2, 0.15])
grounds = {
    "wave": wave,
    "Perlin": other,
    "tiles": jiminy.random_tile_ground(size, 0.3, smooth, 3, 0.0, 7),
    "tiles turned by 0.4 rad": jiminy.random_tile_ground(size, 0.3, smooth, 3, 0.4, 7),
    "wave + wave": jiminy.sum_heightmaps([wave, wave]),
    "wave + Perlin": jiminy.sum_heightmaps([wave, other]),
}
points = np.random.default_rng(0).uniform(-4.0, 4.0, (200, 2))
off = {}
for name, ground in grounds.items():
    errors = [angle(query(ground, *point)[1], by_difference(ground, *point)) for point in points]
    off[name] = float(np.percentile(errors, 95))  # not the few points on an edge
    print(f"{name}: normal off by {np.median(errors):.2f} degrees in the median, {off[name]:.2f} in the worst twentieth")
assert all((value > 5.0) == ("+" in name or "turned" in name) for name, value in off.items())
assert all(value < 0.01 for name, value in off.items() if name in ("wave", "Perlin", "tiles"))
# The same ground twice: twice the height, the normal of once, and so the force of the engine.
x, y = max(points, key=lambda point: angle(query(wave, *point)[1], np.array([0.0, 0.0, 1.0])))
twice = grounds["wave + wave"]
up = np.array([0.0, 0.0, 1.0])
print(f"steepest: slope of the wave {angle(by_difference(wave, x, y), up):.1f} degrees, of twice the wave "
      f"{angle(by_difference(twice, x, y), up):.1f}, its force {angle(pushed(twice, x, y), up):.1f} from upright")
assert np.isclose(query(twice, x, y)[0], 2.0 * query(wave, x, y)[0])
assert np.allclose(pushed(wave, x, y), by_difference(wave, x, y), atol=1e-5)
assert np.allclose(pushed(twice, x, y), by_difference(wave, x, y), atol=1e-5)
assert angle(pushed(twice, x, y), by_difference(twice, x, y)) > 10.0
PY
