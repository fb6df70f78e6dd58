"""Arguments and results of a batch: shapes, number types, strides, threads, memory, states that are not finite."""

import pickle
import tracemalloc
import warnings

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.batch import NotFiniteWarning
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.dynamics.protocol import FUNCTIONS
from lwr_dyn.foundation.errors import OptionError, ShapeError, SingularMassError
from tests.codegen.kernels.evaluate import states
from tests.codegen.rollouts.beside import first_joints

ARM = lwr_dyn.load("lwr4plus")
Q, DQ, DDQ = states(7, 41)


@pytest.fixture(scope="module")
def batch():
    return lwr_dyn.batch_dynamics(ARM)


@pytest.fixture(scope="module")
def expected(batch):
    return lwr_dyn.dynamics_of(ARM, "newton-euler").inverse_dynamics(Q, DQ, DDQ)


@pytest.mark.slow
@pytest.mark.parametrize("count", [*range(1, 20), 41])
def test_blocks_that_are_not_full_are_right_and_nothing_behind_them_is_touched(batch, expected, count):
    whole = np.full((count + 3, 7), 77.0)
    result = batch.inverse_dynamics(Q[:count], DQ[:count], DDQ[:count], out=whole[:count])
    assert np.shares_memory(result, whole)
    assert np.abs(result - expected[:count]).max() < 1e-12
    assert (whole[count:] == 77.0).all()


def test_no_state_gives_no_result(batch):
    assert batch.mass_matrix(np.zeros((0, 7))).shape == (0, 7, 7)
    assert batch.inverse_dynamics(np.zeros((0, 7)), DQ[0], DDQ[0]).shape == (0, 7)


@pytest.mark.slow
def test_rows_may_be_part_of_a_wider_array_or_one_for_all(batch, expected):
    state = np.hstack([Q, DQ, DDQ])
    assert np.abs(batch.inverse_dynamics(state[:, :7], state[:, 7:14], state[:, 14:]) - expected).max() < 1e-12
    skipped = batch.inverse_dynamics(Q[::2], DQ[::2], DDQ[::2])
    assert np.abs(skipped - expected[::2]).max() < 1e-12
    turned = batch.inverse_dynamics(np.asfortranarray(Q), DQ[::-1][::-1], DDQ)
    assert np.abs(turned - expected).max() < 1e-12
    one = batch.inverse_dynamics(Q[3], DQ, DDQ[3:4])
    assert np.abs(one - batch.inverse_dynamics(np.tile(Q[3], (41, 1)), DQ, np.tile(DDQ[3], (41, 1)))).max() < 1e-12


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


def test_five_states_that_are_not_finite_are_named():
    for count, shown in ((5, "0, 1, 2, 3, 4"), (6, "0, 1, 2, 3, 4, ...")):
        text = f"f: {count} of 9 states are not finite (index {shown}): their results are NaN"
        assert str(NotFiniteWarning("f", range(count), 9)) == text


@pytest.mark.slow
def test_a_value_that_enters_no_result_is_not_overlooked(batch):
    q = Q.copy()
    q[2, 0] = np.nan  # the first joint's angle changes neither B nor g
    with pytest.warns(NotFiniteWarning):
        assert np.isnan(batch.mass_matrix(q)[2]).all()


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
def test_sine_and_cosine_are_good_to_the_last_digits():
    """One turning joint: its pose holds both."""
    from lwr_dyn.model.arm import Arm, JointLimits
    from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind
    from lwr_dyn.model.spatial import Pose

    here = Pose.identity()
    link = ChainLink("joint_1", "link_1", JointKind.REVOLUTE, here, here, Body.massless())
    arm = Arm("hinge", "none", "", Chain((link,), here, np.zeros(3)), (JointLimits(),))
    x = np.linspace(-7, 7, 200001)[:, None]
    far = np.linspace(-1e6, 1e6, 200001)[:, None]
    bound = 3e-16  # three roundings of numbers up to 1
    for values in (x, far):
        T = lwr_dyn.batch_dynamics(arm).flange_pose(values)
        exact = values[:, 0].astype(np.longdouble)
        assert np.abs(T[:, 1, 0] - np.sin(exact)).max() < bound
        assert np.abs(T[:, 0, 0] - np.cos(exact)).max() < bound
    assert sincos("float64").most_half_turns * np.pi > 1e6


def test_a_batch_needs_no_more_memory_than_its_results(batch):
    q = np.zeros((100_000, 7))
    batch.mass_matrix(q[:10])
    tracemalloc.start()
    batch.mass_matrix(q)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.01 * 100_000 * 49 * 8


@pytest.mark.parametrize(
    ("q", "message"),
    [
        (np.zeros((3, 6)), r"q: shape \(3, 6\); allowed: \(N, 7\) or \(7,\)"),
        (np.zeros((2, 3, 7)), r"q: shape \(2, 3, 7\)"),
        (np.zeros((3, 7), dtype=np.float32), "q: number type float32; allowed: float64"),
        (np.zeros((3, 7), dtype=int), "q: number type int64"),
        ("abc", "q: number type"),
        ([[1.0], [1.0, 2.0]], "q: not an array of numbers"),
    ],
)
def test_what_does_not_fit_is_refused(batch, q, message):
    with pytest.raises(ShapeError, match=message):
        batch.gravity_vector(q)


