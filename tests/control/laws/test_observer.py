"""The estimate follows the true external torque as an ideal first-order filter would, on rigid and on moving arms."""

from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.observer import MomentumObserver
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.simulation.environment.walls_and_pushes import Push
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import Still, joint_waves, lwr, lwr_dynamics
from tests.slips import uncaught
from tests.tolerances import OBSERVER_SHARE

MODULE = "lwr_dyn.control.laws.observer"
NOTHING = 1e-4
"""[N m] What the trapezoid of b leaves in half a second of a fast movement: 1e-5; an Euler step leaves 1e-2."""
POSE = np.array([0.3, 0.8, -0.2, -1.2, 0.4, 0.7, 0.1])


def ideal(t, tau, gain):
    """The filter dr/dt = gain (tau - r) of torques (k, n) that are straight between the samples, exactly."""
    T, r = t[1] - t[0], np.zeros_like(tau)
    a = np.exp(-gain * T)
    last = (1 - a) / (gain * T)  # weights of both ends: the integral of exp(-gain (T - s)) gain over the line
    for k in range(1, len(t)):
        r[k] = a * r[k - 1] + (last - a) * tau[k - 1] + (1 - last) * tau[k]
    return r


def estimate(run, observer):
    """What an observer makes of a run's samples."""
    last = [None, *run.tau_applied[:-1]]
    return np.array([observer(*sample) for sample in zip(run.t.tolist(), run.q, run.dq, last, strict=True)])


def push(at="flange", force=(15.0, -10.0, 12.0), rise=0.02):
    return Push(lwr(), force, start=0.05, duration=0.3, rise=rise, at=at)


@cache
def moving(external, **options):
    """A push while the arm moves and gives way: its direction stays, the true torque changes with the pose."""
    law = lwr_dyn.controller("inverse-dynamics", lwr(), omega_n=15.0)
    return simulate(lwr(), law, joint_waves(), duration=0.4, external=external, **options)


@cache
def pushed():
    return moving(push())


@pytest.mark.slow
@pytest.mark.parametrize(("gain", "rise"), [(20.0, 0.02), (50.0, 0.02), (100.0, 0.02), (200.0, 0.05)])
@pytest.mark.parametrize("at", ["flange", "link_3"])
def test_within_a_thousandth_of_the_ideal_filter_for_a_moving_push(gain, rise, at):
    """Faster pushes leave more, K_O T^2 / 12 times their slope: a torque that is not constant within a sample."""
    run = moving(push(at, rise=rise))
    true = run.signals["tau_external"]
    error = estimate(run, MomentumObserver(lwr_dynamics(), gain)) - ideal(run.t, true, gain)
    assert np.linalg.norm(error, axis=1).max() <= OBSERVER_SHARE * np.linalg.norm(true, axis=1).max()
    if at == "flange":
        assert np.ptp(true[100:300], axis=0).max() > 0.2  # the force is held, the pose is not


def test_an_euler_step_in_place_of_the_exact_form_would_not_be():
    """What the exact form is for: the textbook's Euler step, on the same run."""
    run, gain, T = pushed(), 50.0, 1e-3
    raw, r, total, start, last = lwr_dynamics().ungated, np.zeros(7), np.zeros(7), None, np.zeros(7)
    rows = []
    for q, dq, tau in zip(run.q, run.dq, [np.zeros(7), *run.tau_applied[:-1]], strict=True):
        p = raw.mass_matrix(q) @ dq
        if start is None:
            start = p
        else:
            total = total + T * (tau + last + r)
            r = gain * (p - start - total)
        last = dq @ raw.coriolis_matrix(q, dq) - raw.gravity_vector(q)
        rows.append(r)
    true = run.signals["tau_external"]
    error = np.linalg.norm(np.array(rows) - ideal(run.t, true, gain), axis=1).max()
    assert error > 4 * OBSERVER_SHARE * np.linalg.norm(true, axis=1).max()


def test_nothing_is_seen_where_nothing_acts():
    run = moving(None)
    r = estimate(run, MomentumObserver(lwr_dynamics(), 50.0))
    assert np.abs(r).max() < NOTHING


