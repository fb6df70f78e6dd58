"""One step of the exponential: exact where the motion is linear, of order 3 where it is not."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.model.transmission import JointElasticity
from lwr_dyn.simulation.elastic.exponential import WEIGHTS, HeldExponential, MatrixExponential
from lwr_dyn.simulation.elastic.plant import ElasticDynamics, FullElasticDynamics
from lwr_dyn.simulation.plant import Encoder
from tests.simulation.elastic.elastic_arms import physical, short_run, states

FREE = SimpleNamespace(friction=None, sides=np.zeros(14), at_rest=np.zeros(14, dtype=bool))
TAU = np.concatenate([np.zeros(7), np.linspace(20.0, -3.0, 7)])


def exact(model, state, tau, h, friction=lambda dx: 0.0, external=lambda t, x, dx: 0.0):
    """SciPy's Radau, with the works of dampers, friction and external torques as states."""

    def rates(t, y):
        x, dx = y[:14], y[14:28]
        lost, push = friction(dx) * np.ones(14), external(t, x, dx) * np.ones(14)
        ddx = model.forward_dynamics(x, dx, tau - lost + push)
        return np.concatenate([dx, ddx, [model.damper_power(dx), -lost @ dx, push @ dx]])

    y0 = np.concatenate([state.ravel(), np.zeros(3)])
    return solve_ivp(rates, (0.0, h), y0, method="Radau", rtol=1e-10, atol=1e-13).y[:, -1]


def stepped(model, state, h, mode=FREE, **options):
    held, after = HeldExponential(model, mode, h, **options), np.zeros((2, 14))
    assert held.damped == 0.0
    return held, after, held.step(0.0, state, TAU, after)


def test_the_weights_integrate_polynomials_of_degree_nine():
    nodes = np.linspace(0.0, 1.0, 9)
    assert [WEIGHTS @ nodes**k for k in range(10)] == pytest.approx([1 / (k + 1) for k in range(10)], rel=1e-13)


def push(t, x, dx):
    return np.concatenate([3.0 * np.sin(300 * t) - 50.0 * x[:7] - 0.1 * dx[:7] + x[0], np.zeros(7)])


@pytest.mark.parametrize("factor", [1.0, 1e4])
@pytest.mark.parametrize("external", [None, push])
def test_a_step_against_radau(factor, external):
    """With an external torque that changes with time, place and speed too; springs not turned at the start."""
    own = physical().elasticity
    model = ElasticDynamics(physical(), JointElasticity(factor * own.stiffness, factor * own.damping))
    state = states(4, 1)[0]
    if factor > 1.0 or external is not None:
        state[:, 7:] = state[:, :7]
    held, after, works = stepped(model, state, 1e-3, substeps=4, external=external)
    expected = exact(model, state, TAU, 1e-3, external=external or (lambda t, x, dx: 0.0))
    assert np.abs(after[0] - expected[:14]).max() <= 1e-8
    assert held.damped == pytest.approx(expected[28], rel=3e-2)
    assert external is None or works[2] == pytest.approx(expected[30], rel=1e-4)


@pytest.mark.parametrize("kind", [ElasticDynamics, FullElasticDynamics])
def test_a_step_with_friction_is_that_of_radau(kind):
    model, state = kind(physical(), physical().elasticity), states(9, 1)[0]
    mode = SimpleNamespace(**vars(FREE) | {"friction": lambda dx: np.repeat([0.0, 4.0], 7) * dx})
    expected, after = exact(model, state, TAU, 5e-4, mode.friction), np.zeros((2, 14))
    held = HeldExponential(model, mode, 5e-4, 2)
    works = held.step(0.0, state, TAU, after)
    assert np.abs(after[0] - expected[:14]).max() <= 2e-9
    assert np.isclose(held.damped, expected[28], rtol=0.05)
    assert np.isclose(works[1], expected[29], rtol=1e-4)


def test_its_order_is_three():
    model, state, after, ends = (
        ElasticDynamics(physical(), physical().elasticity),
        states(9, 1)[0],
        np.zeros((2, 14)),
        [],
    )
    state[:, 7:] = state[:, :7]
    for substeps in (1, 2, 4, 64):
        HeldExponential(model, FREE, 1e-3, substeps).step(0.0, state, TAU, after)
        ends.append(after[0].copy())
    errors = np.abs(np.array(ends[:3]) - ends[3]).max(axis=1)
    assert np.log2(errors[:-1] / errors[1:]).min() > 2.5


