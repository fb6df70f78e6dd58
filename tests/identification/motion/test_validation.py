"""Parts of the motion fit by themselves: which motions are kept, whiteness, bands of speed, where numbers come from."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.motion.identifiable import MissingMotion, _swings, correlated_groups, missing, together
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.validation import (
    LAGS,
    Folds,
    motion_pieces,
    residuals_of,
    speed_bands,
    whiteness_of,
)  # fmt: skip
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import JointLimits
from tests.codegen.rollouts.beside import first_joints
from tests.identification.plants import perturbed_plant, random_motion, simulated_log, simulated_samples
from tests.simulation.sample_runs import with_limits


def samples(speeds, recording):
    dq = np.asarray(speeds, dtype=float)
    zeros = np.zeros(dq.shape)
    number = np.asarray(recording)
    names = tuple(f"log {i}" for i in range(number.max() + 1))
    return Samples(np.arange(len(dq)) * 0.01, zeros, dq, zeros, zeros, np.ones(dq.shape, bool), number, names)


def test_whole_recordings_are_dealt_where_there_are_enough():
    number = np.repeat([0, 1, 2, 3], [5, 3, 4, 2])
    fold = motion_pieces(samples(np.ones((14, 2)), number), 3)
    assert fold.tolist() == [0] * 5 + [1] * 3 + [2] * 4 + [0] * 2


def test_one_recording_is_cut_where_its_fastest_joint_is_slowest():
    t = np.arange(300) / 300.0
    dq = np.column_stack([np.abs(np.sin(3 * np.pi * t)), np.zeros(300)])  # rests near 100 and 200
    dq[:, 1] = 50.0 * (np.abs(t - 0.36) < 0.05)  # a share of its own largest speed counts: 92 to 123 is fast
    fold = motion_pieces(samples(dq, np.zeros(300, int)), 3)
    cuts = np.flatnonzero(np.diff(fold)) + 1
    assert (fold[0], fold[-1], len(cuts)) == (0, 2, 2)
    assert abs(cuts[1] - 200) <= 1
    assert 70 <= cuts[0] <= 93 or 123 <= cuts[0] <= 130


@pytest.mark.parametrize("folds", [1, 15])
def test_as_many_folds_as_there_can_be(folds):
    with pytest.raises(OptionError, match=r"folds: \d+; allowed: 2 to 14"):
        motion_pieces(samples(np.ones((14, 2)), np.zeros(14, int)), folds)


def memory(phi, count, seed=0):
    """Noise that keeps a share phi from row to row, (count, 1)."""
    return lfilter([1.0], [1.0, -phi], np.random.default_rng(seed).normal(size=count))[:, None]


def test_the_statistic_of_white_noise_is_that_of_chi_squared_with_instants_left_out():
    found = []
    for seed in range(300):
        e = memory(0.0, 400, seed)
        e[np.random.default_rng(seed).uniform(size=400) < 0.3] = np.nan
        found.append(whiteness_of(e, np.zeros(400, int))[0])
    shares = [np.mean([w.probability < level for w in found]) for level in (0.05, 0.5)]
    assert shares == pytest.approx([0.05, 0.5], abs=0.07)
    assert np.mean([w.white for w in found]) > 0.97


def test_correlated_noise_is_seen_and_its_inflation_is_that_of_a_mean():
    """An autoregressive noise of 0.6: r_k = 0.6^k, and a mean is sqrt(1.6 / 0.4) = 2 times as uncertain."""
    (w,) = whiteness_of(memory(0.6, 40_000), np.zeros(40_000, int))
    assert w.autocorrelation[:3] == pytest.approx([0.6, 0.36, 0.216], abs=0.02)
    assert not w.white
    assert w.inflation == pytest.approx(2.0, rel=0.05)


def test_what_a_fit_takes_up_of_slow_noise_is_given_back():
    """A fit of 16 slow columns to noise that keeps .9 from row to row: a mean of it is 4.36 times less certain.

    Without that the errors are too small, with it at most 30 % too large.
    """
    rng, n, right = np.random.default_rng(1), 1500, np.sqrt(1.9 / 0.1)
    phase = np.outer(np.arange(n) / n, 2 * np.pi * np.arange(1, 9))
    W = np.linalg.qr(np.hstack([np.cos(phase), np.sin(phase)]))[0]
    noise = lfilter([1.0], [1.0, -0.9], rng.normal(size=(n, 20)), axis=0)
    residuals = noise - W @ (W.T @ noise)
    whole = np.zeros(n, dtype=np.intp)
    naive, given = (
        np.mean([one.inflation for one in whiteness_of(residuals, whole, paid)]) for paid in (0.0, np.full(20, 16.0))
    )
    assert naive < 0.85 * right < right < given < 1.3 * right


def test_leaving_a_fold_out_shows_errors_that_belong_to_a_part_of_the_motion(lwr):
    """White noise moves the values as its errors say; a torque that drifts from part to part moves them further.

    By fits without each fold: kappa^2 = sum d^T A d / sum (tr(A A_-f^-1) - b).
    """
    columns, rng = TorqueColumns(lwr.chain, "directions"), np.random.default_rng(4)
    plant = perturbed_plant(columns, lwr, rng)
    white = simulated_samples(plant, random_motion(lwr, 20.0, rng), 0.1, rng, 0.05)
    drifting = replace(white, tau=white.tau + 0.3 * np.sin(white.t / 2.0)[:, None])
    found = [Folds.of(one, columns, 5, one.used) for one in (white, drifting)]
    assert 1.0 <= found[0].inflation(found[0].information()) < 1.15
    said = found[1].information()
    A, moved, expected = said.precision, 0.0, 0.0
    for k in range(5):
        less = information_of(drifting.select(found[1].fold != k), columns, noise=said.noise)
        off = less.values - said.values
        moved, expected = moved + off @ A @ off, expected + np.trace(A @ less.covariance) - len(off)
    assert found[1].inflation(said) == pytest.approx(np.sqrt(moved / expected), rel=1e-4)
    assert moved > 4.0 * expected
    rows = found[1].fold == 2
    others = information_of(drifting.select(~rows), columns, noise=said.noise)
    left = residuals_of(replace(drifting, used=np.ones_like(drifting.used)), columns, others.values)
    assert found[1].held_out(said.noise)[rows][white.used[rows]] == pytest.approx(
        left[rows][white.used[rows]], abs=1e-6
    )


def test_correlations_are_of_pairs_in_one_recording_that_are_both_used():
    rng = np.random.default_rng(1)
    e, recording = rng.normal(size=(80, 3)), np.repeat([0, 1, 2], [30, 40, 10])
    e[rng.uniform(size=e.shape) < 0.2] = np.nan
    e[LAGS:, 1] = np.nan  # too few instants for a joint's whiteness
    found = whiteness_of(e, recording)
    assert [one.joint for one in found] == [1, 3]
    for one in found:
        x = e[:, one.joint - 1]
        products = [x[k:] * x[:-k] for k in range(1, LAGS + 1)]
        inside = [p[(recording[k:] == recording[:-k]) & np.isfinite(p)] for k, p in enumerate(products, 1)]
        r = np.array([p.mean() for p in inside]) / np.nanmean(x**2)
        assert one.autocorrelation == pytest.approx(r)
        assert one.statistic == pytest.approx(np.array([*map(len, inside)]) @ r**2)
        assert one.probability == pytest.approx(stats.chi2.sf(one.statistic, LAGS))


def test_bands_of_speed_are_thirds_of_the_largest_that_is_used():
    dq = np.array([0.1, -0.5, 0.9, -1.5, 2.9, 3.0, 9.0])
    left = np.array([1.0, 1.0, 1.0, 2.0, 3.0, 4.0, np.nan])
    bands = speed_bands(dq, left)
    assert [(b.slowest, b.fastest, b.equations) for b in bands] == [(0.0, 1.0, 3), (1.0, 2.0, 1), (2.0, 3.0, 2)]
    assert [b.left for b in bands] == pytest.approx([1.0, 2.0, np.sqrt(12.5)])
    assert speed_bands(dq, np.full(7, np.nan)) == ()


def test_parameters_that_are_near_each_other_in_a_chain_are_known_together():
    """From a correlation of 0.9 on; one that is not determined is in no group."""
    correlation = np.eye(8)
    for i, j, r in ((0, 1, 0.95), (1, 2, 0.901), (3, 4, -0.99), (5, 6, 0.899), (6, 7, 0.97)):
        correlation[i, j] = correlation[j, i] = r
    sigma, determined = np.array([1.0, 2.0, 0.1, 3.0, 1e-3, 1.0, 1.0, np.inf]), np.arange(8) != 6
    covariance = (
        np.where(np.isfinite(sigma), sigma, 1.0) * correlation * np.where(np.isfinite(sigma), sigma, 1.0)[:, None]
    )
    groups = correlated_groups(SimpleNamespace(covariance=covariance, sigma=sigma, determined=determined))
    assert [(group.members, round(group.largest, 6)) for group in groups] == [((3, 4), -0.99), ((0, 1, 2), 0.95)]
    assert together(groups, [f"p{i}" for i in range(8)]).cells == (("-0.990", "p3, p4"), ("+0.950", "p0, p1, p2"))
    assert correlated_groups(SimpleNamespace(covariance=covariance, sigma=sigma, determined=np.zeros(8, bool))) == ()


def test_a_swing_is_named_with_its_gains():
    swing = MissingMotion((5, 6), (0.5, 0.321), (0.4, 0.7), (0.123, -1.0), (2, 0), (np.inf, 0.2), (0.1, 0.0123))
    (cells,) = missing([swing], ["m_1", "m_2", "m_3"]).cells
    assert cells[:3] == (
        "5 (0.5 at 0.4 Hz) and 6 (0.32 at 0.7 Hz)", "0.12, -1", "m_3 from unknown to 0.3; m_1 from 0.6 to 0.037",
    )  # fmt: skip


def test_swings_are_of_each_joint_and_pair_in_three_poses_as_far_as_limits_allow():
    arm = with_limits(first_joints(3), lower=-0.8, upper=1.2, velocity=1.0)
    arm = replace(arm, limits=(*arm.limits[:2], JointLimits(velocity=5.0)))
    swings = list(_swings(arm))
    joints = [(1,), (2,), (3,), (1, 2), (1, 3), (2, 3)]
    assert [swing.joints for swing in swings] == [each for each in joints for _ in range(3)]
    t = np.arange(0.0, 10.0, 0.1)
    for swing in swings:
        q = np.tile(swing.pose, (100, 1))
        for k, (j, hertz) in enumerate(zip(swing.joints, (0.4, 0.7), strict=False)):
            w = 2.0 * np.pi * hertz
            size = min(0.5, 2.0 / 4.0 if j < 3 else np.pi / 2.0, 0.8 * (1.0 if j < 3 else 5.0) / w)
            assert swing.amplitudes[k] == pytest.approx(size)
            q[:, j - 1] += size * np.sin(w * t)
            np.testing.assert_allclose(swing.dq[:, j - 1], size * w * np.cos(w * t), atol=1e-12)
            np.testing.assert_allclose(swing.ddq[:, j - 1], -size * w**2 * np.sin(w * t), atol=1e-12)
        np.testing.assert_allclose(swing.q, q)
        still = [j for j in range(3) if j + 1 not in swing.joints]
        assert [x[:, still].any() for x in (swing.dq, swing.ddq)] == [False, False]
    poses = np.array([swing.pose for swing in swings[:3]])
    wanted = np.random.default_rng(0).uniform([-0.8, -0.8, -np.pi], [1.2, 1.2, np.pi], (3, 3)) / 2.0 + [0.1, 0.1, 0.0]
    np.testing.assert_allclose(poses, wanted)


NOISE = 0.1


def test_stribeck_friction_shows_in_the_torques_that_are_left_out(lwr):
    """Three joints have it, at 0.02 rad/s: no fit above 0.06 rad/s sees it, what is left out does."""
    speeds = np.array([0.02, 0.02, 0.02, np.nan, np.nan, np.nan, np.nan])
    rng = np.random.default_rng(4)
    plant = perturbed_plant(TorqueColumns(lwr.chain, "directions", speeds), lwr, rng)
    log = simulated_log(plant, random_motion(lwr, 20.0, rng, 1000.0), NOISE, rng, 1e-5)
    found = identify_motion([log], lwr)
    for seen in (found.validation, found.validated_on([log])):
        left = np.array([one.left_out for one in seen])
        unseen = np.array([one.held_out for one in seen])
        assert (left[:3] > 2.0 * unseen[:3]).all()
        assert (left[3:] < 1.5 * unseen[3:]).all()
        assert (unseen < 1.4 * NOISE).all()
