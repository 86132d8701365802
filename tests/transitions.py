"""Transitions of the biped that several tests look at; each is designed once."""

from functools import cache

from reference_cases import biped

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.transition import design_transition
from gaitopt.gait.presets import preset_task
from gaitopt.solvers import solver_by_name

ALONE = DesignOptions(solver=solver_by_name("sqp"))


@cache
def walk(speed=1.0, **changes):
    task = preset_task(speed=speed, **changes)
    return design(biped(), task, ALONE).gait


@cache
def from_rest():
    return design_transition(None, walk(), steps=2, options=ALONE)


@cache
def to_rest():
    return design_transition(walk(), None, steps=2, options=ALONE)
