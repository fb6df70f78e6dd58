"""Own sine, cosine, arctangent and arccosine: their last digits, all signs, NaN; beside mpmath and the library."""

import ctypes

import mpmath
import numpy as np
import pytest

from lwr_dyn.codegen.emit.restricted_c import c_text
from lwr_dyn.kinematics.closed_forms.texts import ANGLE_NUMBERS, with_own_angles
from tests.codegen.emit.programs import shared

LOOPS = """
void many(int which, int count, const double *y, const double *x, double *out)
{
    for (int i = 0; i < count; i++) {
        out[i] = which == 0 ? a_own_atan2(y[i], x[i]) : which == 1 ? a_own_acos(y[i])
               : which == 2 ? a_own_sin(y[i]) : a_own_cos(y[i]);
    }
}
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """(which function, y, x) -> numbers, of the C text."""
    folder = tmp_path_factory.mktemp("angles")
    (folder / "a.c").write_text("#include <math.h>\n" + c_text(with_own_angles(""), ANGLE_NUMBERS, "a") + LOOPS)
    library = shared(folder, ["a.c"], "-O1", "-std=c99")

    def call(which, y, x=None):
        y, out = np.ascontiguousarray(y), np.zeros(len(y))
        given = [np.ascontiguousarray(y if x is None else x), out]
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in (y, *given)]
        library.many(which, len(y), *pointers)
        return out

    return call


def units(found, exact):
    """Largest error in units in the last place."""
    return max(
        abs(float((mpmath.mpf(a) - b) / np.spacing(abs(float(b))))) for a, b in zip(found.tolist(), exact, strict=True)
    )


def test_atan2_and_acos_err_by_two_units_in_the_last_place(own):
    rng = np.random.default_rng(0)
    angle = np.concatenate([rng.uniform(-np.pi, np.pi, 2000), rng.uniform(0.46, 0.52, 1000)])
    size = 10.0 ** rng.uniform(-150, 150, len(angle))
    y, x = size * np.sin(angle), size * np.cos(angle)
    near = 10.0 ** rng.uniform(-16, 0, 1000)
    cosines = np.concatenate([rng.uniform(-1, 1, 1000), 1 - near, near - 1, [0.0, 1.0, -1.0]])
    with mpmath.workdps(30):
        assert units(own(0, y, x), [mpmath.atan2(b, a) for b, a in zip(y.tolist(), x.tolist(), strict=True)]) < 1.7
        assert units(own(1, cosines), [mpmath.acos(c) for c in cosines.tolist()]) < 2.1


def test_sine_and_cosine_err_by_3e_16(own):
    x = np.concatenate([np.random.default_rng(1).uniform(-100, 100, 2000), np.linspace(-10, 10, 9) * np.pi])
    with mpmath.workdps(30):
        for which, function in ((2, mpmath.sin), (3, mpmath.cos)):
            assert max(abs(a - function(b)) for a, b in zip(own(which, x).tolist(), x.tolist(), strict=True)) < 3e-16


def test_signs_of_zero_and_infinite_numbers_are_those_of_the_library(own):
    numbers = np.array([0.0, -0.0, 1.0, -1.0, 5e-324, -5e-324, 1e300, -1e300, np.inf, -np.inf])
    y, x = (a.ravel() for a in np.meshgrid(numbers, numbers))
    both = np.isinf(x) & np.isinf(y)
    found, expected = own(0, y, x), np.arctan2(y, x)
    assert np.isnan(found[both]).all()
    assert (found == expected)[~both].all()
    assert (np.signbit(found) == np.signbit(expected))[~both].all()


def test_numbers_that_are_none_pass(own):
    none = np.full(5, np.nan)
    others = np.array([0.0, -0.0, 1.0, -np.inf, np.nan])
    for found in (own(0, none, others), own(0, others, none), own(1, none), own(2, none), own(3, none)):
        assert np.isnan(found).all()
    assert np.isnan(own(1, np.array([1.0000001, -2.0]))).all()