def test_an_unknown_payload_is_seen_as_its_weight():
    """Held still, the estimate of a load that the model lacks tends to the load's weight at the joints."""
    load = 0.3
    law = lwr_dyn.controller("inverse-dynamics", lwr(), omega_n=15.0)
    run = simulate(lwr(), law, Still(POSE, 0.8), payload=load)
    r = estimate(run, MomentumObserver(lwr_dynamics(), 50.0))
    end = run.q[-1]
    weight = lwr_dynamics().gravity_vector(end) - lwr_dyn.dynamics_of(arm_with_payload(lwr(), load)).gravity_vector(end)
    assert np.abs(weight).max() > 1.0
    np.testing.assert_allclose(r[-1], weight, rtol=0, atol=0.02 * np.abs(weight).max())


def test_rows_of_states_are_observed_as_single_ones():
    run, gain = pushed(), 50.0
    alone = estimate(run, MomentumObserver(lwr_dynamics(), gain))
    rows = MomentumObserver(lwr_dynamics(), gain)
    rows.sample_every(1e-3)
    for k, (q, dq) in enumerate(zip(run.q[:50], run.dq[:50], strict=True)):
        q, dq = np.tile(q, (3, 1)), np.tile(dq, (3, 1))
        p = np.einsum("kij,kj->ki", lwr_dynamics().mass_matrix(q), dq)
        b = np.einsum("kij,ki->kj", lwr_dynamics().coriolis_matrix(q, dq), dq) - lwr_dynamics().gravity_vector(q)
        r = rows.advance(p, b, np.tile(run.tau_applied[max(k - 1, 0)], (3, 1)))
        np.testing.assert_allclose(np.broadcast_to(r, (3, 7)), np.tile(alone[k], (3, 1)), rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("gain", "error", "words"),
    [
        (0.0, OptionError, "observer gain: .*above 0"),
        (-50.0, OptionError, "observer gain: .*above 0"),
        (np.nan, ShapeError, "observer gain"),
        ([50.0, 50.0], ShapeError, "observer gain"),
    ],
)
def test_gains_that_are_none_are_refused(gain, error, words):
    with pytest.raises(error, match=words):
        MomentumObserver(lwr_dynamics(), gain)


def test_a_gain_too_fast_for_the_rate_is_refused_in_one_line():
    law = lwr_dyn.controller("inverse-dynamics+observer", lwr(), observer_gain=1001.0)
    with pytest.raises(OptionError, match="observer gain: 1001 1/s; allowed: at most the rate, 1000 1/s") as fault:
        simulate(lwr(), law, Still(POSE, 0.01))
    assert "\n" not in str(fault.value)
    simulate(lwr(), law, Still(POSE, 0.01), rate=2000.0)


SLIPS = (
    ("- self._gravity(q)", "+ self._gravity(q)"),
    ("dq @ self._coriolis(q, dq)", "self._coriolis(q, dq) @ dq"),
    ("- tau - (b + b_last) / 2", "+ tau - (b + b_last) / 2"),
    ("- (b + b_last) / 2", "- b_last"),
    ("(p - p_last) / self.interval", "(p - p_last) * self.interval"),
    ("-np.expm1(-self.gain * interval)", "self.gain * interval"),
    ("self._weight * (mean - self.r)", "self._weight * mean"),
    ("self._last = p, b\n        return self.r\n", "return self.r\n"),
    ("p = p - self._rotor * dq", "p = p + self._rotor * dq"),
)
"""Signs, a missing transpose, Euler steps, a filter that does not forget, a state that is kept, the rotor's side."""


def check(module):
    """The estimate against the ideal filter, pushed and not; with rotors taken off, against the links' own momentum."""
    run, gain = pushed(), 50.0
    true = run.signals["tau_external"]
    error = estimate(run, module.MomentumObserver(lwr_dynamics(), gain)) - ideal(run.t, true, gain)
    assert np.linalg.norm(error, axis=1).max() <= OBSERVER_SHARE * np.linalg.norm(true, axis=1).max()
    assert np.abs(estimate(moving(None), module.MomentumObserver(lwr_dynamics(), gain))).max() < NOTHING
    rotor = lwr().armature + 0.1
    links = module.MomentumObserver(lwr_dynamics(), gain, rotor)
    turned = np.gradient(run.dq, run.t, axis=0)
    seen = estimate(run, links)
    expected = ideal(run.t, true - rotor * turned, gain)
    np.testing.assert_allclose(seen[150:], expected[150:], rtol=0, atol=0.05)


def test_planted_slips_are_caught():
    assert not uncaught(MODULE, SLIPS, check)
