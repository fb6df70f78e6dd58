"""Sensors between a simulated arm and its log."""

import pytest

from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.model.friction import symmetric
from tests.identification.simulated import ideal_cruise

FRICTION = [symmetric(2.0, 0.5), symmetric(1.0, 0.3)]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: declared_units("q=turns"), "units of q: 'turns'; allowed: rad, deg, m, mm"),
        (lambda: declared_units("speed=1"), "units: 'speed=1'; allowed: QUANTITY=UNIT with time, q, dq, tau"),
        (lambda: LogSensors(-1.0), "log torque noise: -1.0; allowed: a number >= 0"),
        (lambda: ideal_cruise(FRICTION, (0.1, 0.1), duration=0.0), "duration: 0.0; allowed: a number above 0"),
        (lambda: ideal_cruise(FRICTION, (0.1,)), "dq: 1 number; allowed: 2 numbers, one per joint"),
    ],
)
def test_options_outside_what_is_allowed(call, message):
    with pytest.raises(LwrDynError, match=message) as caught:
        call()
    assert isinstance(caught.value, OptionError | ValueError)
