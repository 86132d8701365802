"""Newton's method with moving instants: its curvature by differences, its end by the exchange."""

from dataclasses import replace

import numpy as np
import pytest

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design import refinement
from gaitopt.design.active_set import ActiveRow, active_rows, instants_of, placed, violated_rows
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import design
from gaitopt.design.extremes import located
from gaitopt.design.refinement import _at_extremes, _Held, _Stage, on_either_side, resting_walk
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Start
from gaitopt.solvers import SQP
from gaitopt.solvers.sqp import WARM_RADIUS
from gaitopt.solvers.subproblem import solve_subproblem
from gaitopt.tolerances import REFINED

SOLVER = SQP()


@pytest.fixture(scope="module")
def at_extremes(refined_design):
    """A walk at its samples, on its fine grid, its parameters and the rows at their extremes."""
    problem, solution = refined_design.problem, refined_design.solution
    sparse = WalkProblem(problem.robot, problem.task)
    fine = on_fine_grid(sparse)
    active = active_rows(problem, solution.multipliers)
    return sparse, fine, solution.x, active, _at_extremes(fine, located(fine, solution.x), active)


def margin(fine, x, row):
    """The least distance of a row to its limit near an instant."""
    alike = [
        one
        for one in located(fine, x)
        if (one.constraint, one.entry, one.upper) == (row.row.constraint, row.row.entry, row.upper)
    ]
    return min(alike, key=lambda one: abs(one.instant - row.row.instant)).margin


def test_the_hessian_of_a_row_at_its_extreme_is_that_of_differences(at_extremes):
    sparse, fine, x, _, held = at_extremes
    stage = _Stage(sparse, held)
    assert stage.step(x, SOLVER, np.inf) is not None
    step = 1e-3 * sparse.layout.scale() * np.random.default_rng(2).standard_normal(x.size)
    told = 0
    for one, slope in zip(stage.moving, stage.slopes, strict=True):
        multipliers = np.zeros(stage.problem.rows.lower.size)
        multipliers[stage._number(one.row)] = -1.0 if one.upper else 1.0
        bent = step @ stage.problem.hessian(x, multipliers, 0.0) @ step
        moving = (slope @ step) ** 2 / one.bend
        values = [margin(fine, x + k * step, one) for k in (-1.0, 0.0, 1.0)]
        found = values[0] - 2.0 * values[1] + values[2]
        assert found == pytest.approx(bent - moving, abs=0.03 * (abs(bent) + moving))
        told += moving > 0.2 * abs(bent)
    assert told >= 2  # rows for which a Hessian of fixed instants would be wrong


def test_a_neighbour_is_reached_with_its_instants(at_extremes):
    sparse, _, x, active, _ = at_extremes
    task = replace(sparse.task, speed=sparse.task.speed - 0.005)
    there = WalkProblem(sparse.robot, task)
    fine = on_fine_grid(there)
    found = resting_walk(there, fine, x, active, SOLVER)
    assert found is not None
    assert found.keeps
    assert not violated_rows(fine, found.x)
    instants = instants_of(there, found.active)
    problem = there.with_grid(there.grid.with_instants(instants))
    solution = SOLVER.solve(problem, Start(found.x, placed(problem, found.active)))
    assert solution.iterations <= 2
    assert not violated_rows(fine, solution.x)


def test_extremes_that_vanish_at_the_end_are_held_as_far_from_it_as_refinement_allows(at_extremes):
    _, fine, x, active, held = at_extremes
    nearest = {}
    for one in held:
        distance = np.abs(fine.edges - one.row.instant).min()
        if 0.0 < distance < 0.05:
            nearest[one.row.constraint, one.row.entry] = distance
    assert nearest
    closer = [
        replace(row, instant=1.0 - 1e-6 * (1 + row.entry)) if (row.constraint, row.entry) in nearest
        and 0.95 < row.instant < 1.0 else row
        for row in active
    ]  # fmt: skip
    again = _at_extremes(fine, located(fine, x), closer)
    bends = {e.constraint: e.curvature for e in located(fine, x) if abs(e.at_end) < REFINED}
    shared: dict[str, set[float]] = {}
    for one in again:
        distance = np.abs(fine.edges - one.row.instant).min()
        if 0.0 < distance < 0.05 and one.row.constraint in bends:
            assert distance > 1e-5
            shared.setdefault(one.row.constraint, set()).add(one.row.instant)
    assert len(closer) > len({row.instant for row in closer})
    assert shared
    assert all(len(instants) == 1 for instants in shared.values())


