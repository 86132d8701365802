from dataclasses import replace
from itertools import pairwise

from gaitopt.design.active_set import active_rows, violated_rows
from gaitopt.design.certificate import certify, on_fine_grid
from gaitopt.design.refinement import exchange, pruned
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Start
from gaitopt.solvers import SQP
from gaitopt.tolerances import LIMITS

SOLVER = SQP()


def rounds_of(sampled_design):
    problem = WalkProblem(sampled_design.problem.robot, sampled_design.problem.task)
    solution, fine = sampled_design.solution, on_fine_grid(problem)
    active = active_rows(problem, solution.multipliers)
    peaks = violated_rows(fine, solution.x)
    return problem, fine, list(exchange(problem, solution.x, active, SOLVER.solve, fine, peaks))


def test_round_after_round_the_cost_rises_until_no_limit_is_exceeded(sampled_design):
    _, fine, found = rounds_of(sampled_design)
    costs = [sampled_design.solution.cost, *(solution.cost for _, solution, _ in found)]
    assert len(found) >= 2
    assert costs == sorted(costs)
    assert all(violated_rows(fine, solution.x) for _, solution, _ in found[:-1])
    assert not violated_rows(fine, found[-1][1].x)


def test_what_is_exceeded_falls_faster_than_by_halving_distances(robot, standard_task):
    """At this speed limits press between two instants; half of their distance leaves a quarter."""
    problem = WalkProblem(robot, replace(standard_task, speed=1.1))
    solution, fine = SOLVER.solve(problem, Start(first_guess(problem))), on_fine_grid(problem)
    active, peaks = active_rows(problem, solution.multipliers), violated_rows(fine, solution.x)
    left = [
        max((peak.excess for peak in violated_rows(fine, found.x)), default=0.0)
        for _, found, _ in exchange(problem, solution.x, active, SOLVER.solve, fine, peaks)
    ]
    assert left[0] > 0.0
    assert all(later <= earlier / 8.0 for earlier, later in pairwise(left))


def test_every_round_begins_near_its_end(sampled_design):
    """The multipliers were carried along: a few steps each."""
    _, _, found = rounds_of(sampled_design)
    assert all(solution.iterations <= 8 for _, solution, _ in found)


def test_what_does_not_press_can_be_left_out(sampled_design):
    sparse, fine, found = rounds_of(sampled_design)
    problem, solution, _ = found[-1]
    lean, kept = pruned(sparse, problem, solution)
    assert sparse.grid.count < lean.grid.count < problem.grid.count
    again = SOLVER.solve(lean, Start(kept.x, kept.multipliers))
    assert again.iterations <= 1
    assert certify(lean, kept.x, fine).worst.violation <= LIMITS
