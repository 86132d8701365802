from collections.abc import Sequence

from gaitopt.nlp import Array, Indices

class Bodies:
    def __init__(
        self,
        parents: Sequence[int],
        foot: int,
        placements: Array,
        axes: Array,
        inertias: Array,
        armature: Array,
        gravity: Array,
    ) -> None: ...
    def inverse_dynamics(
        self, q: Array, dq: Array, ddq: Array, derivatives: bool
    ) -> tuple[Array, Array, Array, Array]: ...
    def placed(self, q: Array) -> Array: ...

def nearest(
    frames: Array, carriers: Indices, segments: Array, sides: Indices, squares: Array
) -> Array: ...
