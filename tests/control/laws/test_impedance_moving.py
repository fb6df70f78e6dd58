"""The torque that carries an arm along its reference, against its matrices by the second road."""

import numpy as np

from tests.control.laws.written_out import ARM, ROAD_A, ROAD_B, carried, states
from tests.slips import uncaught

SLIPS = (
    ("0.5 * (dq + dq_ref)", "(dq + dq_ref)"),
    ("0.5 * (dq - dq_ref)", "0.5 * (dq + dq_ref)"),
    ("- bias(q", "+ bias(q"),
    ("+ gravity(q)\n", "\n"),
    ("(dq + dq_ref), ddq_ref)", "(dq + dq_ref), 0.0 * ddq_ref)"),
    ("carried if feedforward else held", "held if feedforward else carried"),
)


def check(module):
    forward, plain = (module.carried_torque(ROAD_A, both) for both in (True, False))
    for q, dq, _, dq_ref, ddq_ref in states(ARM):
        expected = carried(ROAD_B, q, dq, dq_ref, ddq_ref)
        np.testing.assert_allclose(forward(q, dq, dq_ref, ddq_ref), expected, atol=1e-11)
        np.testing.assert_allclose(plain(q, dq, dq_ref, ddq_ref), ROAD_B.gravity_vector(q), atol=1e-12)


def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.control.laws.impedance", SLIPS, check)
