"""Kernel forms of friction compensation around a law: torque after torque as the wrapped controllers."""

import numpy as np
import pytest

from lwr_dyn.codegen.rollouts import law_forms
from lwr_dyn.codegen.rollouts.law_forms import INVERSE_DYNAMICS, PID_LAW
from lwr_dyn.codegen.rollouts.passivity_law_forms import AdaptiveForm
from lwr_dyn.control.laws.friction_compensation import FrictionCompensation
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import Direction, JointFriction
from tests.codegen.rollouts.beside import ARM, check_beside, made
from tests.slips import uncaught

FRICTION = tuple(JointFriction(Direction(2.0 + i, 0.5), Direction(1.0, 0.2 + i), 0.3 * i) for i in range(ARM.n))


def check_law(module):
    for measured in (False, True):
        for name, kind in (("inverse-dynamics", INVERSE_DYNAMICS), ("pid", PID_LAW)):
            inner = made(name)
            law = FrictionCompensation(inner, FRICTION, 0.5, measured)  # so wide that the speeds show its shape
            form = module.FrictionForm(law, kind.of(inner, ARM))
            check_beside(form, law, {"law_effort": 50.0})
    adaptive = made("adaptive")
    wrapped = module.FrictionForm(FrictionCompensation(adaptive, FRICTION), AdaptiveForm.of(adaptive, ARM))
    assert wrapped.signals(np.zeros((3, 10))).keys() == {"adapted_payload"}
    assert not hasattr(form, "signals")
    assert form.digest != module.FrictionForm(replace_measured(law), form.inner).digest


def replace_measured(law):
    """The same on the speed of the reference."""
    return FrictionCompensation(law.inner, law.models, law.width)


SLIPS = [
    ("x.dq if self.law.measured else x.dq_ref", "x.dq"),
    ("x.dq if self.law.measured else x.dq_ref", "x.dq_ref if self.law.measured else x.dq"),
    ("return tau + friction_column", "return tau - friction_column"),
    ('x.parameters["law_friction_width"]), memory', '2 * x.parameters["law_friction_width"]), memory'),
    ('x.parameters["law_friction_width"]), memory', 'x.parameters["law_friction_width"]), 2 * memory'),
    ('"law_friction_width": np.array(self.law.width)', '"law_friction_width": np.array(1e-3)'),
    ('float(values["law_friction_width"]), self.law.measured', 'float(values["law_friction_width"])'),
    ("return self.inner.start()", "return self.inner.start()[:3]"),
    ('f"{self.inner.digest} + {self.law.word}"', "self.inner.digest"),
]


@pytest.mark.slow
def test_planted_slips_are_caught():
    assert not uncaught(law_forms.__name__, SLIPS, check_law)


def test_a_stribeck_curve_is_refused():
    falling = JointFriction(*(Direction(1.0, 0.1, 2.0, 0.05),) * 2)
    inner = made("inverse-dynamics")
    with pytest.raises(OptionError, match="friction of joint 3: a Stribeck curve; allowed: in kernels Coulomb"):
        law_forms.FrictionForm(
            FrictionCompensation(inner, (*FRICTION[:2], falling, *FRICTION[3:])), INVERSE_DYNAMICS.of(inner, ARM)
        )
