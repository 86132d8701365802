from collections.abc import Sequence

from gaitopt.nlp import Array, Indices

SOURCES: int

class Bodies:
    def __init__(
        self,
        parents: Sequence[int],
        foot: int,
        placements: Array,
        axes: Array,
        inertias: Array,
        frames: Array,
        armature: Array,
        gravity: Array,
    ) -> None: ...
    def inverse_dynamics(
        self, q: Array, dq: Array, ddq: Array, derivatives: bool
    ) -> tuple[Array, Array, Array, Array]: ...
    def inverse_dynamics_hessian(
        self, q: Array, dq: Array, ddq: Array, base: Array, weights: Array
    ) -> tuple[Array, Array, Array, Array, Array]: ...
    def placed(self, q: Array) -> Array: ...
    def foot_points(self, frames: Array, axes: Array, points: Array) -> tuple[Array, Array]: ...
    def close_legs(
        self, q: Array, targets: Array, steps: int, last: float, largest: float
    ) -> tuple[Array, bool]: ...

def corner_hessian(axes: Array, jacobian: Array, weights: Array) -> Array: ...
def nearest(
    frames: Array, carriers: Indices, segments: Array, sides: Indices, squares: Array
) -> Array: ...

class Placing:
    def __init__(
        self,
        counts: Sequence[int],
        turns: Sequence[bool],
        quantities: Sequence[int],
        facts: Array,
        hips: Array,
        ankles: Array,
    ) -> None: ...
    def at(self, geometry: Array) -> tuple[Array, Array, Array, Array, Array]: ...

def support_slopes(
    pelvis_axes: Array,
    pelvis_drive: Array,
    sole_axes: Array,
    sole_drive: Array,
    points: Array,
    joint_axes: Array,
) -> tuple[Array, Array]: ...
def support_hessian(
    pelvis_axes: Array,
    pelvis_drive: Array,
    sole_axes: Array,
    sole_drive: Array,
    points: Array,
    joint_axes: Array,
    rates: Array,
    q_weights: Array,
    leg_weights: Array,
) -> Array: ...

class Landing:
    def __init__(
        self,
        robot: Bodies,
        motors: Sequence[int],
        slopes: Array,
        line: Array | None,
    ) -> None: ...
    def impact(
        self, angles: Array, rate: Array, twist: Array | None, derivatives: bool
    ) -> tuple[Array, Array, Array, Array, Array, Array]: ...
    def hessian(
        self,
        velocity: Array,
        impulse: Array,
        inputs: Array,
        axes: Array,
        frame: Array,
        adjoint: Array,
        qq: Array,
        qa: Array,
        base: Array,
    ) -> Array: ...

class LinearRows:
    def add(
        self,
        number: int,
        quantities: Sequence[int],
        widths: Sequence[int],
        instants: Indices,
        matrix: Array,
    ) -> None: ...
    def of(self, quantities: Sequence[Array], found: Array, number: int = 0) -> None: ...
