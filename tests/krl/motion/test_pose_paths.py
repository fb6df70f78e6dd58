"""The two passes: inside all bounds at both ends of every step, and as fast as a linear program says."""

import numpy as np
import pytest
from scipy.optimize import linprog

from lwr_dyn.krl.motion.pose_paths import PathLimits, fastest_speeds, profile_along, seconds_at, times_along


def limits_of(seed, k=40, m=3):
    """Bounds along a smooth curve in m dimensions."""
    rng = np.random.default_rng(seed)
    s = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.02, 0.98, k - 2)]))
    size, phase, pace = rng.uniform(0.5, 2, m), rng.uniform(0, 6, m), rng.uniform(1, 9, m)
    first = size * np.cos(np.outer(s, pace) + phase)
    second = -size * pace * np.sin(np.outer(s, pace) + phase)
    return PathLimits(s, rng.uniform(0.5, 4.0, k), first, second, np.ones((k, m)))


def rows_of(limits):
    """The bounds as |A x| <= b, with u = (x_(k+1) - x_k) / 2 h."""
    k = len(limits.s)
    U = (np.eye(k)[1:] - np.eye(k)[:-1]) / (2.0 * np.diff(limits.s)[:, None])
    rows, most = [], []
    for i in range(limits.first.shape[1]):
        for at in (slice(None, -1), slice(1, None)):
            rows.append(limits.first[at, i, None] * U + limits.second[at, i, None] * np.eye(k)[at])
            most.append(limits.most[at, i])
    return np.vstack(rows), np.concatenate(most)


@pytest.mark.parametrize(("seed", "k"), [*((i, 40) for i in range(10)), *((i, 9) for i in range(6))])
def test_fastest_speeds_against_a_linear_program(seed, k):
    limits = limits_of(seed, k)
    x, (A, b) = fastest_speeds(limits), rows_of(limits)
    assert x[0] == x[-1] == 0.0
    assert (x >= 0.0).all()
    assert (x <= limits.fastest + 1e-9).all()
    assert (np.abs(A @ x) <= b + 1e-7).all()
    bounds = [(0.0, c) for c in limits.fastest]
    bounds[0] = bounds[-1] = (0.0, 0.0)
    best = linprog(-np.ones(k), A_ub=np.vstack([A, -A]), b_ub=np.concatenate([b, b]), bounds=bounds)
    assert x.sum() > (0.97 if k == 40 else 0.8) * -best.fun


def test_no_bound_asks_for_a_speed_below_zero():
    """After a straight part a bound that slows down hard: entered too fast, only a negative x would keep it."""
    s, ones = np.arange(7.0), np.ones((7, 1))
    limits = PathLimits(s, np.full(7, 100.0), ones, 5.0 * (s > 2.5)[:, None], ones)
    (A, b), x = rows_of(limits), fastest_speeds(limits)
    assert (np.abs(A @ x) <= b + 1e-9).all()
    assert x[2] > 1.0


def test_a_straight_path_is_a_trapezoid():
    s = np.linspace(0.0, 0.4, 401)
    ones = np.ones((401, 1))
    x = fastest_speeds(PathLimits(s, np.full(401, 0.25), ones, 0.0 * ones, 2.0 * ones))
    assert times_along(s, x)[-1] == pytest.approx(0.4 / 0.5 + 0.5 / 2.0, rel=1e-5)
    profile = profile_along(s, x)
    t = np.linspace(0.0, profile.duration, 777)
    sample = profile.at(t)
    assert np.abs(seconds_at(profile, sample.s[1:-1]) - t[1:-1]).max() < 1e-9
    assert np.abs(np.gradient(sample.s, t)[1:-1] - sample.ds[1:-1]).max() < 0.01
    assert profile.length == pytest.approx(0.4)


def test_a_stop_ahead_is_always_possible():
    """Six motions of 0.1 with one known ahead: never faster than a stop at the end of the next one allows."""
    s = np.linspace(0.0, 0.6, 601)
    ones, ends = np.ones((601, 1)), [100, 200, 300, 400, 500, 600]
    limits = PathLimits(s, np.full(601, 100.0), ones, 0.0 * ones, ones)
    all_known, ahead = fastest_speeds(limits), fastest_speeds(limits, ends, [1] * 6)
    assert all_known[300] == pytest.approx(2 * 0.3)
    assert ahead[ends[:-2]] == pytest.approx([2 * 0.1] * 4)
    assert ahead[250] == pytest.approx(2 * 0.15)
    assert (ahead <= all_known + 1e-12).all()
    assert fastest_speeds(limits, ends, [6] * 6) == pytest.approx(all_known)
