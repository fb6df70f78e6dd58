"""The adaptive law: its Lyapunov function at random states and along motions, linear form, bounds, what it gains."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.gains import gravity_stiffness
from lwr_dyn.control.laws.adaptive import (
    AdaptedParameters,
    SlotineLiRegressor,
    poses_of_box,
    scaled_gains,
    tuned_adaptive,
)
from lwr_dyn.control.protocol import WithMemory, describe
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.trajectory.references.ist import Twice, ist_clear_reference
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.control.laws import learning
from tests.control.laws.lyapunov import ARM, LOAD, STATES, Instant
from tests.control.laws.mixed_recursion import mixed_regressor
from tests.random_arms import random_arm

TRUE = lwr_dyn.dynamics_of(LOAD, "newton-euler")
OMEGA, GAIN = 50.0, 100.0
VISCOUS = np.linspace(0.5, 0.1, 7)


def made(**options):
    return tuned_adaptive(ARM, learning.MODEL, **({"omega_n": OMEGA, "adapt_gain": GAIN} | options))


def test_its_memory_moves_by_euler_inside_the_bounds():
    """Explicit Euler from call to call, inside the bounds; outward rates there are zero, all where torque is cut."""
    law, state = made(), STATES[0]
    law._effort = np.full(7, np.inf)
    _, rate = law.torque_and_rate(np.zeros(10), *state)
    law(0.0, *state)
    law(0.002, *state)
    np.testing.assert_allclose(law.signals["adapted_payload"], 0.002 * rate, rtol=1e-12)
    for bound in (law.adapted.lower, law.adapted.upper):
        _, held = law.torque_and_rate(bound, *state)
        _, free = law.torque_and_rate(bound * (1 - 1e-9), *state)
        outward = np.sign(bound) * free > 0.0
        assert outward.any()
        assert (held[outward] == 0.0).all()
        np.testing.assert_allclose(held[~outward], free[~outward], rtol=1e-5)
    law(10.0, *state)  # a long time at that rate
    assert (law.signals["adapted_payload"] >= law.adapted.lower).all()
    assert (law.signals["adapted_payload"] <= law.adapted.upper).all()
    law._effort = np.full(7, 1e-3)
    assert not law.torque_and_rate(np.zeros(10), *state)[1].any()
    law.reset()
    assert not law.signals["adapted_payload"].any()


def test_friction_is_adapted_beside_the_bodies():
    """Coulomb's on the speed of the reference, viscous on dq_r, each from what is known on; both mass gains of b."""
    known = [JointFriction(Direction(1.0 + j, 0.1), Direction(3.0 + j, 0.5)) for j in range(7)]
    arm = replace(ARM, friction=tuple(known))
    law, plain = (tuned_adaptive(x, learning.MODEL, adapt_friction=x is arm, friction_gain=7.0) for x in (arm, ARM))
    box = poses_of_box(arm, 64, 0)
    b = np.einsum("kii->i", learning.MODEL.mass_matrix(box)) / 64
    assert ((box >= arm.lower) & (box <= arm.upper)).all()
    np.testing.assert_allclose(law.friction_gains, [7.0 * b, 0.7 * b], rtol=1e-12)
    q, dq, q_ref, dq_ref, _ = STATES[0]
    dq_r, turned = dq_ref + 50.0 * (q_ref - q), np.tanh(dq_ref / 5e-3)
    memory, limits = np.linspace(-0.2, 0.3, 24), np.full(7, np.inf)
    law._effort = plain._effort = limits
    tau, rate = plain.torque_and_rate(memory[:10], *STATES[0])
    both, rates = law.torque_and_rate(memory, *STATES[0])
    coulomb, viscous = 2.0 + np.arange(7) + memory[10:17], 0.3 + memory[17:]
    np.testing.assert_allclose(both, tau + coulomb * turned + viscous * dq_r, rtol=1e-12)
    wanted = [rate, -7.0 * b * turned * (dq - dq_r), -0.7 * b * dq_r * (dq - dq_r)]
    np.testing.assert_allclose(rates, np.concatenate(wanted), rtol=1e-12)
    assert law.memory_size == 24
    np.testing.assert_allclose(law._lower[10:], -np.r_[2.0 + np.arange(7), [0.3] * 7])  # no friction below 0
    np.testing.assert_allclose(law._upper[10:], np.tile(arm.effort, 2))
    law(0.0, *STATES[0])
    law(0.001, *STATES[0])
    first = law.torque_and_rate(np.zeros(24), *STATES[0])[1]
    np.testing.assert_allclose(law.signals["adapted_coulomb"], 2.0 + np.arange(7) + 0.001 * first[10:17], rtol=1e-12)
    np.testing.assert_allclose(law.signals["adapted_viscous"], 0.3 + 0.001 * first[17:], rtol=1e-12)


