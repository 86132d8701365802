"""Which lift-off limits a solver is asked to keep, one run after the other."""


def watched_liftoff_limits(monkeypatch, solver):
    """Return a list that grows by the limit [m/s] of every walk that a class of solvers solves."""
    limits, solve = [], solver.solve

    def watched(self, nlp, start, on_progress=None, stop=None):
        limits.append(nlp.task.margins.liftoff_speed)
        return solve(self, nlp, start, on_progress, stop)

    monkeypatch.setattr(solver, "solve", watched)
    return limits
