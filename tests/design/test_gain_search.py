"""The largest omega_n with a stated margin: it keeps it, a little more does not, in the simulated arm neither."""

from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.design.gain_search import certified, largest_omega_n
from lwr_dyn.design.loop_judgement import LoopCase
from lwr_dyn.design.loop_margins import largest_sensitivity
from lwr_dyn.foundation.errors import MissingDataError, OptionError, UnknownNameError
from tests.design.margin_cases import arm, dynamics, law, linear
from tests.simulation.sample_runs import one_joint


def ist(reading="physical", count=9):
    task = lwr_dyn.reference("ist", arm(reading))
    return task.sample(np.linspace(0, task.duration, count)).q


@pytest.mark.slow
@pytest.mark.parametrize(
    ("reading", "controller", "delay", "omega_n"),
    [
        ("computed", "pd-gravity", 1, 23.8),
        ("physical", "pd-gravity", 1, 50.6),
        ("physical", "pid", 4, 17.2),
        ("physical", "inverse-dynamics", 1, 164.0),
        ("physical", "inverse-dynamics", 4, 55.0),
    ],
)
def test_the_known_frequencies_on_the_ist_task(reading, controller, delay, omega_n):
    """Trials of another program: PD and PID 23.8 and 50.6, 17.2; inverse dynamics 164 and 55 rad/s."""
    found = largest_omega_n(arm(reading), controller, [LoopCase(delay=delay)], q=ist(reading))
    assert found.omega_n == pytest.approx(omega_n, rel=0.02)
    assert 1.68 < found.peak <= 1.7


def test_it_keeps_the_margin_and_a_little_more_does_not():
    q, case = ist(), LoopCase(delay=2)
    found = largest_omega_n(arm(), "pd-gravity", [case], q=q, peak=1.5)
    loops = [case.loop(arm(), dynamics(), law("pd-gravity", omega_n=f * found.omega_n), q) for f in (1.0, 1.02)]
    peaks = [largest_sensitivity(loop, case.sampling) for loop in loops]
    assert peaks[0].max() <= 1.5 * (1 + 1e-3) < peaks[1].max()  # its grid of frequencies is coarser
    k, joint = np.unravel_index(peaks[0].argmax(), peaks[0].shape)
    assert joint == found.joint
    np.testing.assert_allclose(q[k], found.q)
    assert found.peak == pytest.approx(peaks[0].max(), rel=1e-3)


@pytest.mark.slow
def test_all_cases_must_keep_it_and_the_one_that_stops_it_is_named():
    cases = [LoopCase(delay=1), LoopCase(delay=4), LoopCase(elasticity=1e4)]
    alone = [largest_omega_n(arm(), "inverse-dynamics", [case], q=ist(count=4)).omega_n for case in cases]
    found = largest_omega_n(arm(), "inverse-dynamics", cases, q=ist(count=4))
    assert found.omega_n == pytest.approx(min(alone), rel=0.005)
    assert found.case == cases[int(np.argmin(alone))]
    assert alone[2] < alone[1] < alone[0]


@pytest.mark.slow
def test_over_the_box_the_worst_pose_that_a_search_finds_counts():
    drawn = largest_omega_n(arm(), "pd-gravity", [LoopCase(delay=1)], poses=20)
    on_twenty = np.random.default_rng(0).uniform(arm().lower, arm().upper, (20, 7))
    given = largest_omega_n(arm(), "pd-gravity", [LoopCase(delay=1)], q=on_twenty)
    assert drawn.omega_n < given.omega_n
    assert drawn.poses > 20


def test_where_none_keeps_it_there_is_none_and_low_gains_may_break_what_higher_ones_keep():
    """Gravity compensation feeds positions back positively: the search comes from above."""
    found = largest_omega_n(arm("computed"), "pd-gravity", [LoopCase(delay=1)], poses=50)
    assert (found.omega_n, found.to_json()["omega_n"], found.peak > 1.7) == (None, None, True)
    q, case, low = ist(), LoopCase(delay=1), law("pd-gravity", omega_n=1.0)
    assert largest_sensitivity(case.loop(arm(), dynamics(), low, q), case.sampling).max() > 1.7
    assert largest_omega_n(arm(), "pd-gravity", [case], q=q).omega_n > 50


def damper(omega_n):
    return linear(np.zeros((1, 1, 1)), np.full((1, 1, 1), 2.0 * omega_n))


def test_a_damper_is_limited_where_hand_computation_says():
    """m dv = -Kd v with Kd = m omega: v+ = (1 - T omega) v, |S| = 1 / (1 - T omega / 2) at half the rate."""

    def found(*cases, peak=2.0, **options):
        return largest_omega_n(one_joint(mass=2.0), damper, cases, q=[[0.0]], peak=peak, **options)

    largest = found(LoopCase(), most=5000.0)
    low, high = 5000.0 / 1.2**9, 5000.0 / 1.2**8  # down by a fifth, then bisection to 0.3 %
    while high > 1.003 * low:
        middle = np.sqrt(low * high)
        low, high = (middle, high) if middle < 1000.0 else (low, middle)
    assert (largest.omega_n, largest.peak) == pytest.approx((low, 1.0 / (1.0 - 0.0005 * low)), rel=1e-5)
    exactly = [found(LoopCase(), most=most, peak=5.0 / 3.0 + 1e-5) for most in (300.0, 800.0)]
    assert [(x.omega_n, x.at_most) for x in (largest, *exactly)] == [(low, False), (300.0, True), (800.0, True)]
    assert found(LoopCase(rate=500.0), LoopCase()).omega_n == pytest.approx(500.0, rel=0.01)
    none = found(LoopCase(), most=5000.0, peak=1.0001)
    assert (none.omega_n, none.at_most, none.peak) == (None, False, pytest.approx(1.0 / (1.0 - 0.00025), abs=1e-7))


@pytest.mark.parametrize(
    ("changed", "error", "fault"),
    [
        ({"cases": []}, OptionError, "cases: none"),
        ({"peak": 1.0}, OptionError, "a number above 1"),
        ({"controller": "pdd"}, UnknownNameError, "pdd"),
        ({"controller": "mine.py"}, OptionError, "a law with an option omega_n"),
        ({"cases": [LoopCase(elasticity="file")], "arm": one_joint()}, MissingDataError, "stiffness"),
    ],
)
def test_bad_input_is_named(changed, error, fault):
    given = {"arm": arm(), "controller": "inverse-dynamics", "cases": [LoopCase()], "poses": 3} | changed
    with pytest.raises(error, match=fault):
        largest_omega_n(given.pop("arm"), given.pop("controller"), given.pop("cases"), **given)


def test_joints_whose_bound_is_not_near_are_listed_and_the_others_in_one_line():
    near, far = (SimpleNamespace(gap=1e-4, boxes=3, joint=k, holds=holds, statement=lambda: "too far")
                 for k, holds in enumerate((True, False)))  # fmt: skip
    words = "certified: nowhere in the joint box"
    rounded = "boxes; rounding errors included)"
    two = SimpleNamespace(joint_names=("j1", "j2"))
    assert certified(two, [near]) == [f"{words} more than 1.0e-02 % above these values (3 {rounded}"]
    assert certified(two, [near, far]) == [
        f"{words} more than 1.0e-02 % above these values (6 {rounded}, except:", "  j2: too far",
    ]  # fmt: skip
    assert certified(two, [far]) == [f"{words} above the bounds that follow (3 {rounded}", "  j2: too far"]
