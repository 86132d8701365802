"""What a biped looks like: primitives that grow with its specification. Mass plays no part here."""

from __future__ import annotations

from gaitopt.robot.generated.shapes import Shape, box, cylinder, sphere
from gaitopt.robot.generated.spec import BipedSpec


def torso_shapes(spec: BipedSpec) -> list[Shape]:
    """Return pelvis, waist, chest, shoulders and head, as high and as wide as the torso's box."""
    depth, width, tall = spec.links.torso.size
    # A torso that hangs below the hips is odd but allowed; it still needs something to draw.
    height = max(spec.standing_height - spec.geometry.hip_height, 0.5 * tall)
    return [
        *_pelvis(spec, depth, height),
        *_chest(depth, width, height),
        *_shoulders(depth, width, height),
        *_head(depth, height),
    ]


def _pelvis(spec: BipedSpec, depth: float, height: float) -> list[Shape]:
    hip = spec.links.hip_yaw.size
    wide = spec.geometry.d7 + hip[1]
    low = 0.7 * hip[2]
    return [
        box((0.55 * depth, wide, 0.10 * height), (0.0, 0.0, low + 0.05 * height), "shell"),
        box((0.70 * depth, 0.7 * wide, 0.06 * height), (0.0, 0.0, low + 0.05 * height), "dark"),
        cylinder("z", 0.24 * depth, 0.14 * height, (0.0, 0.0, low + 0.17 * height), "metal"),
        cylinder("z", 0.29 * depth, 0.02 * height, (0.0, 0.0, low + 0.14 * height), "dark"),
        cylinder("z", 0.29 * depth, 0.02 * height, (0.0, 0.0, low + 0.18 * height), "dark"),
    ]


def _chest(depth: float, width: float, height: float) -> list[Shape]:
    front = 0.43 * depth
    return [
        box((0.62 * depth, 0.56 * width, 0.10 * height), (0.0, 0.0, 0.35 * height), "shell"),
        box((0.72 * depth, 0.68 * width, 0.08 * height), (0.0, 0.0, 0.43 * height), "shell"),
        box((0.80 * depth, 0.76 * width, 0.24 * height), (0.0, 0.0, 0.57 * height), "shell"),
        box((0.60 * depth, 0.66 * width, 0.04 * height), (0.0, 0.0, 0.71 * height), "shell"),
        box((0.10 * depth, 0.50 * width, 0.17 * height), (front, 0.0, 0.57 * height), "dark"),
        cylinder("x", 0.11 * depth, 0.12 * depth, (front, 0.0, 0.58 * height), "metal"),
        cylinder("x", 0.08 * depth, 0.13 * depth, (front, 0.0, 0.58 * height), "light"),
        box(
            (0.20 * depth, 0.52 * width, 0.26 * height), (-0.45 * depth, 0.0, 0.54 * height), "dark"
        ),
    ]


def _shoulders(depth: float, width: float, height: float) -> list[Shape]:
    shapes = [cylinder("y", 0.16 * depth, 0.92 * width, (0.0, 0.0, 0.62 * height), "metal")]
    for side, y in (("left", 0.46 * width), ("right", -0.46 * width)):
        shapes.append(sphere(0.25 * depth, (0.0, y, 0.62 * height), side))
        shapes.append(cylinder("y", 0.18 * depth, 0.40 * depth, (0.0, y, 0.62 * height), "dark"))
    return shapes


def _head(depth: float, height: float) -> list[Shape]:
    radius = 0.34 * depth
    centre = height - radius
    return [
        cylinder("z", 0.15 * depth, 0.12 * height, (0.0, 0.0, 0.75 * height), "dark"),
        cylinder("z", 0.24 * depth, 0.02 * height, (0.0, 0.0, 0.74 * height), "metal"),
        sphere(radius, (0.0, 0.0, centre), "shell"),
        sphere(0.84 * radius, (0.26 * radius, 0.0, centre), "dark"),
        cylinder("y", 0.40 * radius, 2.10 * radius, (-0.10 * radius, 0.0, centre), "metal"),
        *(
            sphere(0.15 * radius, (0.96 * radius, y, centre + 0.10 * radius), "light")
            for y in (0.36 * radius, -0.36 * radius)
        ),
    ]


def leg_shapes(spec: BipedSpec, side: str, sign: float) -> dict[str, list[Shape]]:
    """Return the shapes of one leg by link name without the side.

    Args:
        spec: the biped.
        side: "left" or "right"; also the colour of the leg's covers.
        sign: of y on that side.
    """
    return {
        "hip_yaw_link": _hip_yaw(spec),
        "hip_roll_link": _hip_roll(spec),
        "thigh": _thigh(spec, side, sign),
        "shin": _shin(spec, side),
        "ankle": _ankle(spec),
        "foot": _foot(spec, side),
    }


