"""Attributes of version 0.1 whose names have changed."""

import pytest

from gaitopt.design.conflict import Conflict


def test_old_attributes_work_with_a_warning(refined_design):
    certificate = refined_design.certificate
    with pytest.warns(DeprecationWarning, match="Certificate.families is now 'constraints'"):
        assert certificate.families == certificate.constraints
    with pytest.warns(DeprecationWarning, match="WorstRow.family is now 'constraint'"):
        assert certificate.worst.family == certificate.constraints[0].constraint
    conflict = Conflict("torque", "torque of the joints", 3.0, "N·m", "left_knee torque", 1.0)
    with pytest.warns(DeprecationWarning, match="Conflict.family is now 'constraint'"):
        assert conflict.family == "torque"
