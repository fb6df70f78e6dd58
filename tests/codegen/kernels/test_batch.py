"""Arguments and results of a batch: shapes, number types, strides, threads, memory, states that are not finite."""

import os
import pickle
import tracemalloc
import warnings

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.batch import NotFiniteWarning
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind
from lwr_dyn.model.spatial import Pose
from tests.codegen.kernels.evaluate import states
from tests.random_arms import random_arm

ARM = lwr_dyn.load("lwr4plus")
Q, DQ, DDQ = states(7, 41)


@pytest.fixture(scope="module")
def batch():
    return lwr_dyn.batch_dynamics(ARM)


@pytest.fixture(scope="module")
def small():
    """An arm of three joints, one of which slides, and its batch."""
    arm = random_arm(5, "RPR")
    return arm, lwr_dyn.batch_dynamics(arm)


@pytest.fixture(scope="module")
def expected(batch):
    return lwr_dyn.dynamics_of(ARM, "newton-euler").inverse_dynamics(Q, DQ, DDQ)


@pytest.mark.parametrize("name", [
    "inverse_dynamics", "forward_dynamics", "coriolis_matrix", "bias_torque", "mass_matrix", "gravity_vector",
    "potential_energy",
])  # fmt: skip
def test_each_function_is_that_of_the_recursion(small, name):
    arm, batch = small
    plain = lwr_dyn.dynamics_of(arm, "newton-euler")
    given = {"inverse_dynamics": 3, "forward_dynamics": 3, "coriolis_matrix": 2, "bias_torque": 2}.get(name, 1)
    x = states(3, 5)[:given]
    np.testing.assert_allclose(getattr(batch, name)(*x), getattr(plain, name)(*x), rtol=1e-11, atol=1e-11)


def test_one_row_serves_all_states_and_one_state_is_a_row(small):
    arm, batch = small
    q, dq, ddq = states(3, 5)
    plain = lwr_dyn.dynamics_of(arm, "newton-euler").inverse_dynamics
    for one in (q[0], q[:1]):
        each = plain(np.tile(q[0], (5, 1)), dq, ddq)
        np.testing.assert_allclose(batch.inverse_dynamics(one, dq, ddq), each, rtol=1e-11, atol=1e-11)
        alone = batch.inverse_dynamics(one, dq[0], ddq[0])
        np.testing.assert_allclose(alone, each[:1], rtol=1e-11, atol=1e-11)
    for none in (batch.inverse_dynamics(q[:0], dq[:0], ddq[:0]), batch.inverse_dynamics(q[:0], dq[:1], ddq[0])):
        assert none.shape == (0, 3)


