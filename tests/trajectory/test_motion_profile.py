"""Motion profiles: derivatives against differences, bounds, ends, and what is refused."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.motion_profile import (
    LONGEST,
    SHORTEST,
    Peaks,
    concatenate,
    constant_speed,
    lspb,
    positive_number,
    quintic,
    stretched,
    trapezoid,
)
from lwr_dyn.trajectory.timings import double_s, double_s_in
from tests.trajectory.differences import check_derivatives

ROUNDING = 1e-11
"""Relative: cubic and quintic pieces evaluated from coefficients that were themselves summed over seven pieces."""
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


@pytest.mark.parametrize("name", PROFILES)
def test_rates_are_derivatives_inside_every_piece_from_zero_to_the_length_and_rest_to_rest(name):
    profile = PROFILES[name]
    h = 1e-2 * float(np.min(np.diff(profile.knots)))
    for begin, end in pairwise(profile.knots):
        t = np.linspace(begin + 5 * h, end - 5 * h, 7)
        check_derivatives(profile.at, t, h, ("s", "ds", "dds", "ddds"), atol=1e-13 / h, rtol=1e-9)
    sample = profile.at([-1.0, 0.0, profile.duration, profile.duration + 1.0])
    np.testing.assert_allclose(sample.s, [0.0, 0.0, profile.length, profile.length], atol=ROUNDING)
    assert not np.any([sample.ds[[0, 3]], sample.dds[[0, 3]], sample.ddds[[0, 3]]])
    before, after = profile.at(np.nextafter(profile.knots, -np.inf)), profile.at(profile.knots)
    if name == "constant":  # its speed jumps, and what counts at a knot is the piece that begins there
        np.testing.assert_allclose([before.ds, after.ds], [[0.0, 0.7 / 3.0], [0.7 / 3.0] * 2], rtol=1e-15)
        return
    for value in ("s", "ds", "dds"):
        np.testing.assert_allclose(getattr(before, value), getattr(after, value), atol=ROUNDING)


def test_names_and_durations_of_what_is_put_together():
    whole, slow = PROFILES["sequence"], PROFILES["stretched"]
    assert (whole.name, whole.length, slow.name, slow.duration) == ("quintic, then double-S", 0.7, "double-S", 9.0)
    assert whole.duration == 1.0 + double_s(0.5, 0.3, 0.6, 2.0).duration
    assert concatenate([quintic(1.0, 1.0)] * 2).name == "quintic"
    assert stretched(quintic(1.0, 3.0), 0.7).duration == 0.7
    with pytest.raises(OptionError, match="profiles: none; allowed: at least one profile"):
        concatenate([])


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, "fast", None, 0.99 * SHORTEST, 1.01 * LONGEST])
@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("duration", lambda x: constant_speed(1.0, x)), ("length", lambda x: constant_speed(x, 1.0)),
        ("length", lambda x: quintic(x, 1.0)), ("duration", lambda x: quintic(1.0, x)),
        ("duration", lambda x: stretched(quintic(1.0, 1.0), x)),
        ("length", lambda x: double_s(x, 1.0, 1.0, 1.0)), ("speed", lambda x: double_s(1.0, x, 1.0, 1.0)),
        ("acceleration", lambda x: double_s(1.0, 1.0, x, 1.0)), ("jerk", lambda x: double_s(1.0, 1.0, 1.0, x)),
        ("length", lambda x: double_s_in([1.0, x], 9.0, 1.0, 1.0)),
        ("length", lambda x: trapezoid(x, 1.0, 1.0)), ("speed", lambda x: trapezoid(1.0, x, 1.0)),
        ("acceleration", lambda x: trapezoid(1.0, 1.0, x)),
    ],
)  # fmt: skip
def test_amounts_that_are_not_positive_are_refused(name, make, bad):
    assert (positive_number(name, SHORTEST), positive_number(name, LONGEST)) == (1e-9, 1e9)
    with pytest.raises(OptionError) as fault:
        make(bad)
    assert str(fault.value) == f"{name}: {bad!r}; allowed: a number from 1e-09 to 1e+09"


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


def equation_2(t, q_i, q_f, t_f, t_c, dq_c, ddq_c):
    """As printed."""
    blend_in = q_i + ddq_c * t**2 / 2
    cruise = (q_f + q_i - dq_c * t_f) / 2 + dq_c * t
    blend_out = q_f - ddq_c * (t_f - t) ** 2 / 2
    return np.where(t <= t_c, blend_in, np.where(t <= t_f - t_c, cruise, blend_out))


def equation_3(length, t_f, t_c):
    """As printed, where it is called a velocity."""
    return 4 * length / (t_f**2 - (2 * (t_c - 0.5 * t_f)) ** 2)


@given(amounts, amounts, st.floats(1e-3, 0.5))
def test_equation_2_is_reproduced_with_the_speeds_of_its_three_phases(length, t_f, share):
    t_c = share * t_f
    profile = lspb(length, t_f, t_c)
    V = length / (t_f - t_c)
    t = np.linspace(0.0, t_f, 301)
    expected = equation_2(t, 0.0, length, t_f, t_c, V, V / t_c)
    np.testing.assert_allclose(profile.at(t).s, expected, atol=LSPB_ROUNDING * length)
    middles = profile.at([t_c / 2, t_f - t_c / 2])
    np.testing.assert_allclose(middles.ds, [V / 2, V / 2], rtol=1e-11)
    np.testing.assert_allclose(middles.dds, [V / t_c, -V / t_c], rtol=1e-12)
    ends = profile.at([-1.0, 0.0, t_f, t_f + 1.0])
    np.testing.assert_allclose(ends.s, [0.0, 0.0, length, length], atol=LSPB_ROUNDING * length)
    np.testing.assert_allclose(ends.ds, 0.0, atol=1e-12 * V)


def test_the_papers_run_the_borderline_without_cruise_and_an_axis_of_no_length():
    papers, triangle, still = lspb(0.5, 7.0, 1.0), lspb(0.5, 2.0, 1.0), lspb(0.0, 3.0, 1.0)
    assert [profile.knots.tolist() for profile in (papers, triangle, still)] == [[0, 1, 6, 7], [0, 1, 2], [0, 3]]
    assert papers.peaks().speed == pytest.approx(1 / 12, rel=1e-14)
    assert papers.peaks().acceleration == pytest.approx(1 / 12, rel=1e-14)
    assert triangle.at([0.5, 1.0, 1.5, 2.0]).s.tolist() == [0.0625, 0.25, 0.4375, 0.5]
    assert (triangle.peaks(), still.peaks()) == (Peaks(0.5, 0.5, 0.0), Peaks(0.0, 0.0, 0.0))
    assert not still.at(np.linspace(-1, 4, 11)).s.any()
    assert {x.name for x in (papers, triangle, still)} == {"LSPB"}


def test_equation_3_is_the_acceleration_and_a_velocity_for_a_blend_of_one_second_alone():
    """Equations (3) and (4) as printed tear equation (2) apart for other blends."""
    for t_c in (0.5, 1.0, 2.0, 3.0):
        peaks, printed = lspb(0.5, 7.0, t_c).peaks(), equation_3(0.5, 7.0, t_c)
        assert printed == pytest.approx(peaks.acceleration, rel=1e-13)
        assert (printed == pytest.approx(peaks.speed, rel=1e-3)) == (t_c == 1.0)
    for t_c, gap in ((1.0, 0.0), (2.0, 0.075)):
        dq_c = ddq_c = equation_3(0.5, 7.0, t_c)  # eq. (4): ddq_c = dq_c
        around = equation_2(np.array([t_c, np.nextafter(t_c, 8)]), 0.0, 0.5, 7.0, t_c, dq_c, ddq_c)
        assert abs(np.diff(around)[0]) == pytest.approx(gap, abs=1e-12)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((0.5, 2.0, 1.1), "blend: 1.1 s; allowed: above 0, at most 1 s, half of 2 s"),
        ((0.5, 2.0, 1.0 + 1e-11), "blend: 1 s; allowed: above 0, at most 1 s, half of 2 s"),
        ((0.5, 2.0, 0.0), "blend: 0.0; allowed: a number from 1e-09 to 1e+09"),
        ((0.5, -2.0, 0.1), "duration: -2.0; allowed: a number from 1e-09 to 1e+09"),
        ((-0.5, 2.0, 0.5), "length: -0.5; allowed: a number from 1e-09 to 1e+09"),
        ((np.nan, 2.0, 0.5), "length: nan; allowed: a number from 1e-09 to 1e+09"),
    ],
)
def test_what_does_not_exist_is_refused_with_the_feasible_range(arguments, says):
    with pytest.raises(OptionError) as fault:
        lspb(*arguments)
    assert str(fault.value) == says
    assert lspb(0.5, 2.0, 1.0 + 1e-13).knots.tolist() == [0.0, 1.0, 2.0]  # longer by rounding


def test_the_trapezoid_is_the_lspb_at_its_bounds_and_a_triangle_when_it_is_short():
    t, long, short = np.linspace(0.0, 7.0, 71), trapezoid(0.5, 0.1, 0.05), trapezoid(1.0, 5.0, 1.0)
    assert long.at(t).s == pytest.approx(lspb(0.5, 7.0, 2.0).at(t).s, abs=1e-15)
    assert (long.name, len(short.coefficients), short.duration) == ("trapezoid", 2, 2.0)
    assert short.peaks() == Peaks(1.0, 1.0, 0.0)
