"""Cartesian and joint impedance: formulas by the second road, projector, damping ratios, arms, tools, passivity."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.impedance import SLOWEST, CartesianImpedance, JointImpedance, carried_torque
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import jacobian
from tests.control.laws.passivity import cartesian, jointly
from tests.control.laws.written_out import (
    ARM,
    REGULAR,
    ROAD_A,
    ROAD_B,
    carried,
    cartesian_impedance,
    joint_impedance,
    slope,
    states,
)

K, XI, W, D = np.array([2000.0, 1500.0, 1000.0, 150.0, 150.0, 150.0]), 0.7, 12.0, 20.0
SINGULAR = np.array([0.3, 0.6, 0.2, 1.2, np.pi / 2, 0.0, 0.1])
"""The wrist stretched: one direction of the tip is lost."""


def test_the_law_is_its_formula():
    controller = CartesianImpedance(ARM, ROAD_A, K[:3], K[3], XI, W, D)
    for state in states(ARM):
        expected = cartesian_impedance(ARM, ROAD_B, state, K, XI, W, D)
        np.testing.assert_allclose(controller(0.0, *state), expected, rtol=0, atol=1e-8)
    poses = np.array([SINGULAR, *(state[0] for state in states(ARM, 2))])
    linear = controller.linear_feedback(poses)
    for k, pose in enumerate(poses):
        if k > 0:  # at the singular pose itself the direction that is lost jumps with q
            np.testing.assert_allclose(linear.position[k], slope(controller, pose, 0), rtol=0, atol=2e-3)
        np.testing.assert_allclose(linear.velocity[k], slope(controller, pose, 1), rtol=0, atol=1e-6)
    root, joint, frequency, _ = controller.at(SINGULAR)[0]
    assert frequency[-1] < 1e-6
    lost = np.linalg.solve(root.T, joint[:, -1])  # the motion of unit inertia that the tip does not feel
    rest = np.zeros(7)
    tau = controller(0.0, SINGULAR, lost, SINGULAR, rest, rest) - ROAD_A.gravity_vector(SINGULAR)
    np.testing.assert_allclose(lost @ tau, -2.0 * XI * SLOWEST, rtol=1e-4)


def test_the_posture_spring_does_not_accelerate_the_tip():
    for state in states(ARM):
        with_it, without = (
            CartesianImpedance(ARM, ROAD_A, posture=w, posture_damping=1e-12)(0.0, *state) for w in (30.0, 0.0)
        )
        assert np.abs(with_it - without).max() > 1.0
        acceleration = jacobian(ARM.chain, state[0]) @ np.linalg.solve(ROAD_B.mass_matrix(state[0]), with_it - without)
        np.testing.assert_allclose(acceleration, np.zeros(6), atol=1e-8)


def test_six_joints_leave_no_posture_and_its_damping_is_above_zero():
    arm = lwr_dyn.load("lwr4plus", lock={"joint_3": 0.3}, reading="physical")
    model, state = lwr_dyn.dynamics_of(arm), next(iter(states(arm)))
    soft, hard = (CartesianImpedance(arm, model, posture=w)(0.0, *state) for w in (0.0, 40.0))
    np.testing.assert_allclose(soft, hard, atol=1e-9)
    with pytest.raises(OptionError, match=r"posture_damping: 0\.0; allowed: numbers above 0"):
        CartesianImpedance(ARM, ROAD_A, posture_damping=0.0)


def test_an_arm_with_a_tool_is_held_at_its_tool_point():
    tool = {"xyz": [0.05, 0.02, 0.15], "rpy": [0.1, 0.4, 0.2], "mass": 0.5, "com": [0.0, 0.0, 0.05]}
    arm = lwr_dyn.load("lwr4plus", reading="physical", tool=tool)
    model, other = (lwr_dyn.dynamics_of(arm, engine) for engine in ("pinocchio", "newton-euler"))
    for state in states(arm, 2):
        law = CartesianImpedance(arm, model, K[:3], K[3], XI, W, D)
        np.testing.assert_allclose(law(0.0, *state), cartesian_impedance(arm, other, state, K, XI, W, D), atol=1e-8)


def test_torques_stay_bounded_through_a_singular_pose():
    law = lwr_dyn.controller("cartesian-impedance", ARM)
    move = SINGULAR + np.linspace(-0.05, 0.05, 101)[:, None] * np.eye(7)[5]
    rest, off = np.zeros(7), 0.01 * np.eye(7)[1]
    torques = np.array([law(0.0, q + off, 0.1 * rest + 0.1, q, rest, rest) for q in move])
    assert np.isfinite(torques).all()
    assert np.abs(np.diff(torques, axis=0)).max() < 0.2 * np.abs(torques).max()


def test_a_run_from_an_exactly_singular_pose_comes_to_rest():
    law = lwr_dyn.controller("cartesian-impedance", ARM)
    hold = lwr_dyn.reference("hold", ARM, q=SINGULAR, duration=1.0)
    run = lwr_dyn.simulate(ARM, law, hold, dq0=[0.1] * 7, friction="none")
    assert np.abs(run.dq[-1]).max() < 0.05
    tip = lwr_dyn.forward_kinematics(ARM, run.q[[0, -1]])[:, :3, 3]
    assert np.linalg.norm(tip[1] - tip[0]) < 1e-4


def test_what_is_carried_is_b_c_and_g_or_gravity():
    forward, plain = (carried_torque(ROAD_A, both) for both in (True, False))
    for q, dq, q_ref, dq_ref, ddq_ref in states(ARM):
        expected, gravity = carried(ROAD_B, q, dq, dq_ref, ddq_ref), ROAD_B.gravity_vector(q)
        np.testing.assert_allclose(forward(q, dq, dq_ref, ddq_ref), expected, atol=1e-11)
        np.testing.assert_allclose(plain(q, dq, dq_ref, ddq_ref), gravity, atol=1e-12)
        laws = (JointImpedance(ROAD_A, STIFF, RATIO, feedforward=x) for x in (True, False))
        torques = [law(0.0, q, dq, q_ref, dq_ref, ddq_ref) for law in laws]
        np.testing.assert_allclose(torques[0] - torques[1], expected - gravity, atol=1e-10)


ROUNDING = 1e-9
"""[J] The wall's contact begins inside a step of 1 ms: RK4 leaves 2.4e-10."""