def test_held_on_either_side_of_its_instants_a_walk_is_the_same_optimum(at_extremes):
    sparse, fine, x, active, held = at_extremes
    rows = on_either_side(fine, x, active)
    moving = [one for one in held if one.bend > 0.0 and one.row.multiplier]
    assert len(moving) >= 2
    assert len(rows) == len(held) + len(moving)
    assert sum(row.multiplier for row in rows) == pytest.approx(
        sum(one.row.multiplier for one in held), rel=1e-12
    )
    for one in moving:  # what a parabola exceeds its limit by between two instants it is held at
        near = [
            row.instant for row in rows
            if (row.constraint, row.entry) == (one.row.constraint, one.row.entry)
            and abs(row.instant - one.row.instant) < 1e-2
        ]  # fmt: skip
        assert one.bend * (max(near) - min(near)) ** 2 / 8.0 == pytest.approx(0.5 * REFINED)
    problem = sparse.with_grid(sparse.grid.with_instants(instants_of(sparse, rows)))
    solution = SOLVER.solve(problem, Start(x, placed(problem, rows)))
    assert solution.iterations <= 2
    assert solution.cost == pytest.approx(sparse.values(x).cost, rel=1e-6)
    assert not violated_rows(fine, solution.x)


def test_rows_that_are_of_no_instant_keep_their_number(at_extremes):
    """A transition has such rows for each of its steps; a walk's are the first of their block."""
    sparse, _, x, _, held = at_extremes
    stage = _Stage(sparse, held)
    step = stage.step(x, SOLVER, np.inf)
    fourth = _Held(ActiveRow("impulse friction", 0, 3.0, 1.0), True)
    stage.held = (*held, fourth)
    stage.numbers = [*stage.numbers, stage._number(replace(fourth.row, instant=0.0))]
    _, after = stage.after(x, step)
    assert after[len(held)].row.instant == 3.0
    assert all(0.0 <= one.row.instant <= 1.0 for one in after[: len(held)])


def test_beside_an_end_a_limit_is_held_within_the_step(at_extremes, monkeypatch):
    _, fine, x, active, held = at_extremes
    flat = replace(held[0], row=replace(held[0].row, instant=2e-4, multiplier=1.0), bend=0.02)
    monkeypatch.setattr(refinement, "_at_extremes", lambda *_: (flat,))
    instants = [row.instant for row in on_either_side(fine, x, active)]
    assert instants == pytest.approx([0.0, 4e-4], abs=1e-9)


def test_where_nothing_is_near_none_is_found(at_extremes):
    sparse, _, x, active, _ = at_extremes
    there = WalkProblem(sparse.robot, replace(sparse.task, speed=0.5 * sparse.task.speed))
    assert resting_walk(there, on_fine_grid(there), x, active, SOLVER) is None


def test_a_walk_whose_programs_no_solver_answers_is_refined_soon():
    """Of `robust` at 0.6 m/s: 84 Hessians where such a program ended Newton's method."""
    robot = robot_by_name("biped13")
    found = design(robot, preset_task("robust", robot, speed=0.6))
    assert found.certificate.verdict == "certified"
    assert found.solution.hessians < 60


def test_steps_to_the_edge_of_the_region_are_no_way_to_a_minimum(at_extremes, monkeypatch):
    """Multipliers grow along them, until a program takes seconds."""
    sparse, fine, x, active, _ = at_extremes
    wanted, taken = _Stage.step, []

    def too_long(self, x, solver, last, first):
        step = wanted(self, x, solver, last, first)
        taken.append(step)
        edge = np.zeros(x.size)
        edge[0] = WARM_RADIUS
        return replace(step, d=edge, multipliers=np.zeros(step.multipliers.size))

    monkeypatch.setattr(_Stage, "step", too_long)
    monkeypatch.setattr(_Stage, "after", lambda self, x, step: (x, self.held))
    assert resting_walk(sparse, fine, x, active, SOLVER) is None
    assert len(taken) == 2


@pytest.mark.parametrize(("first", "programs"), [(False, 1), (True, 5)])
def test_a_step_that_leads_away_is_not_asked_to_keep_all_rows(
    at_extremes, monkeypatch, first, programs
):
    sparse, _, x, _, held = at_extremes
    stage, asked = _Stage(sparse, held), []

    def edge(posed, backend):
        asked.append(posed.gradient[-1])
        step = solve_subproblem(posed, backend)
        return replace(step, d=np.full(x.size, WARM_RADIUS), slack=1e-3)

    monkeypatch.setattr("gaitopt.design.refinement.solve_subproblem", edge)
    assert stage.step(x, SOLVER, np.inf, first).length == WARM_RADIUS
    assert len(asked) == programs


def test_where_nothing_presses_the_program_has_no_row_but_the_one_held(at_extremes):
    """Hundreds of extremes may be near their limits: with all rows there it had thousands."""
    sparse, *_, held = at_extremes
    stage = _Stage(sparse, [replace(one, row=replace(one.row, multiplier=0.0)) for one in held])
    quiet = {one.row.instant for one in held} - set(sparse.grid.instants)
    found = 0
    for block in stage.problem.blocks:
        rows = np.arange(stage.nlp.rows.lower.size)[stage.problem.rows_of(block.name)]
        for instant in quiet if block.times is not None else ():
            at = rows.reshape(block.lower.shape)[block.times == instant].ravel()
            given = np.isfinite(stage.nlp.rows.lower[at]) | np.isfinite(stage.nlp.rows.upper[at])
            assert set(at[given]) <= set(stage.numbers)
            found += given.sum()
    assert found >= len(quiet) > 3
