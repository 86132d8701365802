"""A plugin with a constraint: the swing foot stays below a height."""

from dataclasses import dataclass

from gaitopt.gait import quantities
from gaitopt.gait.constraint import Constraint, margin
from gaitopt.gait.functions import Entries


@dataclass(frozen=True)
class LowSwing(Constraint):
    """The corners of the swing foot stay below a height."""

    name, equation, unit, words = "low swing", "own", "m", "height of the swing foot"
    reads = (quantities.CORNERS,)
    low_swing: float = margin(
        0.06, "Largest height of the swing foot.", "the largest height of the swing foot", "m",
        above=0.0, relax=(0.5, 0.1),
    )  # fmt: skip

    def block(self, context):
        labels = [name for name in quantities.CORNERS.entries if name.endswith("z")]
        heights = Entries(slice(2, 12, 3), 12)
        return self.over_step(context, heights, tuple(labels), upper=self.low_swing, scale=0.1)


constraints = (LowSwing(),)