def test_friction_and_a_motor_at_rest():
    at_rest = np.arange(14) == 9
    slope = np.repeat([0.0, 4.0], 7) * ~at_rest
    mode = SimpleNamespace(friction=lambda dx: slope * dx, sides=np.ones(14), at_rest=at_rest)
    model = ElasticDynamics(physical(), physical().elasticity)
    state = states(6, 1)[0]
    state[1, 7:] = state[1, :7]
    state[1, 9] = 0.0
    _, after, works = stepped(model, state, 2e-4, mode, substeps=2)
    assert (after[0, 9], after[1, 9]) == (state[0, 9], 0.0)

    def held(t, x, dx):
        """What holds the motor: friction as strong as what drives it."""
        return np.eye(14)[9] * -(TAU[9] - model.gear_torque(x, dx)[2])

    expected = exact(model, state, TAU, 2e-4, mode.friction, held)
    assert np.abs(after.ravel()[:14] - expected[:14]).max() <= 1e-9
    assert works == pytest.approx((0.0, expected[29]), rel=1e-5)


class Reader:
    """A law that stores what it is given; its torque is constant."""

    def __init__(self):
        self.given, self.read, self.signals = [], [], {}

    def sense(self, readings):
        self.read.append([getattr(readings, x).copy() for x in ("theta", "dtheta", "q", "dq", "torque")])

    def __call__(self, t, q, dq, q_ref, dq_ref, ddq_ref):
        self.given.append((q.copy(), dq.copy()))
        self.signals = {"count": np.array([float(len(self.given))])}
        return np.full(7, 1e3)


@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize("side", ["motor", "link"])
def test_one_side_is_given_and_both_are_read(side, delay):
    law = Reader()
    run = short_run(law, encoders=side, duration=0.01, delay=delay)
    motor, link = (run.signals["theta"], run.signals["dtheta"]), (run.q, run.dq)
    assert np.array_equal(np.array(law.given).swapaxes(0, 1), motor if side == "motor" else link)
    assert np.array_equal(np.array(law.read).swapaxes(0, 1), (*motor, *link, run.signals["torque_sensor"]))
    assert run.signals["count"][:, 0].tolist() == [float(k) for k in range(1, 12)]
    assert np.array_equal(run.tau_applied, np.tile(physical().effort, (11, 1)))


def test_encoders_and_their_filters_are_between_the_arm_and_the_law():
    law = Reader()
    run = short_run(law, duration=0.01, encoder=Encoder(noise=1e-4))
    gap = np.array([q for q, _ in law.given]) - run.signals["theta"]
    assert 1e-5 < gap.std() < 1e-3
    assert np.array_equal([read[0] for read in law.read], [q for q, _ in law.given])
    assert np.array_equal([read[4] for read in law.read], run.signals["torque_sensor"])


def test_a_torque_of_another_shape_names_the_sample_and_a_law_without_signals_leaves_none():
    with pytest.raises(ShapeError, match=r"torque of the controller at sample 0: shape .14,.; allowed: 7 numbers"):
        short_run(lambda t, q, dq, *rest: np.zeros(14))
    run = short_run(lambda t, q, dq, *rest: np.zeros(7), duration=0.005)
    assert set(run.signals) == {"theta", "dtheta", "torque_sensor"}


@pytest.mark.parametrize("size", [1e-12, 0.1, 0.64, 0.65, 3.0, 30.0])
def test_any_size_as_scipy(size):
    for seed in range(10):
        A = np.random.default_rng(seed).normal(size=(9, 9))
        A *= size / np.abs(A).sum(axis=0).max()
        expected = expm(A)
        assert np.abs(MatrixExponential(9).of(A) - expected).max() <= 1e-13 * np.abs(expected).max()


def test_fast_decay_beside_slow_motion_keeps_its_digits():
    A = np.array([[0.0, 1.0], [-1e6, -1e4]])
    slow = -2e6 / (1e4 + np.sqrt(1e8 - 4e6))
    expected = np.exp(slow) * np.array([1.0, slow])  # from x = 1 on the slow mode
    assert MatrixExponential(2).of(A) @ [1.0, slow] == pytest.approx(expected, abs=1e-12)


def test_the_result_of_one_use_does_not_change_the_next_and_what_is_not_finite_stays_so():
    exponential, A = MatrixExponential(3), np.diag([1.0, -2.0, 5.0])
    first = exponential.of(A).copy()
    exponential.of(np.ones((3, 3)))
    assert np.array_equal(exponential.of(A), first)
    assert np.array_equal(exponential.of(np.zeros((3, 3))), np.eye(3))
    for value in (np.nan, np.inf):
        assert np.isnan(exponential.of(np.diag([value, 0.0, 0.0]))).all()
