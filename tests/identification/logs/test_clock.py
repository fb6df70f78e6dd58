"""Uneven rows come to an even grid on the clock that the positions bear out, and are refused where none does."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import LogError
from lwr_dyn.identification.logs.clock import clock_of, on_even_clock
from lwr_dyn.identification.logs.joint_log import JointLog

STEP = 0.002


def log_at(t, stamps=None):
    """Of two joints at times t."""
    return JointLog("x", (1, 2), t if stamps is None else stamps, *at(t))


def at(t):
    """Two joints and their torques at times t."""
    q = np.column_stack([np.sin(2 * t), 0.5 * np.cos(3 * t)])
    return q, np.column_stack([5 * np.cos(3 * t), 4 * np.sin(t)])


def jittered(measured, stamped, lose=0.0, noise=1e-5, seed=0):
    """5 s with jitter (shares of a step) of the true times, and of the stamps besides; some rows lost."""
    rng = np.random.default_rng(seed)
    true = STEP * (np.arange(2500) + rng.uniform(-measured, measured, 2500))
    stamp = true + STEP * rng.uniform(-stamped, stamped, 2500)
    keep = rng.random(2500) >= lose
    q, tau = at(true[keep])
    return JointLog("x", (1, 2), stamp[keep], q + rng.normal(0, noise, q.shape), tau, motor_q=100 * q)


@pytest.mark.parametrize("lose", [0.0, 0.05])
@pytest.mark.parametrize("truth", ["stamps", "even"])
def test_the_positions_tell_which_clock_is_right(truth, lose):
    log = jittered(0.35 * (truth == "stamps"), 0.35 * (truth == "even"), lose)
    even = on_even_clock(log)
    steps = np.diff(even.t)
    inside = steps < 2.5 * STEP  # more are gaps, where rows were lost
    assert np.abs(steps[inside] - STEP).max() < 1e-2 * STEP
    assert inside.all() or lose > 0.0
    assert even.q.shape == even.tau.shape == even.motor_q.shape == (even.t.size, 2)
    q, tau = at(even.t)
    shift = 1e-4  # of the whole clock, which no position can show: the mean jitter
    assert np.abs(even.q - q).max() < 7e-5 + 2 * shift
    assert np.abs(even.tau - tau).max() < 15 * shift
    wrong = np.abs(log.q - at(STEP * np.rint(log.t / STEP) if truth == "stamps" else log.t)[0]).max()
    assert wrong > 5 * np.abs(even.q - q).max()
    note = even.notes[0]
    assert ("interpolated on a grid" if truth == "stamps" else "stamped unevenly: put on a grid") in note
    assert "miss an even clock by 0.000" in note
    assert any("rows lost" in note for note in even.notes) == (lose > 0)


@pytest.mark.parametrize(("lost", "jitter", "begin"), [(0.0, 0.3, 0.0), (0.03, 0.2, 7.3), (0.1, 0.05, -2.0)])
def test_a_clock_counts_the_rows_of_the_grid_that_made_the_times(lost, jitter, begin):
    """Its grid is the line of least squares through the times over their places on it."""
    rng = np.random.default_rng(3)
    kept = np.flatnonzero(rng.random(1500) >= lost)
    t = begin + STEP * (kept + rng.uniform(-jitter, jitter, kept.size))
    clock = clock_of(t)
    np.testing.assert_array_equal(clock.place, kept - kept[0])
    assert not clock.even
    assert clock.lost == kept[-1] - kept[0] + 1 - kept.size
    slope, start = np.polyfit(clock.place, t - t[0], 1)
    assert clock.step == pytest.approx(slope, rel=1e-12)
    np.testing.assert_allclose(clock.grid, t[0] + start + slope * np.arange(clock.grid.size), rtol=0, atol=1e-12)
    off = t - clock.grid[clock.place]
    assert clock.jitter == pytest.approx(np.sqrt(np.mean(off**2)))
    assert clock.worst == pytest.approx(np.abs(off).max())
    assert clock.jitter == pytest.approx(jitter * STEP / np.sqrt(3.0), rel=0.05)
    even = clock_of(begin + STEP * np.arange(50))
    assert (even.even, even.lost, even.place.tolist()) == (True, 0, list(range(50)))


BACK = "0.006 s after 0.008 s; needed: times that rise from row to row"
SAME = "0.008 s after 0.008 s"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({5: 3}, BACK),
        ({5: 4}, f"{SAME}; needed: times that"),
        ({5: 4, 9: 8}, f"{SAME} (2 such rows); needed: times that"),
    ],
)
def test_times_that_do_not_rise_are_refused_by_their_row(change, says):
    rows = np.arange(100)
    rows[list(change)] = list(change.values())
    with pytest.raises(LogError) as refusal:
        on_even_clock(log_at(STEP * rows))
    assert f"x: row 6, column time: {says}" in str(refusal.value)


def test_an_even_log_and_a_drifting_clock_stay_as_they_are():
    log = log_at(np.cumsum(STEP * (1 + 0.02 * np.sin(np.arange(1000) / 200))))
    assert on_even_clock(log) is log


def test_recordings_keep_their_gap_and_only_the_uneven_one_changes():
    first, second = jittered(0.0, 0.0), jittered(0.4, 0.0, seed=1)
    t = np.concatenate([first.t, second.t + 10.0])
    log = JointLog("x", (1, 2), t, np.concatenate([first.q, second.q]), np.concatenate([first.tau, second.tau]))
    even = on_even_clock(log)
    assert (even.q[:2500] == first.q).all()
    assert even.t[2500] - even.t[2499] > 5.0 - STEP
    (note,) = even.notes
    assert "rows 2501 to 5000" in note


def test_neither_clock_explains_the_positions_or_times_are_those_of_writing_in_blocks():
    with pytest.raises(LogError, match=r"x: column time: rows 1 to 2500 miss an even clock by 0.000.* s R"):
        on_even_clock(jittered(0.25, 0.25))
    t = np.arange(1000) * STEP
    late = np.ceil(t / 0.02) * 0.02 + 1e-5 * (np.arange(1000) % 10)
    with pytest.raises(LogError, match=r"100 of 999 steps are gaps \(median 1e-05 s, mean 0.002 s\); needed: times"):
        on_even_clock(log_at(t, late))


def test_what_is_noise_alone_is_not_held_against_the_clock():
    """An arm that stands still, or an encoder coarser than the jitter's effect: any clock will do."""
    t = STEP * (np.arange(500) + np.random.default_rng(0).uniform(-0.3, 0.3, 500))
    even = on_even_clock(JointLog("x", (1, 2), t, np.zeros((500, 2)), np.zeros((500, 2))))
    assert (even.q == 0.0).all()
    assert on_even_clock(jittered(0.2, 0.2, noise=0.02)).notes


def test_the_clock_of_times():
    clock = clock_of(np.array([0.0, 1.0, 2.0, 4.0, 5.0]))
    assert (clock.step, clock.lost, clock.even, clock.jitter < 1e-15) == (1.0, 1, False, True)
    assert clock_of(np.array([0.0, 1.1, 2.0])).worst == pytest.approx(0.2 / 3)
