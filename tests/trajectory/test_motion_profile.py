"""Motion profiles: derivatives against differences, bounds, ends, and what is refused."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.motion_profile import concatenate, constant_speed, quintic, stretched
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
