"""Tables, placements and refusals of the referee's chains."""

from dataclasses import replace

import numpy as np
import pytest
from paper_chain import chain_of_spec
from places import REFERENCE
from random_chains import relative

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.errors import InputError
from gaitopt.mechanics.newton_euler import sole_placement


def test_biped13_weighs_what_table_2_says():
    assert chain_of_spec(biped13()).mass == pytest.approx(56.87)


@pytest.mark.skipif(not REFERENCE.exists(), reason="needs the reference gaits")
def test_reference_corners_of_the_swing_sole():
    data = np.load(REFERENCE)
    chain = replace(chain_of_spec(biped13()), sign=np.ones(12))
    rotation, origin = sole_placement(chain, data["p43_v1.0_optimum/q"])
    corners = np.array([[0, 0.068, 0], [0, -0.068, 0], [-0.214, 0.068, 0], [-0.214, -0.068, 0]])
    soles = origin[:, None, :] + corners @ np.swapaxes(rotation, -1, -2)
    assert relative(soles, data["p43_v1.0_optimum/swing_sole"]) < 1e-8


def test_bad_tables_say_what_is_allowed():
    chain = chain_of_spec(biped13())
    with pytest.raises(InputError, match=r"sigma = .*; use 0 \(revolute\)"):
        replace(chain.joints, sigma=np.full(12, 2.0))
    with pytest.raises(InputError, match=r"d has shape \(3,\); give shape \(12,\)"):
        replace(chain.joints, d=np.zeros(3))
    with pytest.raises(InputError, match=r"use \+1 or -1"):
        replace(chain, sign=np.zeros(12))
    ones = np.ones((12, 3, 3))
    short = replace(chain.links, mass=ones[:, 0, 0], first_moment=ones[:, 0], inertia=ones)
    with pytest.raises(InputError, match="12 joints and 12 links; give 13 links"):
        replace(chain, links=short)
    with pytest.raises(InputError, match="mass has an entry that is not finite"):
        replace(chain.links, mass=np.full(13, np.nan))


def test_tables_cannot_be_changed_in_place():
    chain = chain_of_spec(biped13())
    with pytest.raises(ValueError, match="read-only"):
        chain.joints.d[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        chain.links.mass[0] = 1.0
