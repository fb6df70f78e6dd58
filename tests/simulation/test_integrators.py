"""The fast step is RK4; RK4 and the adaptive reference agree; sampled runs tend to the continuous one."""

import numpy as np
import pytest
from scipy.special import ellipk

from lwr_dyn.model.chain import JointKind
from lwr_dyn.simulation.integrators import dop853, held_rk4, rk4
from lwr_dyn.simulation.simulate import no_torque, simulate
from tests.simulation.sample_runs import Still, controllers, joint_waves, lwr, lwr_dynamics, one_joint

ROUNDING = 1e-13


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize("braked", [False, True])
def test_the_fast_step_is_rk4_and_returns_the_work_of_friction(substeps, braked):
    """Against `rk4` with that work as one more state."""
    rng, forward = np.random.default_rng(2), lwr_dynamics().ungated.forward_dynamics
    state, tau, level = rng.uniform(-1, 1, (2, 7)), rng.uniform(-5, 5, 7), rng.uniform(0, 0.1, 7) * braked

    def friction(dq):
        return level * np.tanh(dq)

    def rates(t, x):
        f = friction(x[7:14])
        return np.concatenate([x[7:14], forward(x[:7], x[7:14], tau - f), [-f @ x[7:14]]])

    after = np.zeros((2, 7))
    step, tangent = held_rk4(forward, 7, 0.01, substeps, *([friction] if braked else []))
    works = step(0.0, state, tau, after)
    plain = rk4(substeps)(rates, 0.0, np.append(state, 0.0), 0.01)
    np.testing.assert_allclose(after.ravel(), plain[:14], rtol=0, atol=ROUNDING * 100)
    assert works == (0.0, pytest.approx(plain[14], rel=1e-11))
    assert np.abs(after - state).max() > 1e-3
    if substeps == 1 and not braked:
        np.testing.assert_allclose(tangent(), state[1] + 0.01 * forward(*state, tau), rtol=1e-14)


def test_rk4_converges_with_order_four_and_a_failed_adaptive_step_is_nan():
    def rates(t, x):
        return np.array([x[1], -np.sin(x[0])])

    exact = dop853(1e-13, 1e-14)(rates, 0.0, np.array([1.0, 0.0]), 1.0)
    errors = [np.abs(rk4(m)(rates, 0.0, np.array([1.0, 0.0]), 1.0) - exact).max() for m in (10, 20)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)
    assert np.isnan(dop853()(lambda t, x: x**2, 0.0, np.array([1.0]), 2.0)).all()  # infinite at t = 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pd-gravity", "inverse-dynamics", "pid"])
@pytest.mark.parametrize("continuous", [False, True])
def test_rk4_against_dop853(name, continuous):
    options = {"duration": 0.2, "continuous": continuous, "dq0": np.full(7, 0.5)}
    a = simulate(lwr(), controllers()[name], joint_waves(), method="rk4", substeps=16 if continuous else 4, **options)
    b = simulate(lwr(), controllers()[name], joint_waves(), method="dop853", **options)
    np.testing.assert_allclose(a.q, b.q, rtol=0, atol=1e-8)
    np.testing.assert_allclose(a.dq, b.dq, rtol=0, atol=1e-6)


@pytest.mark.slow
def test_engines_agree_on_the_motion():
    runs = [
        simulate(lwr(), controllers()["pd-gravity"], joint_waves(), engine=engine, duration=0.1, q0=np.full(7, 0.2))
        for engine in ("pinocchio", "newton-euler", lwr_dynamics("newton-euler"))
    ]
    for run in runs[1:]:
        np.testing.assert_allclose(run.q, runs[0].q, rtol=0, atol=1e-11)
        np.testing.assert_allclose(np.diff(run.energy), np.diff(runs[0].energy), rtol=0, atol=1e-9)
    assert [run.meta["engine"] for run in runs] == ["pinocchio", "newton-euler", "newton-euler"]


@pytest.mark.slow
def test_sampled_tends_to_continuous():
    law, options = controllers()["pd-gravity"], {"duration": 0.3, "substeps": 2}
    q0 = joint_waves().middle + 0.02
    limit = simulate(lwr(), law, joint_waves(), continuous=True, rate=1000.0, q0=q0, **options)
    gaps = [
        np.abs(simulate(lwr(), law, joint_waves(), rate=rate, q0=q0, **options).q[-1] - limit.q[-1]).max()
        for rate in (4000.0, 8000.0)
    ]
    assert gaps[0] / gaps[1] == pytest.approx(2.0, rel=0.1)  # a hold lags by half a period


def test_continuous_pid_tends_to_the_sampled_one():
    options = {"duration": 0.2, "q0": joint_waves().middle + 0.02}
    a = simulate(lwr(), controllers()["pid"], joint_waves(), continuous=True, **options)
    b = simulate(lwr(), controllers()["pid"], joint_waves(), rate=10000.0, **options)
    np.testing.assert_allclose(a.q[-1], b.q[-1], rtol=0, atol=1e-4)


def test_pendulum_keeps_to_its_elliptic_period():
    arm = one_joint(JointKind.REVOLUTE, mass=2.0, lever=0.5, gravity=(0.0, -9.81, 0.0))
    start = np.array([-np.pi / 2 + 1.0])  # 1 rad from hanging
    small = np.sqrt(2.0 * 9.81 * 0.5 / (2.0 * (0.5**2 + 0.01)))
    period = 4 / small * ellipk(np.sin(0.5) ** 2)
    run = simulate(arm, no_torque, Still(start, period), rate=1000 / period, q0=start)
    assert run.q[-1, 0] == pytest.approx(start[0], abs=1e-9)
    assert run.q[500, 0] == pytest.approx(-np.pi / 2 - 1.0, abs=1e-9)
