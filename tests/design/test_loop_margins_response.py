"""The loop over frequency, against its own state space and against loops cut one at a time."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.design.loop_judgement import LoopCase
from lwr_dyn.design.loop_margins import (
    frequency_grid,
    largest_sensitivity,
    loop_gain,
    refined_peaks,
    sensitivity,
    single_loops,
)
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from tests.design.margin_cases import BENT, arm, dynamics, law, sliders

HZ = frequency_grid(1000.0, 23)
Q, RNG = np.array([BENT, 0.5 * BENT]), np.random.default_rng(0)


def rigid(name):
    return RestingLoop.of(dynamics(), law(name), Q)


def fed_back(loop, **feedback):
    """The loop with other feedback too: of torques, or an integral that couples the joints as the adaptive law's."""
    return replace(loop, feedback=replace(loop.feedback, **feedback))


def torque(gain):
    return gain * np.ones((2, 1, 1)) * np.eye(7)


def elastic():
    return LoopCase(elasticity="file").loop(arm(), dynamics(), law("pd-gravity"), Q)


CASES = (
    (lambda: fed_back(rigid("pid"), integral=300.0 * RNG.normal(size=(2, 7, 7))), Sampling(1000.0, 1)),
    (lambda: rigid("pd-gravity"), Sampling(1000.0)),
    (lambda: rigid("inverse-dynamics"), Sampling(1000.0, 3)),
    (lambda: rigid("pid"), Sampling(1000.0, 1, 80.0)),
    (lambda: fed_back(elastic(), torque=torque(2.0)), Sampling(1000.0, 2)),
    (lambda: fed_back(rigid("pd-gravity"), torque=torque(0.3)), Sampling(1000.0, 1)),
)


def of_states(loop, sampling):
    """L (k, f, n, n) from the state space of the cut loop."""
    A, B, C = loop.open_loop(sampling)
    z = np.exp(2j * np.pi * HZ / sampling.rate)[:, None, None]
    return -C[:, None] @ np.linalg.solve(z * np.eye(A.shape[-1]) - A[:, None], B[:, None] + 0j)


def one_cut(loop, sampling, joint):
    """L_i (k, f): the loop cut at one joint, all others closed."""
    A, B, C = loop.open_loop(sampling)
    others = [j for j in range(loop.plant.n) if j != joint]
    A = A + B[:, :, others] @ C[:, others]
    z = np.exp(2j * np.pi * HZ / sampling.rate)[:, None, None]
    state = np.linalg.solve(z * np.eye(A.shape[-1]) - A[:, None], B[:, None, :, joint, None] + 0j)
    return -(C[:, None, joint, None] @ state)[..., 0, 0]


def test_the_gain_is_that_of_the_state_space_and_single_loops_those_of_one_cut():
    for make, sampling in CASES:
        loop = make()
        found, expected = loop_gain(loop, sampling, HZ), of_states(loop, sampling)
        size = np.abs(expected).max(axis=(0, 2, 3))[:, None, None]
        assert (np.abs(found - expected) <= 1e-8 * size).all()
    loop, sampling = rigid("pid"), Sampling(1000.0, 1)
    singles = single_loops(loop_gain(loop, sampling, HZ))
    for joint in (0, 3, 6):
        np.testing.assert_allclose(singles[:, :, joint], one_cut(loop, sampling, joint), rtol=1e-6)
    slider, grid = sliders(2.0, Kp=5e3, Kd=250.0), frequency_grid(1000.0, 20000)
    values = 1 / np.abs(1 + of_states_on(slider, Sampling(1000.0, 1), grid))
    peak, hz = refined_peaks(slider, Sampling(1000.0, 1))
    assert peak[0] == pytest.approx(values.max(), rel=1e-4)
    assert hz[0] == pytest.approx(grid[values.argmax()], rel=0.02)
    both = largest_sensitivity(sliders(2.0, 2.0, Kp=5e3, Kd=[250.0, 2.5e3]), Sampling(1000.0, 1))
    assert np.isinf(both).all()
    assert largest_sensitivity(slider, Sampling(1000.0, 1))[0, 0] == pytest.approx(values.max(), rel=2e-3)


def of_states_on(loop, sampling, hz):
    A, B, C = (part[0] for part in loop.open_loop(sampling))
    return np.array([-(C @ np.linalg.solve(z * np.eye(len(A)) - A, B))[0, 0] for z in np.exp(2j * np.pi * hz / 1000)])


def test_the_peak_bounds_what_one_gain_may_do():
    """|1 + L_i| >= 1 / Ms: a factor up to Ms / (Ms - 1) on one joint leaves the loop stable."""
    loop, sampling = rigid("pd-gravity"), Sampling(1000.0, 2)
    peaks = largest_sensitivity(loop, sampling)
    for joint in range(7):
        up = peaks[:, joint] / (peaks[:, joint] - 1 + 1e-12)
        scale = 1 + (0.99 * np.minimum(up, 1e3) - 1)[:, None] * np.eye(7)[joint]
        assert (loop.radius(sampling, scale=scale) < 1).all()


def test_sensitivity_does_not_change_with_units_and_inverse_dynamics_is_seven_equal_loops_whatever_the_pose():
    gain = loop_gain(rigid("pd-gravity"), Sampling(1000.0, 1), HZ)
    units = np.diag([1.0, 57.3, 1e3, 1e-3, 2.0, 5.0, 0.1])
    np.testing.assert_allclose(sensitivity(units @ gain @ np.linalg.inv(units)), sensitivity(gain), rtol=1e-8)
    alone = largest_sensitivity(sliders(1.0, Kp=2500.0, Kd=100.0), Sampling(1000.0, 4))[0, 0]
    np.testing.assert_allclose(largest_sensitivity(rigid("inverse-dynamics"), Sampling(1000.0, 4)), alone, rtol=2e-3)
