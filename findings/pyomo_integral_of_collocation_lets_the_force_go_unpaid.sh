#!/usr/bin/env bash
# Version:  pyomo 6.10.1 (pyomo.dae), numpy 2.4.6
# Does:     an Integral over a ContinuousSet becomes the trapezoid rule through all its points, as its docstring says, while dae.collocation
#           takes the dynamics at the collocation points alone. With LAGRANGE-LEGENDRE the ends of each element stand in the integral and not
#           in the dynamics, with LAGRANGE-RADAU the first instant and unequal shares of the others: an optimiser sets to zero what
#           costs and does nothing, and pushes where it is cheap.
# Guess:    the integral is that of the collocation, which for Legendre points is Gauss quadrature and exact here.
# Means:    a least-effort objective written with Integral has an optimum below what any motion can reach, with a jagged force,
#           and the sum that is told as energy is up to half of it. More points repair it slowly. Integrate the
#           effort as a state of its own, or weigh the collocation points by hand. No report of the size was found.
# Seen:     unit mass from rest to rest, 1 m in 1 s, ten elements, least effort 12. LEGENDRE with 1, 2, 3, 5 points: Integral 6.06, 9.46, 10.65,
#           11.44, with 2 points a force of 0, 5.75, 5.05, 0, 4.55 ..; RADAU: 9.91, 9.50, 10.77, 11.54, with 2 points 0, 6.54, 1.86, 5.12, 1.39 ..;
#           the weights of each scheme's own rule in place of it: 12.00 from two points on
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pyomo==6.10.1 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - > out 2>&1 <<'PY' || { tail -20 out; exit 1; }
import numpy as np
import pyomo.environ as pe
from pyomo.dae import ContinuousSet, DerivativeVar, Integral
from pyomo.repn import generate_standard_repn

ELEMENTS, LEAST = 10, 12.0


def build(scheme, points):
    m = pe.ConcreteModel()
    m.t = ContinuousSet(bounds=(0, 1))
    m.x, m.v, m.u = pe.Var(m.t), pe.Var(m.t), pe.Var(m.t)
    m.dx, m.dv = DerivativeVar(m.x), DerivativeVar(m.v)
    m.moves = pe.Constraint(m.t, rule=lambda m, t: m.dx[t] == m.v[t])
    m.pushes = pe.Constraint(m.t, rule=lambda m, t: m.dv[t] == m.u[t])
    for variable, start, end in ((m.x, 0, 1), (m.v, 0, 0)):
        variable[0].fix(start)
        variable[1].fix(end)
    m.effort = Integral(m.t, rule=lambda m, t: m.u[t] ** 2)
    m.objective = pe.Objective(expr=m.effort)
    pe.TransformationFactory("dae.collocation").apply_to(m, nfe=ELEMENTS, ncp=points, scheme=scheme)
    return m


def own_rule(m, points):
    """The same effort with the weights of the interpolation through the collocation points of each element."""
    ends = m.t.get_finite_elements()
    total = 0
    for start, end in zip(ends, ends[1:]):
        inside = [t for t in m.t if start < t <= end and (t < end or m.radau)]
        places = (np.array(inside) - start) / (end - start)
        weights = np.linalg.solve(np.vander(places, increasing=True).T, 1 / np.arange(1, points + 1)) * (end - start)
        total += sum(w * m.u[t] ** 2 for w, t in zip(weights, inside))
    return total


def solve(m, objective):
    """The quadratic program, by its linear optimality conditions."""
    free = [v for v in m.component_data_objects(pe.Var) if not v.fixed]
    place = {id(v): i for i, v in enumerate(free)}
    rows, rests = [], []
    for c in m.component_data_objects(pe.Constraint, active=True):
        form, row = generate_standard_repn(c.body), np.zeros(len(free))
        for factor, v in zip(form.linear_coefs, form.linear_vars):
            row[place[id(v)]] += factor
        rows.append(row)
        rests.append(pe.value(c.upper) - form.constant)
    form, Q, A = generate_standard_repn(objective), np.zeros((len(free), len(free))), np.array(rows)
    for factor, (a, b) in zip(form.quadratic_coefs, form.quadratic_vars):
        Q[place[id(a)], place[id(b)]] += factor
        Q[place[id(b)], place[id(a)]] += factor
    matrix = np.block([[Q, A.T], [A, np.zeros((len(rows), len(rows)))]])
    right = np.r_[np.zeros(len(free)), rests]
    answer = np.linalg.lstsq(matrix, right)[0]
    assert np.allclose(matrix @ answer, right, atol=1e-8)
    for v, value in zip(free, answer):
        v.set_value(value)
    return pe.value(objective), [m.u[t].value for t in sorted(m.t)[:5]]


for scheme in ("LAGRANGE-LEGENDRE", "LAGRANGE-RADAU"):
    for points in (1, 2, 3, 5):
        m = build(scheme, points)
        m.radau = scheme == "LAGRANGE-RADAU"
        told, force = solve(m, m.objective.expr)
        own, smooth = solve(m, own_rule(m, points))
        print(f"SEEN {scheme}, {points} points: Integral {told:.2f}, force {np.round(force, 2)}; own weights {own:.2f}, {np.round(smooth, 2)}")
        assert told < 0.965 * LEAST and abs(force[0]) < 1e-6
        if points > 1:
            assert abs(own - LEAST) < 0.03 and np.allclose(force[0], 0)
PY
grep SEEN out
