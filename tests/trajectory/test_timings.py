"""The double-S profile: bounds that are reached and kept, total times of the book, sections in a given time."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.path import end_of, line, path_of
from lwr_dyn.trajectory.timings import MOTION_PROFILES, SmoothTiming, blended, double_s, double_s_in
from tests.examples import examples
from tests.trajectory.test_motion_profile import ROUNDING
from tests.trajectory.test_path import assert_smooth_curve, letter

amounts = st.floats(1e-2, 1e2)


@given(length=amounts, speed=amounts, acceleration=amounts, jerk=amounts)
@examples(60)
def test_double_s_keeps_its_bounds_and_arrives_at_rest(length, speed, acceleration, jerk):
    profile = double_s(length, speed, acceleration, jerk)
    tick = 4 * np.spacing(profile.duration)  # what a time of that size can tell; a jerk acts through it
    rough = jerk * tick + ROUNDING * acceleration
    peaks = profile.peaks()
    assert peaks.speed <= speed * (1 + ROUNDING) + acceleration * tick
    assert peaks.acceleration <= acceleration + rough
    assert peaks.jerk <= jerk * (1 + ROUNDING)
    end = profile.at([profile.duration])
    assert end.s[0] == pytest.approx(length, rel=ROUNDING)
    assert abs(end.ds[0]) <= ROUNDING * speed * 10 + acceleration * tick
    assert abs(end.dds[0]) <= 10 * rough
    assert peaks.jerk == pytest.approx(jerk, rel=ROUNDING)
    if len(profile.coefficients) == 7:  # all stretches are there, so all bounds are reached: no time is wasted
        assert peaks.speed == pytest.approx(speed, rel=ROUNDING)
        assert abs(peaks.acceleration - acceleration) <= rough


@pytest.mark.parametrize(
    ("speed", "acceleration", "duration"),
    [(0.5, 1.0, 1 / 0.5 + 0.5 + 0.1), (50.0, 1.0, 2 * np.sqrt(1 + 0.05**2) + 0.1), (50.0, 100.0, 4 * np.cbrt(1 / 20))],
)
def test_double_s_total_times_are_those_of_the_book(speed, acceleration, duration):
    """L/v + v/a + a/j where all bounds are reached; 2 sqrt(L/a + (a/2j)^2) + a/j without cruise; 4 cbrt(L/2j)."""
    assert double_s(1.0, speed, acceleration, 10.0).duration == pytest.approx(duration, rel=ROUNDING)


@given(st.lists(st.floats(0.01, 2.0), min_size=1, max_size=6), st.floats(1.0, 20.0), st.floats(0.1, 5.0))
@examples(30)
def test_sections_in_a_given_time_stop_at_their_ends_and_keep_the_bounds(lengths, stretch, acceleration):
    jerk = 8.0 * acceleration
    shortest = sum(double_s(length, 1e6, acceleration, jerk).duration for length in lengths)
    profile = double_s_in(lengths, stretch * shortest * (1 + 1e-9), acceleration, jerk)
    assert profile.duration == stretch * shortest * (1 + 1e-9)
    peaks = profile.peaks()
    assert peaks.acceleration <= acceleration * (1 + ROUNDING) + ROUNDING
    assert peaks.jerk <= jerk * (1 + ROUNDING)
    at_knots = profile.at(profile.knots)
    for stop in np.cumsum(lengths):
        k = int(np.argmin(np.abs(at_knots.s - stop)))
        assert at_knots.s[k] == pytest.approx(stop, rel=ROUNDING)
        assert abs(at_knots.ds[k]) <= 1e-9 * peaks.speed
        assert abs(at_knots.dds[k]) <= 1e-9 * acceleration


def test_a_time_too_short_for_the_bounds_is_refused_with_the_shortest():
    least = 2 * np.sqrt(1 + 0.05**2) + 0.1
    words = f"duration: 0.5 s; allowed: at least {least:.6g} s with 1 stops, acceleration 1 and jerk 10"
    with pytest.raises(OptionError, match=words):
        double_s_in([1.0], 0.5, 1.0, 10.0)
    assert double_s_in([1.0], least, 1.0, 10.0).duration == least
    with pytest.raises(OptionError, match="lengths: none; allowed: at least one section"):
        double_s_in([], 1.0, 1.0, 1.0)


def test_blended_joints_have_continuous_tangent_and_curvature():
    path = blended(letter(), corners=0.03, bends=0.01)
    assert len(path.segments) == 5
    for joint in path.joints():
        assert joint.turn < 1e-7
        assert joint.bend < 1e-7
    assert path.corners() == ()
    for segment in path.segments:
        assert_smooth_curve(segment)


@pytest.mark.parametrize("turn_deg", [20, 90, 140])
def test_the_length_on_a_blend_is_the_length_of_its_chords(turn_deg):
    turn = math.radians(turn_deg)
    after = (math.cos(turn), math.sin(turn), 0)
    path = blended(path_of([line((-1, 0, 0), (0, 0, 0)), line((0, 0, 0), after)]), corners=0.3)
    blend = path.segments[1]
    ends = np.linspace(0.0, blend.length, 4)
    for a, b in pairwise(ends):
        chords = [np.linalg.norm(np.diff(blend.at(np.linspace(a, b, k)).p, axis=0), axis=1).sum() for k in (2001, 4001)]
        assert (4.0 * chords[1] - chords[0]) / 3.0 == pytest.approx(b - a, abs=1e-12)  # without the sagitta's square


def test_blends_stay_near_the_path_they_round():
    sharp, size = letter(), 0.005
    eased = blended(sharp, bends=size)
    dense = sharp.at(np.linspace(0.38, 0.42, 40_001)).p
    away = max(np.linalg.norm(dense - p, axis=1).min() for p in eased.at(np.linspace(0.39, 0.41, 41)).p)
    assert 1e-6 < away < 0.1 * size**2 / 0.075  # a fraction of the sagitta size^2 / radius
    assert abs(eased.length - sharp.length) < 1e-5


@pytest.mark.parametrize(("degrees", "is_kept"), [(180.0, True), (171.0, True), (169.0, False)])
def test_a_corner_that_turns_back_is_kept_for_a_stop(degrees, is_kept):
    turn = math.radians(degrees)
    end = (0.5 * math.sin(turn), 1 + 0.5 * math.cos(turn), 0)
    path = blended(path_of([line((0, 0, 0), (0, 1, 0)), line((0, 1, 0), end)]), corners=0.1)
    assert [corner.turn for corner in path.corners()] == [pytest.approx(turn)] * is_kept
    assert not is_kept or path.sections() == pytest.approx((1.0, 0.5))


def test_corners_and_bends_are_rounded_each_by_its_own_distance_and_nothing_else():
    straight = path_of([line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (3, 0, 0))])
    assert [part.length for part in blended(straight, corners=0.1, bends=0.2).segments] == [1.0, 2.0]
    word = letter()
    assert len(blended(word).segments) == len(word.segments)
    for corners, bends in ((0.03, 0.0), (0.0, 0.01), (0.03, 0.01)):
        rounded = blended(word, corners, bends)
        marks = [(joint.is_corner, joint.is_bend) for joint in word.joints()]
        cut = [corners if is_corner else bends if is_bend else 0.0 for is_corner, is_bend in marks]
        assert len(rounded.segments) == len(word.segments) + sum(size > 0.0 for size in cut)
        before = np.cumsum([part.length for part in word.segments])
        for size, s in zip(cut, before, strict=False):  # the path is left and met again at that distance
            for at in (s - size, s + size):
                away = [np.linalg.norm(end_of(part).p[0] - word.at(np.array([at])).p[0]) for part in rounded.segments]
                assert min(away) < 1e-12 or size == 0.0


def test_the_rows_time_a_path_by_their_profiles():
    path = path_of([line((0, 0, 0), (0.3, 0, 0)), line((0.3, 0, 0), (0.3, 0.1, 0))])
    smooth = SmoothTiming(acceleration=0.7, jerk=6.0, ease=0.004, blend=0.03)
    made = {name: MOTION_PROFILES.load(name)(path, 4.0, smooth) for name in MOTION_PROFILES.names}
    assert [profile.duration for _, profile in made.values()] == [4.0] * 4
    assert [round(where.length, 12) for where, _ in made.values()][:3] == [0.4] * 3
    t = np.linspace(0.0, 4.0, 9)
    np.testing.assert_allclose(made["constant"][1].at(t).s, 0.1 * t, atol=1e-15)
    np.testing.assert_allclose(made["quintic"][1].at([1.5, 3.0, 3.5]).s, [0.15, 0.3, 0.35], atol=1e-12)
    stopped, passed = made["smooth"][1], made["smooth-blended"][1]
    for profile in (stopped, passed):
        assert profile.peaks().acceleration <= 0.7 * (1 + 1e-9)
        assert profile.peaks().jerk == pytest.approx(6.0, rel=1e-6)
    inside = (stopped.knots > 0.5) & (stopped.knots < 3.5)
    assert np.abs(stopped.at(stopped.knots[inside]).ds).min() < 1e-9
    assert np.abs(passed.at(np.linspace(0.6, 3.4, 99)).ds).min() > 0.05
    corner = made["smooth-blended"][0].segments[1]
    assert np.linalg.norm(end_of(corner).p[0] - [0.3, 0.03, 0.0]) < 1e-12
    assert SmoothTiming() == SmoothTiming(0.5, 5.0, 0.005, 0.02)


def test_blends_may_use_up_a_segment_but_no_more():
    path = path_of([line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (1, 1, 0)), line((1, 1, 0), (0, 1, 0))])
    assert len(blended(path, corners=0.5).segments) == 4  # the middle line is gone
    words = r"blend: 0\.6 m and 0\.6 m at the ends of segment 1; allowed: together at most its length, 1 m"
    for corners, message in ((0.6, words), (-0.1, r"corners: -0\.1")):
        with pytest.raises(OptionError, match=message):
            blended(path, corners=corners)
