"""Joints that the equalities of an MJCF file tie to each other or to a place."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from gaitopt.robot.mjcf.motors import fixed_tendon

_NONE: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Tie:
    """An equality that holds from the start.

    Attributes:
        index: of the equality in the model.
        tag: of its element.
        ends: what it ties, in words.
        joints: of those it ties.
        loop: whether it closes a loop of bodies; else it makes joints follow each other.
    """

    index: int
    tag: str
    ends: str
    joints: frozenset[int]
    loop: bool


def ties_of(mujoco: ModuleType, model: Any) -> list[Tie]:
    """Return the equalities of an MjModel that are active.

    Two bodies that are connected tie all joints on the way from one to the other.
    """
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_EQUALITY):
        return []
    kinds, ties = mujoco.mjtEq, []
    for index in range(model.neq):
        if not model.eq_active0[index]:
            continue
        kind = int(model.eq_type[index])
        ends = [int(model.eq_obj1id[index]), int(model.eq_obj2id[index])]
        if kind == kinds.mjEQ_JOINT:
            tag, what, known = "joint", "joint", [frozenset({end}) for end in ends if end >= 0]
            joints = _NONE.union(*known)
        elif kind == kinds.mjEQ_TENDON:
            tag, what = "tendon", "tendon"
            joints = _NONE.union(*(_tendon(mujoco, model, end) for end in ends if end >= 0))
        elif kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            tag = "connect" if kind == kinds.mjEQ_CONNECT else "weld"
            site = int(model.eq_objtype[index]) == mujoco.mjtObj.mjOBJ_SITE
            what = "site" if site else "body"
            bodies = [int(model.site_bodyid[end]) if site else end for end in ends]
            joints = _between(model, bodies)
        else:
            continue
        names = [str(getattr(model, what)(end).name) for end in ends if end >= 0]
        words = " and ".join(f"'{name}'" for name in names if what != "body" or name != "world")
        ties.append(Tie(index, tag, words, joints, tag in ("connect", "weld")))
    return ties


def _carriers(model: Any, body: int) -> frozenset[int]:
    """Return the joints between a body and the world."""
    joints: set[int] = set()
    while body > 0:
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        joints.update(range(first, first + count))
        body = int(model.body_parentid[body])
    return frozenset(joints)


def _between(model: Any, bodies: Collection[int]) -> frozenset[int]:
    """Return the joints on the way between bodies."""
    carriers = [_carriers(model, body) for body in bodies]
    return _NONE.union(*carriers) - carriers[0].intersection(*carriers)


def _tendon(mujoco: ModuleType, model: Any, tendon: int) -> frozenset[int]:
    """Return the joints that change the length of a tendon."""
    joints = fixed_tendon(mujoco, model, tendon)
    if joints:
        return frozenset(joints)
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    sites = [
        int(model.wrap_objid[w])
        for w in range(first, first + count)
        if int(model.wrap_type[w]) == mujoco.mjtWrap.mjWRAP_SITE
    ]
    return _between(model, [int(model.site_bodyid[s]) for s in sites]) if sites else _NONE
