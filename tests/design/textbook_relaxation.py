"""A program without a solution: x >= 1 and x <= -1."""

import numpy as np

from gaitopt.nlp import NLP, Point, Rows, Values, Variables

INFINITY = np.inf


class Line(NLP):
    """One variable that should be on both sides."""

    def __init__(self) -> None:
        self.variables = Variables(("x",), np.full(1, -INFINITY), np.full(1, INFINITY), np.ones(1))
        self.rows = Rows(np.array([1.0, -INFINITY]), np.array([INFINITY, -1.0]))
        self.cost_scale, self.has_hessian = 1.0, True

    def values(self, x):
        return Values(x, 0.0, np.array([x[0], x[0]]))

    def point(self, x):
        return Point(x, 0.0, np.array([x[0], x[0]]), np.zeros(1), np.ones((2, 1)))

    def hessian(self, x, multipliers, cost_weight):
        return np.zeros((1, 1))

    def describe(self, row):
        return ("x from below", "x from above")[row]