@pytest.mark.slow
@pytest.mark.parametrize("law", [cartesian, jointly])
def test_a_continuous_law_and_the_wall_are_passive(law):
    run = law(seconds=1.5)
    assert 0.2 < np.mean(run.depth > 0.0) < 0.8
    assert run.hand_work[-1] > 0.1
    assert np.diff(run.law_loss).min() > 0.0
    assert np.diff(run.wall_loss).min() > -ROUNDING
    assert np.diff(run.excess).max() < ROUNDING


@pytest.mark.slow
def test_held_torques_of_a_damped_law_give_energy_at_the_first_touch_alone():
    """Of order 4 in the period: until the first sample after a push the law does not know of it."""
    given = []
    for rate in (500, 250):
        run = cartesian(seconds=0.4, rate=rate, held=True, substeps=4)
        losses = np.diff(run.law_loss)
        assert losses[1:].min() > 0.0
        given.append(-losses[0])
    assert 12.0 < given[1] / given[0] < 20.0


@pytest.mark.slow
def test_held_torques_of_a_law_with_too_little_damping_give_energy():
    """A held spring takes omega T / 4 off the damping ratio of a mode: at 45 rad/s 0.011 at 1 kHz, 0.046 at 250 Hz."""
    fast, slow = (cartesian(seconds=1.5, rate=rate, held=True, substeps=1000 // rate, xi=0.02) for rate in (1000, 250))
    assert fast.law_loss[-1] > 0.1
    assert slow.law_loss[-1] < -0.1
    assert slow.excess.max() > 0.1


def test_a_law_that_gives_energy_is_seen():
    """The check itself: a spring with the wrong sign of damping."""
    run = cartesian(seconds=0.3, slip=lambda tau, dq: tau + 40.0 * dq)
    assert np.diff(run.law_loss).min() < -1e-6


STIFF, RATIO = np.array([900.0, 800.0, 500.0, 400.0, 90.0, 60.0, 40.0]), 0.7


def test_the_joint_law_is_its_formula():
    controller = JointImpedance(ROAD_A, STIFF, RATIO)
    for state in states(ARM):
        expected = joint_impedance(ROAD_B, state, STIFF, RATIO)
        np.testing.assert_allclose(controller(0.0, *state), expected, rtol=0, atol=1e-10)


def test_every_mode_has_the_damping_ratio():
    controller = JointImpedance(ROAD_A, STIFF, RATIO)
    for q, *_ in states(ARM):
        solved = np.linalg.solve(ROAD_B.mass_matrix(q), np.hstack([np.diag(STIFF), controller.damping(q)]))
        poles = np.linalg.eigvals(np.block([[np.zeros((7, 7)), np.eye(7)], [-solved]]))
        np.testing.assert_allclose(-poles.real / np.abs(poles), RATIO, rtol=1e-6)


@pytest.mark.slow
def test_energy_of_the_error_falls_along_a_moving_reference():
    """V = (de^T B de + e^T STIFF e) / 2 never rises with the law evaluated continuously."""
    law = JointImpedance(ROAD_A, STIFF, RATIO)
    move = lwr_dyn.reference("point-to-point", ARM, start=[0.2] * 7, end=[0.9] * 7, duration=1.0)
    q0 = np.full(7, 0.2) + 0.1
    run = lwr_dyn.simulate(ARM, law, move, q0=q0, continuous=True, saturate=False, friction="none")
    e, de = run.q_ref - run.q, run.dq_ref - run.dq
    V = (np.einsum("ki,kij,kj->k", de, ROAD_B.mass_matrix(run.q), de) + np.einsum("ki,i,ki->k", e, STIFF, e)) / 2
    assert V[-1] < 1e-3 * V[0]
    assert np.diff(V).max() <= 1e-13 * V[0]


def test_stiffness_is_what_was_asked_under_a_load():
    """A payload that only the plant has: at rest e = STIFF^-1 (g - g_model)."""
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

    for law in (JointImpedance(Unphysical(), 100.0), CartesianImpedance(ARM, Unphysical())):
        tau, form = law(0.0, REGULAR, *np.zeros((4, 7))), law.linear_feedback(REGULAR[None])
        assert tau.shape == (7,)
        assert np.isnan(tau).all()
        assert np.isnan(form.velocity).all()
        assert np.isnan(form.position).all() == isinstance(law, CartesianImpedance)
