"""Whether a robot has the size of one that walks: a wrong unit passes every other check."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.report import Finding
from gaitopt.model.chain import RootedChain
from gaitopt.model.sole import Sole

# Between a toy and an excavator: a unit that is wrong is wrong by a thousand, and falls outside.
_REACH = (0.1, 5.0)  # m, from hip to ankle
_MASS = (0.5, 1000.0)  # kg
# Radius of gyration of a leg's body per length of the leg. A rod as long as the leg has 0.29, a
# drawing with generous inertias 1.1; lumps of a few millimetres have 0.01.
_GYRATION = (1e-3, 3.0)


def size_doubts(chain: RootedChain, reach: float, sole: Sole, height: float) -> list[Finding]:
    """Return what is larger or smaller than in any robot that walks.

    Args:
        chain: the robot.
        reach: length of its legs from hip to ankle [m].
        sole: of either foot.
        height: of the ankles above the soles [m].

    Raises:
        RobotError: the sole is longer or wider than the legs.
    """
    _check_sole(sole, reach)
    findings = []
    if height < 0.0:
        text = (
            f"the soles lie {-1e3 * height:.1f} mm above the ankles, where no foot has its own; "
            "has the place of their shapes the wrong sign?"
        )
        findings.append(Finding("sole", "both feet", text, "warning"))
    if not _REACH[0] <= reach <= _REACH[1]:
        text = (
            f"the legs are {reach:.4g} m long from hip to ankle; {_REACH[0]:g} to {_REACH[1]:g} m "
            f"are plausible; {_question('lengths', reach, _REACH, {'mm': 1e-3, 'cm': 1e-2})}"
            "They must be in m"
        )
        findings.append(Finding("legs", "both legs", text, "warning"))
    mass = float(pin.computeTotalMass(chain.model))
    if not _MASS[0] <= mass <= _MASS[1]:
        text = (
            f"the robot weighs {mass:.4g} kg; {_MASS[0]:g} to {_MASS[1]:g} kg are plausible; "
            f"{_question('masses', mass, _MASS, {'g': 1e-3})}They must be in kg"
        )
        findings.append(Finding("mass", "robot", text, "warning"))
    # A wrong unit of length or mass makes every radius of gyration look wrong as well.
    return findings or _gyration_doubts(chain, reach)


def _question(
    what: str, value: float, plausible: tuple[float, float], units: dict[str, float]
) -> str:
    """Return the question whether numbers are in a unit in which they would be plausible."""
    least, most = plausible
    fits = [unit for unit, size in units.items() if least <= value * size <= most]
    return f"are {what} of the file in {fits[0]}? " if fits else ""


def _check_sole(sole: Sole, reach: float) -> None:
    length, width = sole.length, sole.width
    if max(length, width) > reach:
        raise RobotError(
            f"the sole is {length:.4g} m long and {width:.4g} m wide, but the legs measure only "
            f"{reach:.4g} m from hip to ankle; no foot is larger than its leg. Give all lengths in "
            "m, not in mm: in the URDF, and for the sole (toe, heel, left, right)"
        )


def _gyration_doubts(chain: RootedChain, reach: float) -> list[Finding]:
    """Look at the bodies of the swing leg; those of the other one are their mirror images."""
    small, large = [], []
    for name in chain.names[chain.tree.stance :]:
        body = chain.model.inertias[chain.model.getJointId(name)]
        if not body.mass > 0.0:
            continue
        moment = max(float(np.linalg.eigvalsh(body.inertia)[-1]), 0.0)
        radius = float(np.sqrt(moment / body.mass))
        if radius < _GYRATION[0] * reach:
            small.append((name, moment, radius))
        elif radius > _GYRATION[1] * reach:
            large.append((name, moment, radius))
    least, most = (1e3 * limit * reach for limit in _GYRATION)
    return [
        *_told(small, f"below {least:.2g} mm is implausible; are inertias left out of the file?"),
        *_told(large, f"above {most:.4g} mm is implausible; are they in g·m² or kg·mm²?"),
    ]


def _told(bodies: list[tuple[str, float, float]], text: str) -> list[Finding]:
    if not bodies:
        return []
    name, moment, radius = bodies[0]
    told = (
        f"the link that '{name}' moves has moments of inertia up to {moment:.3g} kg·m², a radius "
        f"of gyration of {1e3 * radius:.4g} mm; {text} They must be in kg·m²"
    )
    others = len(bodies) - 1
    subject = name if others == 0 else f"{name} and {others} more of each leg"
    return [Finding("inertia", subject, told, "warning")]
