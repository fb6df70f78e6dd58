"""Gains that differ from run to run obey the rules of the controllers."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.law_forms import LAW_FORMS, FrictionForm
from lwr_dyn.codegen.rollouts.run_parameters import ABOVE_ZERO, NOT_NEGATIVE, RULES, check_gains
from lwr_dyn.control.laws.friction_compensation import FrictionCompensation
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.codegen.rollouts.beside import ARM, made

BAD = {
    **{name: ([1.0, 0.0], "0 in run 1; allowed: numbers above 0") for name in ABOVE_ZERO},
    **{name: ([1.0, -2.5], "-2.5 in run 1; allowed: numbers from 0 on") for name in NOT_NEGATIVE},
    "lower_load": ([0.5, -1.0], "0.5 in run 0; allowed: numbers up to 0"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_gain_that_no_controller_has_is_refused(name):
    column, words = BAD[name]
    with pytest.raises(OptionError, match=rf"parameter {name}: {words}"):
        check_gains({name: np.repeat(np.array(column)[:, None], 3, axis=1)})
    check_gains({name: np.full((2, 3), -1.0 if name == "lower_load" else 1.0)})


def test_friction_of_a_law_has_no_negative_coulomb_level():
    table = np.zeros((3, 5, 4))
    table[:, [1, 3, 4]] = -1.0  # viscous friction and offsets may be negative
    check_gains({"law_friction": table})
    table[2, 2, 1] = -0.1
    with pytest.raises(OptionError, match=r"parameter law_friction: -0\.1 in run 2; allowed: levels from 0 on"):
        check_gains({"law_friction": table})


def test_every_gain_of_every_form_has_a_rule_or_none_is_needed():
    names = set()
    for name in LAW_FORMS.names:
        law = made(name, adapt_friction=True) if name == "adaptive" else made(name)
        form = LAW_FORMS.load(name).of(law, ARM)
        names |= form.parameters.keys() | FrictionForm(FrictionCompensation(law, ARM.friction), form).parameters.keys()
    assert names - RULES.keys() == {"scale", "middle_load", "friction_start"}
    assert RULES.keys() <= names


def test_rollouts_refuse_such_gains():
    move = point_to_point(ARM, [[0.1] * 4, [0.2] * 4], [0.1])
    with pytest.raises(LwrDynError, match="parameter Kp: -1 in run 1; allowed: numbers above 0"):
        lwr_dyn.rollouts(ARM, made("pd-gravity"), move, parameters={"Kp": [[900.0], [-1.0]]})