def test_numbers_of_rows_must_fit(batch):
    with pytest.raises(ShapeError, match="q 41, dq 40, ddq 41; allowed: one number of rows"):
        batch.inverse_dynamics(Q, DQ[:40], DDQ)


@pytest.mark.parametrize(
    ("out", "message"),
    [
        (np.zeros((41, 6)), r"out: shape \(41, 6\), float64; allowed: an array of shape \(41, 7\)"),
        (np.zeros((41, 7), dtype=np.float32), "float32; allowed"),
        (np.zeros((7, 41)).T, "not contiguous"),
        (Q, "over an input"),
        ([0.0], "not an array"),
    ],
)
def test_a_place_for_the_results_must_be_one(batch, out, message):
    with pytest.raises(ShapeError, match=message):
        batch.gravity_vector(Q, out=out)


@pytest.mark.parametrize("call", [lwr_dyn.batch_dynamics, lambda arm: lwr_dyn.dynamics_of(arm, "kernels")])
def test_a_name_in_place_of_an_arm(call):
    with pytest.raises(OptionError, match="arm: 'lwr4plus'; allowed: an arm"):
        call("lwr4plus")


ENGINE, ROAD_B = lwr_dyn.dynamics_of(ARM, "kernels"), lwr_dyn.dynamics_of(ARM, "newton-euler")
X = states(7, 24)


@pytest.mark.slow
@pytest.mark.parametrize("function", FUNCTIONS)
def test_rows_of_any_form_give_the_numbers_of_road_b(function):
    arguments = X[: len(FUNCTIONS[function][0])]
    expected = getattr(ROAD_B, function)(*arguments)
    forms = (
        arguments,
        [x.tolist() for x in arguments],
        [np.asfortranarray(x) for x in arguments],
        [np.repeat(x, 2, axis=1)[:, ::2] for x in arguments],
        [x.astype(np.longdouble) for x in arguments],
    )
    close = 1e-12 * max(1.0, np.abs(expected).max())
    for given in forms:
        difference = getattr(ENGINE, function)(*given) - expected
        offset = difference.mean() if function == "potential_energy" else 0.0  # only differences mean something
        assert np.abs(difference - offset).max() < close
    block = getattr(ENGINE, function)(*(x.reshape(2, 12, 7) for x in arguments))
    assert np.array_equal(block.reshape(expected.shape), getattr(ENGINE, function)(*arguments))
    assert len(getattr(ENGINE, function)(*(x[:0] for x in arguments))) == 0


@pytest.mark.slow
@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_value_that_is_not_finite_is_named(function, value):
    names = FUNCTIONS[function][0]
    for k, name in enumerate(names):
        arguments = [x.copy() for x in X[: len(names)]]
        arguments[k][13, 4] = value
        with pytest.raises(ShapeError, match=rf"{name}: {value} at index \(13, 4\)"):
            getattr(ENGINE, function)(*arguments)


def test_large_angles_and_a_single_state_for_all():
    q = X[0].copy()
    q[3, 2] += 2e6 * np.pi
    assert np.abs(ENGINE.mass_matrix(q) - ENGINE.mass_matrix(X[0])).max() < 1e-8
    assert np.array_equal(ENGINE.bias_torque(X[0], X[1][0]), ENGINE.bias_torque(X[0], np.tile(X[1][0], (24, 1))))


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ShapeError, match="leading axes that broadcast"):
        ENGINE.bias_torque(X[0], X[1][:5])
    with pytest.raises(ShapeError, match="7 numbers, one per joint"):
        ENGINE.mass_matrix(X[0][:, :6])
    with pytest.raises(TypeError, match="1 arguments given"):
        ENGINE.bias_torque(X[0])


@pytest.mark.slow
def test_accelerations_that_are_not_determined():
    from dataclasses import replace

    from lwr_dyn.model.chain import Body

    short = first_joints(2)
    last = short.chain.links[-1]
    links = (*short.chain.links[:-1], replace(last, body=Body.massless(), rotor=None))
    arm = replace(short, chain=replace(short.chain, links=links))
    with pytest.raises(SingularMassError, match="joint 2"):
        lwr_dyn.dynamics_of(arm, "kernels").forward_dynamics(*X[..., :2])


def test_a_batch_can_be_pickled_after_it_was_used():
    batch = lwr_dyn.batch_dynamics(lwr_dyn.load("wam7"), inputs=["payload"])
    q, payload = np.random.default_rng(5).uniform(-1, 1, (4, 7)), np.array([2.0, *[0.1] * 9])
    held = batch.gravity_vector(q, payload=payload)
    assert np.array_equal(pickle.loads(pickle.dumps(batch)).gravity_vector(q, payload=payload), held)
