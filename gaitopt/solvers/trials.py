"""Steps of the SQP method tried: the program at their ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.nlp import NLP
from gaitopt.solvers.acceptance import Trial, judge
from gaitopt.solvers.elastic import ElasticStep
from gaitopt.solvers.evaluator import Evaluator
from gaitopt.solvers.model import LocalModel
from gaitopt.solvers.multipliers import bound_multipliers
from gaitopt.solvers.recorder import Iterate, make_iterate


@dataclass
class Trials:
    """Tries steps for one run.

    Attributes:
        nlp: the program.
        evaluator: of it; every evaluation counts.
        undefined: whether the program had no value at the last point asked for.
    """

    nlp: NLP
    evaluator: Evaluator
    undefined: bool = False

    def at_end(
        self, iterate: Iterate, model: LocalModel, step: ElasticStep, judged: ElasticStep
    ) -> Trial | None:
        """Evaluate a step; its predicted decrease is that of `judged`. None if undefined there."""
        variables = self.nlp.variables
        x = np.clip(iterate.point.x + variables.scale * step.d, variables.lower, variables.upper)
        try:
            values = self.evaluator.values(x)
        except EvaluationError:
            self.undefined = True
            return None
        self.undefined = False
        return judge(self.nlp, iterate, model, step, judged, values)

    def with_derivatives(self, iterate: Iterate, trial: Trial, radius: float) -> Iterate | None:
        """Return a trial of a step from an iterate with its derivatives, None if it has none."""
        try:
            point = self.evaluator.point(trial.values.x)
        except EvaluationError:
            self.undefined = True
            return None
        held = bound_multipliers(
            self.nlp.variables, iterate.point.x, trial.step.box_multipliers, radius
        )
        return make_iterate(self.nlp, point, trial.step.multipliers, held)
