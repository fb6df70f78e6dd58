"""Derivatives of functions of time, and where they jump."""

import math

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.trajectory.references.time_derivatives import TimeFunction, jump_of, time_function

TIMES = np.linspace(0.0, 2.0, 301)
W = np.array([1.0, 3.0, 14.0])


def smooth(t):
    return np.sin(W * t)


def real_only(t):
    return [math.sin(w * t) for w in W]


def forgetful(t):
    return np.sin(W * abs(t))


def assigned(t):
    q = np.zeros(3)
    q[:] = np.sin(W * t)
    return q


def relative_errors(found):
    first, second = W * np.cos(np.outer(TIMES, W)), -W * W * np.sin(np.outer(TIMES, W))
    pairs = ((found.rate(TIMES), first), (found.second_rate(TIMES), second))
    return [float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs]


@pytest.mark.parametrize(
    ("function", "exact", "least"),
    [(smooth, True, (1e-14, 1e-10)), *((one, False, (1e-9, 1e-6)) for one in (real_only, forgetful, assigned))],
)
def test_a_complex_step_is_exact_else_it_is_differenced_and_the_measured_error_bounds_the_true_one(
    function, exact, least
):
    found = time_function(function, 3, 2.0, "f", TIMES)
    assert found.takes_complex == exact
    errors = relative_errors(found)
    assert errors[0] < least[0]
    assert errors[1] < least[1]
    assert found.rate_error(TIMES) + 1e-13 > 14.0 * errors[0]
    assert found.rate_error(TIMES, second=True) > 98.0 * errors[1]


def test_no_value_outside_the_duration_is_asked_for():
    asked = []

    def watched(t):
        asked.append(t.real)
        return np.sin(W * t)

    for takes_complex in (True, False):
        function = TimeFunction(watched, 3, 2.0, "f", takes_complex)
        function.rate(TIMES), function.second_rate(TIMES, 2.0)
    assert min(asked) >= 0.0
    assert max(asked) <= 2.0


def test_a_function_that_fails_or_gives_something_else_says_when():
    with pytest.raises(OptionError, match=r"f: ZeroDivisionError at t = 0.5 s: .*that gives 3 numbers"):
        TimeFunction(lambda t: [1 / (t - 0.5)] * 3, 3, 1.0, "f").value(0.5)
    with pytest.raises(ShapeError, match=r"f at t = 0.25 s: 2 numbers; allowed: 3 numbers"):
        TimeFunction(lambda t: [t] * 2, 3, 1.0, "f").value(0.25)


@pytest.mark.parametrize("place", [0.0, 0.5, 0.73121, 1.9999])
@pytest.mark.parametrize("size", [1e-4, -0.3])
def test_a_jump_is_found_where_it_is_and_as_large(place, size):
    def value(t):
        return np.sin(W * t) + np.array([0.0, size if t > place else 0.0, 0.0])

    joint, t, found = jump_of(value, TIMES, 2e-9, 1e-8)
    assert joint == 1
    assert t == pytest.approx(place, abs=1e-8)
    assert found == pytest.approx(size, rel=0.3)


@pytest.mark.parametrize("frequency", [0.1, 3.0, 50.0])
def test_a_fast_smooth_function_does_not_jump(frequency):
    assert jump_of(lambda t: np.sin(2.0 * np.pi * frequency * t + np.arange(3)), TIMES, 2e-9, 1e-8) is None