def test_its_linear_form_is_that_of_differences_at_rest():
    """Against differences of torque and rate at rest."""
    law, still, h = made(), np.zeros(7), 1e-6
    q_0 = STATES[1, 0]
    form = law.linear_feedback(q_0[None])

    def torque_and_rate(x, v):
        return np.concatenate(law.torque_and_rate(np.zeros(10), q_0 + x, v, q_0, still, still))

    steps = h * np.eye(7)
    by_x = np.array([torque_and_rate(x, still) - torque_and_rate(-x, still) for x in steps]).T / (2 * h)
    by_v = np.array([torque_and_rate(still, v) - torque_and_rate(still, -v) for v in steps]).T / (2 * h)
    columns = law.adapted.columns(SlotineLiRegressor(ARM)(q_0, still, still, still))
    G = -columns @ by_v[7:]  # torque per position of the memory that follows the speed
    stiffness = gravity_stiffness(form.gravity, q_0)
    np.testing.assert_allclose(form.velocity[0], -by_v[:7], rtol=0, atol=1e-4)
    np.testing.assert_allclose(form.position[0], stiffness - by_x[:7] + G, rtol=0, atol=1e-2)
    np.testing.assert_allclose(form.integral[0], -columns @ by_x[7:], rtol=0, atol=1e-2)
    assert np.abs(G).max() > 100.0


def test_base_parameters_move_every_torque_that_parameters_can_move():
    law = made(adapt="base")
    regressor, W = SlotineLiRegressor(ARM), law.adapted.W
    assert W.shape == (70, 43)  # what is known of an arm with seven turning joints, the first one upright
    assert law.signals["adapted_base"].shape == (70,)
    Y = np.concatenate([regressor(*state[[0, 1, 3, 4]]) for state in STATES])
    rates = np.tile(scaled_gains(GAIN), 7)[:, None] * Y.T  # of all 70 by the gradient law: it never leaves the columns
    np.testing.assert_allclose(W @ np.linalg.lstsq(W, rates, rcond=None)[0], rates, rtol=0, atol=1e-9 * GAIN)
    any_change = np.random.default_rng(4).normal(size=70)
    theta = np.linalg.lstsq(Y @ W, Y @ any_change, rcond=None)[0]
    np.testing.assert_allclose(Y @ W @ theta, Y @ any_change, rtol=0, atol=1e-8)
    truth = np.linalg.lstsq(Y @ W, Y[:, -10:] @ learning.THETA, rcond=None)[0]
    law._effort[:] = np.inf
    at, (tau, rate) = Instant.of(TRUE, OMEGA, *STATES[0]), law.torque_and_rate(np.zeros(43), *STATES[0])
    assert at.power(tau) - truth @ rate == pytest.approx(-at.damping, rel=1e-8)


SHORT = point_to_point(ARM, [[0.3, -1.2, 0.2, 0.9, -1.5, 1.1, -0.6], [0.8, -0.6, 0.5, 1.4, -1.0, 0.6, 0.2]], [2.0])


@cache
def letters():
    """Not made when the tests are collected."""
    return ist_clear_reference(ARM, duration=7.0)


def test_evaluated_continuously_its_lyapunov_function_never_rises():
    V = learning.along_a_continuous_loop(made(), letters(), 1000)
    assert np.diff(V).max() <= 1e-14 * V[0]
    assert V[-1] < 0.5 * V[0]


def test_sampled_its_lyapunov_function_rises_by_the_square_of_the_step():
    rises = [learning.largest_rise(made(), letters(), rate, 0.4) for rate in (1000, 2000, 4000)]
    assert rises[0] > 1e-6
    np.testing.assert_allclose(np.log2(np.divide(rises[:-1], rises[1:])), 2.0, atol=0.3)


@pytest.mark.slow
def test_with_an_unknown_load_the_second_pass_is_a_hundred_times_better():
    learnt, run = learning.second_pass("adaptive", Twice(SHORT, 1.0))
    assert learning.only_pass(SHORT) > 100.0 * learnt
    mass, first = run.signals["adapted_payload"][-1][[0, 3]]
    assert mass == pytest.approx(3.0, rel=0.01)
    assert first == pytest.approx(3.0 * 0.078, rel=0.02)  # the flange is 78 mm from the last joint


@pytest.mark.slow
def test_with_friction_noise_and_delay_or_on_elastic_joints_it_is_ten_times_better():
    """The springs of the data file (K = 1e4 N m/rad), encoders on the links, half of the rigid arm's gain."""
    learnt, run = learning.second_pass("adaptive", Twice(letters(), 2.0), plant=learning.FRICTION, adapt_friction=True)
    assert learning.only_pass(letters(), plant=learning.FRICTION) > 10.0 * learnt
    np.testing.assert_allclose(run.signals["adapted_coulomb"][-1], learning.COULOMB, rtol=0.3)
    learnt, run = learning.second_pass("adaptive", Twice(SHORT, 1.0), plant=learning.ELASTIC, omega_n=25.0)
    assert learning.only_pass(SHORT, plant=learning.ELASTIC, omega_n=25.0) > 10.0 * learnt
    assert max(run.meta["cut_share"]) == 0.0


