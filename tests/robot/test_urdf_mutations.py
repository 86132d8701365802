"""URDFs damaged at random: read to the last digit, or refused; never another robot."""

import numpy as np
import pinocchio as pin
import pytest
from places import CASES
from urdf_mutations import mutate_urdf
from urdf_oracle import differences_from_text

from gaitopt import biped13, urdf_text
from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source

MUTATIONS = 45  # of each: 180 in all; a fuzzer takes `mutate_urdf` for more
TEXTS = {
    "biped13": urdf_text(biped13()),
    "base_mini": (CASES / "base_mini.urdf").read_text(encoding="utf-8"),
    "damped": (CASES / "urdf_damping_friction.urdf").read_text(encoding="utf-8"),
    "turned": (CASES / "unnamed_material.urdf").read_text(encoding="utf-8"),
}


def read_or_none(text):
    """The description if it can be read, None if it is refused."""
    try:
        source = read_source(text)
        source.model()
    except RobotError:
        return None
    return source


@pytest.mark.parametrize("name", TEXTS)
def test_a_sound_file_is_read_to_the_last_digit(name, rng):
    assert differences_from_text(read_source(TEXTS[name]), rng) == []


@pytest.mark.parametrize("name", TEXTS)
def test_a_damaged_file_is_read_as_it_is_or_refused(name, capfd):
    read, refused = 0, 0
    for seed in range(MUTATIONS):
        rng = np.random.default_rng([seed, len(TEXTS[name])])
        text = mutate_urdf(TEXTS[name], rng, times=1 + seed % 3)
        source = read_or_none(text)
        if source is None:
            refused += 1
            continue
        read += 1
        source.geometry(pin.GeometryType.VISUAL)
        source.geometry(pin.GeometryType.COLLISION)
        source.mesh_problems()
        source.findings()
        assert differences_from_text(source, rng) == []
    assert min(read, refused) >= 5
    assert capfd.readouterr() == ("", "")
