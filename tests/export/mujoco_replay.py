"""A robot's file as MuJoCo compiles it, without shapes, its bodies weighing what a walk had."""

from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from gaitopt.gait.result import Gait
from gaitopt.motions.motion import Motion


def compiled(gait: Gait) -> mujoco.MjModel:
    """The model of a gait's URDF on a free joint, no body fused but by what MuJoCo does itself."""
    root = ET.fromstring(gait.urdf)
    if root.tag == "mujoco":
        model = mujoco.MjModel.from_xml_string(gait.urdf)
    else:
        for link in root.findall("link"):
            for part in (*link.findall("visual"), *link.findall("collision")):
                link.remove(part)
        settings = ET.SubElement(root, "mujoco")
        limits = {"balanceinertia": "true", "boundmass": "1e-9", "boundinertia": "1e-12"}
        ET.SubElement(settings, "compiler", limits)
        base = gait.trajectory.body.base
        ET.SubElement(root, "link", name="ground")
        joint = ET.SubElement(root, "joint", name="floating", type="floating")
        ET.SubElement(joint, "parent", link="ground")
        ET.SubElement(joint, "child", link=base)
        model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    model.opt.gravity[:] = [0.0, 0.0, -np.linalg.norm(gait.trajectory.body.gravity)]
    return model


def weigh_as_designed(model: mujoco.MjModel, motion: Motion) -> None:
    """Give bodies the inertias, and springs the rest, to which the sides were averaged."""
    body = motion.body
    for index, name in zip(motion.bodies, motion.body_names, strict=True):
        row = model.body(name).id
        if not body.mass[index]:  # a root without mass: MuJoCo needs the speck that it gave it
            continue
        moments, axes = np.linalg.eigh(body.inertia[index])
        axes[:, 0] *= np.sign(np.linalg.det(axes))
        model.body_mass[row] = body.mass[index]
        model.body_ipos[row] = body.centre[index]
        model.body_inertia[row] = moments
        mujoco.mju_mat2Quat(model.body_iquat[row], np.ascontiguousarray(axes).ravel())
    model.dof_armature[6:] = body.armature[list(motion.rows)]
    model.qpos_spring[7:] = body.rest[list(motion.rows)]
    mujoco.mj_setConst(model, mujoco.MjData(model))


def joint_order(model: mujoco.MjModel) -> list[str]:
    """Names of the joints behind the free one."""
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
    return [model.joint(k).name for k in range(1, model.njnt)]
