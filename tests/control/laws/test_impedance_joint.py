"""Joint impedance: its formula by the second road, damping ratios, the passive map of its error, and bad input."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.impedance import JointImpedance
from tests.control.laws.written_out import ARM, REGULAR, ROAD_A, ROAD_B, carried, joint_impedance, states
from tests.slips import uncaught

K, XI = np.array([900.0, 800.0, 500.0, 400.0, 90.0, 60.0, 40.0]), 0.7
MODULE = "lwr_dyn.control.laws.impedance"
SLIPS = (
    ("self.stiffness * (q_ref - q)", "self.stiffness * (q - q_ref)"),
    ("self.stiffness * (q_ref - q)", "self._root * (q_ref - q)"),
    ("self._root * (dq_ref - dq)", "self._root * (dq - dq_ref)"),
    ("self._root * (dq_ref - dq)", "self._root * (-dq)"),
    ("tau += root.dot(joint", "tau += root.T.dot(joint"),
    ("tau = self._carried(q, dq, dq_ref, ddq_ref) +", "tau ="),
    ("self._carried(q, dq, dq_ref, ddq_ref)", "self._carried(q, dq, ddq_ref, dq_ref)"),
)


def check(law):
    controller = law.JointImpedance(ROAD_A, K, XI)
    for state in states(ARM):
        np.testing.assert_allclose(controller(0.0, *state), joint_impedance(ROAD_B, state, K, XI), rtol=0, atol=1e-10)


def test_planted_slips_are_caught():
    assert not uncaught(MODULE, SLIPS, check)


def test_every_mode_has_the_damping_ratio():
    controller = JointImpedance(ROAD_A, K, XI)
    for q, *_ in states(ARM):
        B, D = ROAD_B.mass_matrix(q), controller.damping(q)
        companion = np.block([[np.zeros((7, 7)), np.eye(7)], [-np.linalg.solve(B, np.diag(K)), -np.linalg.solve(B, D)]])
        poles = np.linalg.eigvals(companion)
        np.testing.assert_allclose(-poles.real / np.abs(poles), XI, rtol=1e-6)


def test_without_feedforward_the_reference_moves_nothing_by_itself():
    q, dq, q_ref, dq_ref, ddq_ref = next(iter(states(ARM)))
    law = JointImpedance(ROAD_A, K, XI, feedforward=False)
    carried_part = carried(ROAD_B, q, dq, dq_ref, ddq_ref) - ROAD_B.gravity_vector(q)
    with_it = JointImpedance(ROAD_A, K, XI)(0.0, q, dq, q_ref, dq_ref, ddq_ref)
    np.testing.assert_allclose(with_it - law(0.0, q, dq, q_ref, dq_ref, ddq_ref), carried_part, atol=1e-10)
    assert "without feed-forward" in law.label


@pytest.mark.slow
def test_energy_of_the_error_falls_along_a_moving_reference():
    """V = (de^T B de + e^T K e) / 2 never rises with the law evaluated continuously."""
    law = JointImpedance(ROAD_A, K, XI)
    move = lwr_dyn.reference("point-to-point", ARM, start=[0.2] * 7, end=[0.9] * 7, duration=1.0)
    q0 = np.full(7, 0.2) + 0.1
    run = lwr_dyn.simulate(ARM, law, move, q0=q0, continuous=True, saturate=False, friction="none")
    e, de = run.q_ref - run.q, run.dq_ref - run.dq
    V = (np.einsum("ki,kij,kj->k", de, ROAD_B.mass_matrix(run.q), de) + np.einsum("ki,i,ki->k", e, K, e)) / 2
    assert V[-1] < 1e-3 * V[0]
    assert np.diff(V).max() <= 1e-13 * V[0]


def test_stiffness_is_what_was_asked_under_a_load():
    """A payload that only the plant has: at rest e = K^-1 (g - g_model)."""
    law = lwr_dyn.controller("joint-impedance", ARM, stiffness=2000.0)
    hold = lwr_dyn.reference("hold", ARM, q=REGULAR, duration=2.0)
    run = lwr_dyn.simulate(ARM, law, hold, payload=1.0, friction="none")
    loaded = lwr_dyn.dynamics_of(run.setup.plant.arm)
    missing = loaded.gravity_vector(run.q[-1]) - ROAD_B.gravity_vector(run.q[-1])
    np.testing.assert_allclose(2000.0 * (run.q_ref[-1] - run.q[-1]), missing, atol=1e-4 * np.abs(missing).max())


def test_a_model_that_is_no_mass_gives_no_torque():
    class Unphysical:
        n = 7
        mass_matrix = staticmethod(lambda q: np.diag([1.0] * 6 + [-1.0]))
        gravity_vector = inverse_dynamics = bias_torque = staticmethod(lambda q, *rest: np.zeros(7))

    law, rest = JointImpedance(Unphysical(), 100.0), np.zeros(7)
    assert np.isnan(law(0.0, rest, rest, rest, rest, rest)).all()
    assert np.isnan(law.linear_feedback(np.zeros((1, 7))).velocity).all()