def test_energy_of_motion_pose_jacobian_and_regressor_are_those_of_the_chain(small):
    arm, batch = small
    q, dq, ddq = states(3, 5)
    bare = newton_euler_dynamics(arm.chain, rotors="none")
    found = np.einsum("kij,j->ki", batch.torque_regressor(q, dq, ddq), inertial_parameters(arm.chain).ravel())
    for one, expected in (
        (batch.kinetic_energy(q, dq), 0.5 * np.einsum("ki,kij,kj->k", dq, batch.mass_matrix(q), dq)),
        (batch.flange_pose(q), lwr_dyn.forward_kinematics(arm, q)),
        (batch.jacobian(q), jacobian(arm.chain, q)),
        (found, bare.inverse_dynamics(q, dq, ddq)),
    ):
        np.testing.assert_allclose(one, expected, rtol=1e-11, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("count", [*range(20), 41])
def test_blocks_that_are_not_full_are_right_and_nothing_behind_them_is_touched(batch, expected, count):
    whole = np.full((count + 3, 7), 77.0)
    result = batch.inverse_dynamics(Q[:count], DQ[:count], DDQ[:count], out=whole[:count])
    assert np.abs(whole[:count] - expected[:count]).max(initial=0.0) < 1e-12
    assert result.base is whole
    assert (whole[count:] == 77.0).all()


def test_threads_are_one_or_as_many_as_processors(batch):
    assert (batch.threads, lwr_dyn.batch_dynamics(ARM, threads=None).threads) == (1, os.cpu_count())


def test_no_state_gives_no_result_and_a_name_is_no_arm(batch):
    assert batch.mass_matrix(np.zeros((0, 7))).shape == (0, 7, 7)
    assert batch.inverse_dynamics(np.zeros((0, 7)), DQ[0], DDQ[0]).shape == (0, 7)
    for call in (lwr_dyn.batch_dynamics, lambda arm: lwr_dyn.dynamics_of(arm, "kernels")):
        with pytest.raises(OptionError, match="arm: 'lwr4plus'; allowed: an arm"):
            call("lwr4plus")


@pytest.mark.slow
def test_rows_may_be_part_of_a_wider_array_or_one_for_all(batch, expected):
    state = np.hstack([Q, DQ, DDQ])
    for given, wanted in (
        ((state[:, :7], state[:, 7:14], state[:, 14:]), expected),
        ((Q[::2], DQ[::2], DDQ[::2]), expected[::2]),
        ((np.asfortranarray(Q), DQ[::-1][::-1], DDQ), expected),
        ((Q[3], DQ, DDQ[3:4]), batch.inverse_dynamics(np.tile(Q[3], (41, 1)), DQ, np.tile(DDQ[3], (41, 1)))),
    ):
        assert np.abs(batch.inverse_dynamics(*given) - wanted).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("function", ["potential_energy", "mass_matrix", "gravity_vector"])
@pytest.mark.parametrize("threads", [2, 3])
def test_threads_give_the_same_numbers(batch, function, threads):
    q = np.random.default_rng(2).uniform(-2, 2, (10001, 7))
    several = lwr_dyn.batch_dynamics(ARM, threads=threads)
    assert np.array_equal(getattr(several, function)(q), getattr(batch, function)(q))


def test_states_that_are_not_finite_are_named_and_the_rest_computed(batch, expected):
    q, ddq = Q.copy(), DDQ.copy()
    q[17, 3], q[5, 0], ddq[40, 6] = np.nan, np.inf, -np.inf
    with pytest.warns(NotFiniteWarning, match=r"inverse_dynamics: 3 of 41 states .*index 5, 17, 40") as caught:
        result = batch.inverse_dynamics(q, DQ, ddq)
    assert caught[0].message.indices == (5, 17, 40)
    assert caught[0].filename == __file__
    bad = np.isin(np.arange(41), (5, 17, 40))
    assert np.isnan(result[bad]).all()
    assert np.abs(result[~bad] - expected[~bad]).max() < 1e-12
    q[[5, 17], [0, 3]], ddq[40, 6] = (3e7, -4e8), 0.0  # turned many times: whole turns are taken off
    turned = lwr_dyn.dynamics_of(ARM, "newton-euler").inverse_dynamics(q, DQ, ddq)
    assert np.abs(batch.inverse_dynamics(q, DQ, ddq) - turned).max() < 1e-12
    q[2, 0] = np.nan  # the first joint's angle changes neither B nor g, and is not overlooked
    with pytest.warns(NotFiniteWarning, match="index 2"):
        assert np.isnan(batch.mass_matrix(q)[2]).all()


@pytest.mark.parametrize(("count", "shown"), [(5, "0, 1, 2, 3, 4"), (6, "0, 1, 2, 3, 4, ...")])
def test_five_states_that_are_not_finite_are_named(count, shown):
    text = f"f: {count} of 9 states are not finite (index {shown}): their results are NaN"
    assert str(NotFiniteWarning("f", range(count), 9)) == text


@pytest.mark.slow
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_angles_of_any_size_are_taken_off_whole_turns(dtype):
    batch = lwr_dyn.batch_dynamics(ARM, dtype=dtype)
    q = np.random.default_rng(3).uniform(-1, 1, (300, 7)) * np.logspace(0, 9, 300)[:, None]
    q = q.astype(dtype)
    exact = lwr_dyn.forward_kinematics(ARM, q.astype(np.float64))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = batch.flange_pose(q)
    assert np.abs(result - exact).max() < (4e-15 if dtype == "float64" else 2e-6)


@pytest.mark.slow
@pytest.mark.parametrize("largest", [7.0, 1e6])
def test_sine_and_cosine_are_good_to_the_last_digits(largest):
    """One turning joint: its pose holds both; 3e-16 are three roundings of numbers up to 1."""
    here = Pose.identity()
    link = ChainLink("joint_1", "link_1", JointKind.REVOLUTE, here, here, Body.massless())
    arm = Arm("hinge", "none", "", Chain((link,), here, np.zeros(3)), (JointLimits(),))
    x = np.linspace(-largest, largest, 200001)[:, None]
    T, exact = lwr_dyn.batch_dynamics(arm).flange_pose(x), x[:, 0].astype(np.longdouble)
    assert np.abs(T[:, 1, 0] - np.sin(exact)).max() < 3e-16
    assert np.abs(T[:, 0, 0] - np.cos(exact)).max() < 3e-16
    assert sincos("float64").most_half_turns * np.pi > 1e6


def test_a_batch_needs_no_more_memory_than_its_results(batch):
    q = np.zeros((100_000, 7))
    batch.mass_matrix(q[:10])
    tracemalloc.start()
    batch.mass_matrix(q)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.01 * 100_000 * 49 * 8


def gravity(q=Q, **options):
    return lambda batch: batch.gravity_vector(q, **options)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (gravity(np.zeros((3, 6))), r"q: shape \(3, 6\); allowed: \(N, 7\) or \(7,\)"),
        (gravity(np.zeros((2, 3, 7))), r"q: shape \(2, 3, 7\)"),
        (gravity(np.zeros((3, 7), dtype=np.float32)), "q: number type float32; allowed: float64"),
        (gravity(np.zeros((3, 7), dtype=int)), "q: number type int64"),
        (gravity("abc"), "q: number type"),
        (gravity([[1.0], [1.0, 2.0]]), "q: not an array of numbers"),
        (lambda batch: batch.inverse_dynamics(Q, DQ[:40], DDQ), "q 41, dq 40, ddq 41; allowed: one number of rows"),
        (gravity(out=np.zeros((41, 6))), r"out: shape \(41, 6\), float64; allowed: an array of shape \(41, 7\)"),
        (gravity(out=np.zeros((41, 7), dtype=np.float32)), "float32; allowed"),
        (gravity(out=np.zeros((7, 41)).T), "out: not contiguous, .*; allowed: an array as numpy.empty makes it"),
        (gravity(out=np.broadcast_to(np.zeros(7), (41, 7))), "not contiguous"),
        (gravity(out=Q), "over an input"),
        (gravity(out=[0.0]), "out: not an array"),
    ],
)
def test_what_does_not_fit_is_refused(batch, call, message):
    with pytest.raises(ShapeError, match=message):
        call(batch)


def test_a_batch_can_be_pickled_after_it_was_used():
    batch = lwr_dyn.batch_dynamics(lwr_dyn.load("wam7"), inputs=["payload"])
    q, payload = np.random.default_rng(5).uniform(-1, 1, (4, 7)), np.array([2.0, *[0.1] * 9])
    held = batch.gravity_vector(q, payload=payload)
    assert np.array_equal(pickle.loads(pickle.dumps(batch)).gravity_vector(q, payload=payload), held)
