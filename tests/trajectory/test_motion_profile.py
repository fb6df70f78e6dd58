"""Motion profiles: derivatives against differences, bounds, ends, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.errors import OptionError
from lwr_dyn.trajectory.double_s import double_s, double_s_in
from lwr_dyn.trajectory.motion_profile import concatenate, constant_speed, quintic, stretched
from tests.examples import examples

ROUNDING = 1e-11
"""Relative: cubic and quintic pieces evaluated from coefficients that were themselves summed over seven pieces."""
STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Eighth-order central difference: exact for these polynomials, so only rounding is left."""

amounts = st.floats(1e-2, 1e2)
PROFILES = {
    "constant": constant_speed(0.7, 3.0),
    "quintic": quintic(0.7, 3.0),
    "double-S, all seven pieces": double_s(0.7, 0.3, 0.6, 2.0),
    "double-S, acceleration not reached": double_s(0.7, 0.3, 6.0, 2.0),
    "double-S, speed not reached": double_s(0.7, 30.0, 0.6, 2.0),
    "double-S, jerk alone": double_s(0.7, 30.0, 60.0, 2.0),
    "sequence": concatenate([quintic(0.2, 1.0), double_s(0.5, 0.3, 0.6, 2.0)]),
    "stretched": stretched(double_s(0.7, 0.3, 0.6, 2.0), 9.0),
}


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_derivatives_are_those_of_s_inside_every_piece(profile):
    h = 1e-2 * float(np.min(np.diff(profile.knots)))
    for begin, end in zip(profile.knots, profile.knots[1:], strict=False):
        t = np.linspace(begin + 5 * h, end - 5 * h, 7)
        around = profile.at((t[:, None] + h * STENCIL).ravel())
        here = profile.at(t)
        for value, rate in (("s", "ds"), ("ds", "dds"), ("dds", "ddds")):
            difference = getattr(around, value).reshape(len(t), -1) @ WEIGHTS / h
            scale = 1e-13 / h  # rounding of s divided by the step
            np.testing.assert_allclose(getattr(here, rate), difference, atol=scale, rtol=1e-9)


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_every_law_goes_from_zero_to_its_length_and_stands_still_outside(profile):
    sample = profile.at([-1.0, 0.0, profile.duration, profile.duration + 1.0])
    np.testing.assert_allclose(sample.s, [0.0, 0.0, profile.length, profile.length], atol=ROUNDING)
    assert not np.any([sample.ds[[0, 3]], sample.dds[[0, 3]], sample.ddds[[0, 3]]])


@pytest.mark.parametrize("name", [n for n in PROFILES if n != "constant"])
def test_rest_to_rest_laws_have_no_jump_of_s_speed_or_acceleration(name):
    profile = PROFILES[name]
    before = profile.at(np.nextafter(profile.knots, -np.inf))
    after = profile.at(profile.knots)
    for value in ("s", "ds", "dds"):
        np.testing.assert_allclose(getattr(before, value), getattr(after, value), atol=ROUNDING)


def test_constant_speed_jumps_at_both_ends():
    profile = PROFILES["constant"]
    eps = 1e-9
    np.testing.assert_allclose(profile.at([-eps, 0.0, 3.0, 3.0 + eps]).ds, [0.0, 0.7 / 3.0, 0.7 / 3.0, 0.0])


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


def test_double_s_total_times_are_those_of_the_book():
    # T = L/v + v/a + a/j when all bounds are reached; 2 sqrt(L/a + (a/2j)^2) + a/j without cruise; 4 cbrt(L/2j) by jerk
    assert double_s(1.0, 0.5, 1.0, 10.0).duration == pytest.approx(1 / 0.5 + 0.5 + 0.1, rel=ROUNDING)
    assert double_s(1.0, 50.0, 1.0, 10.0).duration == pytest.approx(2 * np.sqrt(1 + 0.05**2) + 0.1, rel=ROUNDING)
    assert double_s(1.0, 50.0, 100.0, 10.0).duration == pytest.approx(4 * np.cbrt(1 / 20), rel=ROUNDING)


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


def test_a_time_too_short_for_the_bounds_says_the_shortest():
    with pytest.raises(OptionError, match=r"duration: 0.5 s; allowed: at least 2\.\d+ s with 1 stops"):
        double_s_in([1.0], 0.5, 1.0, 10.0)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, "fast", None])
@pytest.mark.parametrize(
    "make",
    [
        lambda x: constant_speed(1.0, x),
        lambda x: quintic(x, 1.0),
        lambda x: stretched(quintic(1.0, 1.0), x),
        lambda x: double_s(1.0, 1.0, x, 1.0),
        lambda x: double_s(1.0, 1.0, 1.0, x),
        lambda x: double_s_in([1.0, x], 9.0, 1.0, 1.0),
    ],
)
def test_amounts_that_are_not_positive_are_refused(make, bad):
    with pytest.raises(OptionError, match="allowed: a number from 1e-09 to 1e"):
        make(bad)


def test_no_sections_are_refused():
    with pytest.raises(OptionError, match="at least one"):
        concatenate([])
    with pytest.raises(OptionError, match="at least one"):
        double_s_in([], 1.0, 1.0, 1.0)
