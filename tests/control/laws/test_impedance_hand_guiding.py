"""Hand guiding: its formula, weight carried, friction compensated, motions that fade, and bad input."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.friction_compensation import HandGuiding
from lwr_dyn.model.friction import smooth_friction
from tests.control.laws.written_out import REGULAR, states
from tests.slips import uncaught

WAM = lwr_dyn.load("wam7")
ROAD_A, ROAD_B = (lwr_dyn.dynamics_of(WAM, engine) for engine in ("pinocchio", "newton-euler"))
SLIPS = (
    ("-self.fading * dq)", "-dq)"),
    ("np.zeros_like(dq), -self", "dq, -self"),
    ("tau + self.share * self._friction(dq)", "tau + self._friction(dq)"),
    ("smooth_friction(models, self.width)", "smooth_friction(models, 10 * self.width)"),
)


def check(law):
    controller = law.HandGuiding(WAM, ROAD_A, fading=2.0, share=0.7, width=0.05)
    friction = smooth_friction(WAM.friction_models(), 0.05)
    for q, dq, *rest in states(WAM):
        expected = ROAD_B.gravity_vector(q) + 0.7 * friction(dq) - 2.0 * ROAD_B.mass_matrix(q) @ dq
        np.testing.assert_allclose(controller(0.0, q, dq, *rest), expected, atol=1e-10)


def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.control.laws.friction_compensation", SLIPS, check)


@pytest.mark.slow
def test_a_motion_left_alone_fades_at_the_rate_and_the_arm_stays_where_it_is_left(arm):
    hold = lwr_dyn.reference("hold", arm, q=REGULAR, duration=0.5)
    law = lwr_dyn.controller("hand-guiding", arm, fading=3.0)
    run = lwr_dyn.simulate(arm, law, hold, dq0=[0.05] * 7, continuous=True, friction="none")
    energy = np.einsum("ki,kij,kj->k", run.dq, lwr_dyn.dynamics_of(arm).mass_matrix(run.q), run.dq)
    np.testing.assert_allclose(energy, energy[0] * np.exp(-6.0 * run.t), rtol=1e-6)
    np.testing.assert_allclose(lwr_dyn.simulate(arm, law, hold).q[-1], REGULAR, atol=1e-9)


def test_compensated_friction_brakes_less():
    start = dict(q0=[0.0, -1.5, 0.0, 1.5, 0.0, 0.0, 0.0], dq0=[0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], duration=0.4)
    hold = lwr_dyn.reference("hold", WAM, q=start["q0"], duration=1.0)
    left = []
    for share in (0.0, 0.5, 0.9):
        law = HandGuiding(WAM, ROAD_A, fading=0.1, share=share)
        left.append(lwr_dyn.simulate(WAM, law, hold, **start, position_limits=False).q[-1, 0])
    assert left[0] < left[1] < left[2]
