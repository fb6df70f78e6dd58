"""Motion profiles: derivatives against differences, bounds, ends, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.motion_profile import concatenate, constant_speed, lspb, quintic, stretched, trapezoid
from lwr_dyn.trajectory.timings import double_s, double_s_in

ROUNDING = 1e-11
"""Relative: cubic and quintic pieces evaluated from coefficients that were themselves summed over seven pieces."""
STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Eighth-order central difference: exact for these polynomials, so only rounding is left."""

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


@pytest.mark.parametrize(("length", "duration"), [(0.7, 3.0), (0.7, 1.0), (2.0, 0.25)])
def test_peaks_of_a_quintic_are_its_closed_forms(length, duration):
    """Speed 15/8, acceleration 10/sqrt(3), jerk 60: the first two inside, the last at both ends."""
    peaks = quintic(length, duration).peaks()
    assert peaks.speed == pytest.approx(15 / 8 * length / duration, rel=1e-12)
    assert peaks.acceleration == pytest.approx(10 / np.sqrt(3) * length / duration**2, rel=1e-12)
    assert peaks.jerk == pytest.approx(60 * length / duration**3, rel=1e-12)


LSPB_ROUNDING = 1e-13
"""Relative to the length: quadratics from coefficients of a few products."""

amounts = st.floats(1e-2, 1e2)
shares = st.floats(1e-3, 0.5)


def equation_2(t, q_i, q_f, t_f, t_c, dq_c, ddq_c):
    """As printed."""
    blend_in = q_i + ddq_c * t**2 / 2
    cruise = (q_f + q_i - dq_c * t_f) / 2 + dq_c * t
    blend_out = q_f - ddq_c * (t_f - t) ** 2 / 2
    return np.where(t <= t_c, blend_in, np.where(t <= t_f - t_c, cruise, blend_out))


def equation_3(length, t_f, t_c):
    """As printed, where it is called a velocity."""
    return 4 * length / (t_f**2 - (2 * (t_c - 0.5 * t_f)) ** 2)


@given(amounts, amounts, shares)
def test_equation_2_is_reproduced(length, t_f, share):
    t_c = share * t_f
    profile = lspb(length, t_f, t_c)
    ddq_c = length / (t_c * (t_f - t_c))
    t = np.linspace(0.0, t_f, 301)
    expected = equation_2(t, 0.0, length, t_f, t_c, ddq_c * t_c, ddq_c)
    np.testing.assert_allclose(profile.at(t).s, expected, atol=LSPB_ROUNDING * length)


@given(amounts, amounts, st.floats(1e-2, 0.49))
def test_speed_and_acceleration_are_those_of_the_three_phases(length, t_f, share):
    t_c = share * t_f
    profile = lspb(length, t_f, t_c)
    V = length / (t_f - t_c)
    middles = profile.at([t_c / 2, t_f / 2, t_f - t_c / 2])
    np.testing.assert_allclose(middles.ds, [V / 2, V, V / 2], rtol=1e-11)
    np.testing.assert_allclose(middles.dds, [V / t_c, 0.0, -V / t_c], rtol=1e-12)
    ends = profile.at([-1.0, 0.0, t_f, t_f + 1.0])
    np.testing.assert_allclose(ends.s, [0.0, 0.0, length, length], atol=LSPB_ROUNDING * length)
    np.testing.assert_allclose(ends.ds, 0.0, atol=1e-12 * V)


def test_the_papers_run():
    profile = lspb(0.5, 7.0, 1.0)
    assert profile.peaks().speed == pytest.approx(1 / 12, rel=1e-14)
    assert profile.peaks().acceleration == pytest.approx(1 / 12, rel=1e-14)
    assert profile.knots.tolist() == [0.0, 1.0, 6.0, 7.0]


def test_equation_3_is_the_acceleration_and_a_velocity_for_a_blend_of_one_second_alone():
    for t_c in (0.5, 1.0, 2.0, 3.0):
        peaks = lspb(0.5, 7.0, t_c).peaks()
        printed = equation_3(0.5, 7.0, t_c)
        assert printed == pytest.approx(peaks.acceleration, rel=1e-13)
        assert (printed == pytest.approx(peaks.speed, rel=1e-3)) == (t_c == 1.0)


def test_equations_3_and_4_as_printed_tear_equation_2_apart_for_other_blends():
    for t_c, gap in ((1.0, 0.0), (2.0, 0.075)):
        dq_c = ddq_c = equation_3(0.5, 7.0, t_c)  # eq. (4): ddq_c = dq_c
        around = equation_2(np.array([t_c, np.nextafter(t_c, 8)]), 0.0, 0.5, 7.0, t_c, dq_c, ddq_c)
        assert abs(np.diff(around)[0]) == pytest.approx(gap, abs=1e-12)


def test_the_borderline_is_a_triangle_without_cruise():
    profile = lspb(0.5, 2.0, 1.0)
    assert profile.knots.tolist() == [0.0, 1.0, 2.0]
    assert profile.peaks().speed == 0.5


def test_an_axis_of_no_length_stands_still_for_its_time():
    profile = lspb(0.0, 3.0, 1.0)
    sample = profile.at(np.linspace(-1, 4, 11))
    assert profile.duration == 3.0
    assert not np.any([sample.s, sample.ds, sample.dds])
    assert profile.peaks().speed == 0.0


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: lspb(0.5, 2.0, 1.1), "blend: 1.1 s; allowed: above 0, at most 1 s, half of 2 s"),
        (lambda: lspb(0.5, 2.0, 0.0), "blend: 0.0; allowed: a number from"),
        (lambda: lspb(0.5, -2.0, 0.1), "duration: -2.0; allowed: a number from"),
        (lambda: lspb(-0.5, 2.0, 0.5), "length: -0.5; allowed: a number from"),
        (lambda: lspb(np.nan, 2.0, 0.5), "length: nan; allowed: a number from"),
    ],
)
def test_what_does_not_exist_is_refused_with_the_feasible_range(make, says):
    with pytest.raises(OptionError, match=says):
        make()


def test_the_trapezoid_is_the_lspb_at_its_bounds_and_a_triangle_when_it_is_short():
    t = np.linspace(0.0, 7.0, 71)
    assert trapezoid(0.5, 0.1, 0.05).at(t).s == pytest.approx(lspb(0.5, 7.0, 2.0).at(t).s, abs=1e-15)
    short = trapezoid(1.0, 5.0, 1.0)
    assert (len(short.coefficients), short.duration, short.peaks().speed) == (2, 2.0, 1.0)
