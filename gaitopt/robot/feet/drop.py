"""Whether the height of the ankle that a user measured is that of the feet's shapes."""

from __future__ import annotations

from gaitopt.robot.feet.rectangles import Rectangle
from gaitopt.robot.findings import Finding
from gaitopt.robot.legs.stance import Stance

_MEASURED = 5e-3  # m: what a tape measure may be wrong by


def drop_doubts(stance: Stance, face: Rectangle | None, given: float | None) -> list[Finding]:
    """Compare the given height of the ankle above the sole with that of the shapes.

    Args:
        stance: the robot at its reference posture.
        face: lower face of the feet in the pelvis frame, None where they have no shape.
        given: height that the user gives, None if none [m].
    """
    if given is None or face is None:
        return []
    seen = float(stance.ankles[:, 2].mean() - face.height)
    if abs(given - seen) <= _MEASURED:
        return []
    text = (
        f"sole_drop is {given * 1e3:.1f} mm as given, but the lower faces of the feet were found "
        f"{seen * 1e3:.1f} mm below the ankles; the given one counts; check it, it must be in m"
    )
    return [Finding("sole", "both feet", text, "warning")]
