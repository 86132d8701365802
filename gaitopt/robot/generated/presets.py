"""Robots that come with gaitopt."""

from __future__ import annotations

from gaitopt.robot.generated.spec import BipedSpec, Geometry, JointLimits, Joints, Links, LinkSpec


def biped13() -> BipedSpec:
    """Return the thirteen-link biped of the paper's Tables 1 and 2: 56.87 kg, 1.30 m tall.

    Lengths, masses and sole size are the paper's. It leaves open the inertias (here homogeneous
    boxes), l1 and l4, how the 2.04 kg of a hip divide over its two links (here equally), and the
    limits of the motors (here 150 N·m and 10 rad/s, and ranges wider than a walk needs).
    """
    return BipedSpec(
        name="biped13",
        geometry=Geometry(
            l1=-0.137, d1=0.105, d3=0.3, d4=0.3, l4=0.0, d7=0.12, foot_length=0.214,
            foot_width=0.136,
        ),
        links=_links(),
        joints=_joints(),
    )  # fmt: skip


def _links() -> Links:
    hip = LinkSpec(mass=1.02, size=(0.08, 0.08, 0.08), com=(0.0, 0.0, 0.0))
    return Links(
        torso=LinkSpec(mass=40.55, size=(0.2, 0.3, 0.595), com=(0.0, 0.0, 0.2975)),
        hip_yaw=hip,
        hip_roll=hip,
        thigh=LinkSpec(mass=2.08, size=(0.1, 0.1, 0.3), com=(0.0, 0.0, -0.15)),
        shin=LinkSpec(mass=1.75, size=(0.08, 0.08, 0.3), com=(0.0, 0.0, -0.15)),
        ankle=LinkSpec(mass=0.65, size=(0.06, 0.06, 0.06), com=(0.0, 0.0, 0.0)),
        foot=LinkSpec(mass=1.64, size=(0.214, 0.136, 0.04), com=(0.03, 0.0, -0.085)),
    )


def _joints() -> Joints:
    def limits(lower: float, upper: float) -> JointLimits:
        return JointLimits(torque=150.0, speed=10.0, lower=lower, upper=upper)

    return Joints(
        hip_yaw=limits(-1.0, 1.0),
        hip_roll=limits(-0.8, 0.8),
        hip_pitch=limits(-2.2, 1.2),
        knee=limits(0.0, 2.6),
        ankle_pitch=limits(-2.2, 1.2),
        ankle_roll=limits(-1.5, 1.5),
    )