def test_its_linear_form_tells_where_the_sampled_loop_is_unstable():
    """A small deviation at rest grows or dies as the spectral radius says, adaptation included."""
    pose, still = SHORT.waypoints[0], point_to_point(ARM, [SHORT.waypoints[0]] * 2, [0.2])
    for gain, grows in ((10.0, False), (1e4, True)):
        law = made(adapt_gain=gain)
        radius = RestingLoop.of(learning.MODEL, law, pose[None]).radius(Sampling(1000.0))[0]
        run = lwr_dyn.simulate(ARM, law, still, q0=pose + 1e-9, saturate=False)
        error = np.linalg.norm(run.q - run.q_ref, axis=1)
        assert (radius > 1.01) == grows
        assert (error[200] > 10 * error[100]) == grows
        assert radius < 1.05


@pytest.mark.slow
def test_it_can_run_continuously_and_describes_itself():
    law = make_controller("adaptive", ARM, learning.MODEL, adapt_friction=True)
    assert isinstance(law, WithMemory)
    assert json.loads(json.dumps(describe(law)))["label"] == "adaptive (payload, friction)"
    law = make_controller("adaptive", ARM, learning.MODEL)
    run = lwr_dyn.simulate(ARM, law, letters(), payload=3.0, continuous=True, duration=0.05)
    assert np.abs(run.q - run.q_ref).max() < 1e-2


def test_the_bounds_hold_every_load_that_the_arm_carries():
    """Three times its rating, its centre within half a metre, and no mass below 0; 20 kg where it has none."""
    for arm, most in ((replace(ARM, ratings=replace(ARM.ratings, payload=5.0)), 15.0), (ARM, 20.0)):
        regressor = SlotineLiRegressor(arm)
        adapted, base = (AdaptedParameters.of(name, arm, regressor, 4.0) for name in ("payload", "base"))
        moments = [*[most / 2] * 3, *[most / 4] * 6]
        np.testing.assert_allclose(adapted.upper, [most, *moments])
        np.testing.assert_allclose(adapted.lower, [-arm.chain.links[-1].body.mass, *np.negative(moments)])
        np.testing.assert_allclose([base.upper, -base.lower], np.full((2, 43), 10 * most / 2.0))
    assert (adapted.lower < learning.THETA).all()
    assert (adapted.upper > learning.THETA).all()
    wam = lwr_dyn.load("wam7")
    friction = make_controller("adaptive", wam, adapt_friction=True).signals["adapted_coulomb"]
    assert friction[0] == pytest.approx((4.4748 + 4.3609) / 2)  # starts from the friction that was identified


EXACT = 1e-12
"""Of the largest torque: rounding."""
ARMS = {
    "lwr4plus": lwr_dyn.load("lwr4plus", reading="physical"),
    "wam7": lwr_dyn.load("wam7"),
    "on the wall": lwr_dyn.load("lwr4plus", mount={"on": "wall"}),
    "loaded": arm_with_payload(lwr_dyn.load("lwr4plus"), 3.0, [0.02, -0.05, 0.1], np.diag([0.1, 0.2, 0.25])),
}
RANDOM = np.random.default_rng(8)
FOUR = RANDOM.uniform(-2.0, 2.0, (20, 4, 7))


def test_the_regressor_is_b_c_and_g():
    for arm in ARMS.values():
        regressor, road_b = SlotineLiRegressor(arm), lwr_dyn.dynamics_of(arm, "newton-euler")
        for q, u, w, a in FOUR:
            expected = road_b.mass_matrix(q) @ a + road_b.coriolis_matrix(q, u) @ w + road_b.gravity_vector(q)
            by_columns = regressor(q, u, w, a) @ regressor.parameters + regressor.armature * a
            size = EXACT * np.abs(expected).max()
            np.testing.assert_allclose(by_columns, expected, rtol=0, atol=size)
            np.testing.assert_allclose(regressor.torque(q, u, w, a), expected, rtol=0, atol=size)


@pytest.mark.parametrize("name", ARMS)
def test_every_column_is_that_of_the_mixed_recursion(name):
    arm = ARMS[name]
    regressor = SlotineLiRegressor(arm)
    model = lwr_dyn.dynamics_of(arm).ungated.model
    data, turns = model.createData(), [True] * arm.n
    for q, u, w, a in FOUR[:8]:
        pinocchio.forwardKinematics(model, data, q)
        frames = np.array([pose.homogeneous for pose in list(data.oMi)[1:]])
        expected = mixed_regressor(frames, turns, arm.chain.gravity, u, w, a)
        np.testing.assert_allclose(regressor(q, u, w, a), expected, rtol=0, atol=EXACT * np.abs(expected).max())


def test_one_joint_has_one_row():
    """Pinocchio gives the regressor of one joint without its axis of joints."""
    arm = random_arm(0, "R")
    regressor = SlotineLiRegressor(arm)
    state = RANDOM.uniform(-2.0, 2.0, (4, 1))
    Y = regressor(*state)
    assert Y.shape == (1, 10)
    np.testing.assert_allclose(
        Y @ regressor.parameters + regressor.armature * state[3], regressor.torque(*state), rtol=EXACT
    )
