#!/usr/bin/env bash
# Version:  exudyn 1.13.6 with numpy 2.4.6
# Does:     Robot.GetKinematicTree66 ("export kinematicTree") hands the tree neither the parents of the links nor the pose
#           of the base. The tree then takes what it takes without a list of parents: each link hangs on the one before, so the
#           second leg of a biped hangs on the first one's foot; and gravity pulls along the base's own axis. The Robot's own
#           StaticTorques and Jacobian, and a KinematicTree66 that is given the parents, are right. Nothing is said.
# Guess:    what is exported is the same robot; the class takes parents, and the robot has them.
# Means:    mass matrix, gravity and forward dynamics of anything with two legs or arms are those of one long arm; a chain on an
#           upright base is right, and that is what the examples have. Pass listOfParents yourself, and turn gravity into
#           the base. (CreateKinematicTree, the other export, says that it works for serial robots only and does pass
#           the parents.) No report was found.
# Seen:     trunk and two legs of thigh and shin, straight: inertia about the hips 0.90 kg·m² by hand and with the parents
#           0.90 and 0.90, exported 4.04 and 0.90, the two hips coupled by 1.62 instead of 0. Bent: gravity torque of the hip of the
#           first leg -6.9 N·m by StaticTorques and by hand, -21.3 exported. One leg on a base turned by a quarter:
#           hip -15.9 and -6.9 N·m, knee alike to 3 % by chance
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check exudyn==1.13.6 numpy==2.4.6 2>/dev/null
cd "$work"
"$work/env/bin/python" - <<'PY'
import exudyn.kinematicTree as trees
import exudyn.rigidBodyUtilities as bodies
import exudyn.robotics as robotics
import numpy as np

GRAVITY = [0.0, 0.0, -9.81]
THIGH, SHIN, LENGTH, MOMENT = 3.0, 2.0, 0.4, 0.03  # [kg], [kg], [m], about each centre, half way down [kg m^2]
LINKS = [  # joint, place in the parent, mass, centre of mass, parent
    ("Rz", [0.0, 0.0, 0.0], 10.0, [0.0, 0.0, 0.2], -1),
    ("Ry", [0.0, 0.1, 0.0], THIGH, [0.0, 0.0, -LENGTH / 2], 0),
    ("Ry", [0.0, 0.0, -LENGTH], SHIN, [0.0, 0.0, -LENGTH / 2], 1),
    ("Ry", [0.0, -0.1, 0.0], THIGH, [0.0, 0.0, -LENGTH / 2], 0),
    ("Ry", [0.0, 0.0, -LENGTH], SHIN, [0.0, 0.0, -LENGTH / 2], 3),
]


def robot(links, base):
    made = robotics.Robot(gravity=GRAVITY, base=robotics.RobotBase(HT=base))
    for kind, place, mass, centre, parent in links:
        made.AddLink(robotics.RobotLink(mass=mass, COM=centre, inertia=np.diag([MOMENT, MOMENT, 0.01]), jointType=kind,
                                        preHT=bodies.HTtranslate(place), parent=parent))
    return made


def gravity(tree, q):
    return tree.ComputeMassMatrixAndForceTerms(q, 0 * q)[1]


biped = robot(LINKS, bodies.HT0())
assert not biped.IsSerialRobot() and [biped.GetParentIndex(i) for i in range(5)] == [link[4] for link in LINKS]
exported = biped.GetKinematicTree66()
right = trees.KinematicTree66(exported.jointTypes, exported.transformations, exported.inertias,
                              listOfParents=[link[4] for link in LINKS], gravity=GRAVITY)
straight = np.zeros(5)
by_hand = THIGH * (LENGTH / 2) ** 2 + SHIN * (LENGTH * 1.5) ** 2 + 2 * MOMENT
for name, tree in (("with parents", right), ("exported", exported)):
    M = tree.ComputeMassMatrixAndForceTerms(straight, straight)[0]
    print(f"{name}: hips {M[1, 1]:.4f} and {M[3, 3]:.4f} kg·m² (by hand {by_hand:.4f}), coupled by {M[1, 3]:.4f} (0)")
    assert np.isclose(M[3, 3], by_hand)
    assert np.isclose(M[1, 1], by_hand) == (name == "with parents") == (abs(M[1, 3]) < 1e-12)
q = np.array([0.2, 0.3, 0.5, -0.4, 0.6])
own = biped.StaticTorques(biped.JointHT(q))
print("gravity: robot", own.round(3), "with parents", -gravity(right, q).round(3), "exported", -gravity(exported, q).round(3))
pull = 9.81 * LENGTH * np.sin([q[1], q[1] + q[2]]) @ [THIGH / 2 + SHIN, SHIN / 2]
assert np.allclose(own, -gravity(right, q)) and np.isclose(abs(own[1]), pull)
assert abs(own - -gravity(exported, q)).max() > 10.0
# A chain: right on an upright base, wrong on one that is turned.
leg = [(*LINKS[1][:4], -1), (*LINKS[2][:4], 0)]
for name, base, same in (("upright", bodies.HT0(), True), ("turned", bodies.HTrotateY(np.pi / 2), False)):
    one = robot(leg, base)
    own, told = one.StaticTorques(one.JointHT(q[1:3])), -gravity(one.GetKinematicTree66(), q[1:3])
    print(f"one leg, base {name}: robot {own.round(3)}, exported {told.round(3)}")
    assert np.allclose(own, told) == same
PY