def _hip_yaw(spec: BipedSpec) -> list[Shape]:
    x, y, z = spec.links.hip_yaw.size
    return [
        cylinder("z", 0.42 * y, 0.35 * z, (0.0, 0.0, 0.62 * z), "dark"),
        cylinder("z", 0.34 * y, 0.12 * z, (0.0, 0.0, 0.42 * z), "metal"),
        box((0.12 * x, 0.60 * y, 0.80 * z), (-0.66 * x, 0.0, 0.05 * z), "metal"),
        box((0.72 * x, 0.60 * y, 0.10 * z), (-0.36 * x, 0.0, 0.42 * z), "metal"),
    ]


def _hip_roll(spec: BipedSpec) -> list[Shape]:
    x, y, z = spec.links.hip_roll.size
    return [
        cylinder("x", 0.36 * z, 1.20 * x, (0.0, 0.0, 0.0), "dark"),
        cylinder("x", 0.24 * z, 1.30 * x, (0.0, 0.0, 0.0), "metal"),
        box((0.60 * x, 0.50 * y, 0.60 * z), (0.0, 0.0, 0.0), "metal"),
    ]


def _thigh(spec: BipedSpec, side: str, sign: float) -> list[Shape]:
    x, y, _ = spec.links.thigh.size
    knee, out = -spec.geometry.d4, sign * spec.geometry.l4
    length = -knee
    return [
        cylinder("y", 0.42 * x, 0.90 * y + abs(out), (0.0, 0.5 * out, 0.0), "dark"),
        cylinder("y", 0.28 * x, 1.00 * y + abs(out), (0.0, 0.5 * out, 0.0), "metal"),
        box((0.70 * x, 0.78 * y, 0.50 * length), (0.0, out, 0.42 * knee), "shell"),
        box((0.90 * x, 0.56 * y, 0.44 * length), (0.0, out, 0.40 * knee), "shell"),
        box((0.10 * x, 0.44 * y, 0.34 * length), (0.45 * x, out, 0.40 * knee), side),
        box((0.56 * x, 0.10 * y, 0.30 * length), (0.0, out + sign * 0.39 * y, 0.42 * knee), side),
        box((0.60 * x, 0.62 * y, 0.24 * length), (0.0, out, 0.74 * knee), "shell"),
        cylinder("z", 0.24 * x, 0.30 * length, (0.0, out, 0.84 * knee), "dark"),
        cylinder("y", 0.36 * x, 0.46 * y, (0.0, out, knee), "dark"),
    ]


def _shin(spec: BipedSpec, side: str) -> list[Shape]:
    x, y, _ = spec.links.shin.size
    length = spec.geometry.d3
    return [
        *(
            cylinder("y", 0.50 * x, 0.16 * y, (0.0, side_sign * 0.40 * y, 0.0), "shell")
            for side_sign in (1.0, -1.0)
        ),
        cylinder("y", 0.26 * x, 1.02 * y, (0.0, 0.0, 0.0), side),
        box((0.60 * x, 0.96 * y, 0.22 * length), (0.0, 0.0, -0.20 * length), "shell"),
        box((0.80 * x, 0.72 * y, 0.40 * length), (-0.06 * x, 0.0, -0.36 * length), "shell"),
        box((0.10 * x, 0.46 * y, 0.40 * length), (0.36 * x, 0.0, -0.36 * length), side),
        box((0.58 * x, 0.60 * y, 0.24 * length), (0.0, 0.0, -0.64 * length), "shell"),
        cylinder("z", 0.22 * x, 0.30 * length, (0.0, 0.0, -0.82 * length), "dark"),
    ]


def _ankle(spec: BipedSpec) -> list[Shape]:
    x, y, z = spec.links.ankle.size
    return [
        cylinder("y", 0.50 * z, 0.90 * y, (0.0, 0.0, 0.0), "dark"),
        cylinder("y", 0.32 * z, 1.05 * y, (0.0, 0.0, 0.0), "metal"),
        cylinder("x", 0.30 * z, 1.30 * x, (0.0, 0.0, 0.0), "metal"),
    ]


def _foot(spec: BipedSpec, side: str) -> list[Shape]:
    geometry, height = spec.geometry, spec.links.foot.size[2]
    long, wide = geometry.foot_length, geometry.foot_width
    sole, toe = -geometry.d1, -geometry.l1
    ankle_gap = max(geometry.d1 - height, 0.1 * geometry.d1)
    return [
        box((long, wide, 0.3 * height), (toe - 0.5 * long, 0.0, sole + 0.15 * height), "rubber"),
        box((0.90 * long, 0.90 * wide, 0.5 * height),
            (toe - 0.52 * long, 0.0, sole + 0.55 * height), "shell"),
        box((0.24 * long, 0.80 * wide, 0.3 * height),
            (toe - 0.20 * long, 0.0, sole + 0.75 * height), side),
        box((0.55 * long, 0.70 * wide, 0.4 * height),
            (toe - 0.62 * long, 0.0, sole + 0.95 * height), "shell"),
        *(
            box((0.12 * long, 0.34 * wide, ankle_gap), (x, 0.0, -0.5 * ankle_gap), "metal")
            for x in (0.26 * long, -0.26 * long)
        ),
    ]  # fmt: skip
