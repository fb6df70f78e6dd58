"""The numbers of the texts' functions of angles are those that mpmath fits."""

import mpmath
import numpy as np
import pytest

from lwr_dyn.kinematics.closed_forms.texts import ANGLE_NUMBERS, used_functions

FITTED = (  # the rest of the series in z = t^2, and the largest z
    ("SINE", lambda z: mpmath.fsum((-1) ** (k + 1) * z**k / mpmath.factorial(2 * k + 3) for k in range(26)), "pi"),
    ("COSINE", lambda z: mpmath.fsum((-1) ** k * z**k / mpmath.factorial(2 * k + 4) for k in range(26)), "pi"),
    ("ARCTANGENT", lambda z: mpmath.fsum((-1) ** (k + 1) * z**k / (2 * k + 3) for k in range(90)), "half"),
)


@pytest.mark.parametrize(("name", "series", "end"), FITTED, ids=[row[0].lower() for row in FITTED])
def test_polynomials_are_near_minimax(name, series, end):
    with mpmath.workdps(40):
        last = mpmath.mpf(1) / 4 if end == "half" else (mpmath.pi / 2) ** 2
        fitted = mpmath.chebyfit(series, [0, last], ANGLE_NUMBERS[f"{name}_TERMS"])
        # highest powers lose digits in the fit, which the result does not see
        assert np.allclose([float(x) for x in fitted], ANGLE_NUMBERS[name], rtol=1e-9, atol=0.0)
        assert [float(x) for x in fitted[-3:]] == list(ANGLE_NUMBERS[name][-3:])


def test_eighths_of_a_turn_and_pi_in_parts():
    with mpmath.workdps(60):
        for k in range(5):
            exact, near = k * mpmath.pi / 4, k * ANGLE_NUMBERS["EIGHTH"]
            assert float(exact) == near
            assert float(exact - mpmath.mpf(near)) == k * ANGLE_NUMBERS["EIGHTH_REST"]
        assert abs(mpmath.fsum(map(mpmath.mpf, ANGLE_NUMBERS["PI_PARTS"])) - mpmath.pi) < 1e-36
        assert float(1 / mpmath.pi) == ANGLE_NUMBERS["PER_HALF_TURN"]
    assert ANGLE_NUMBERS["MAGIC"] == (2.0**52 + 2.0**51)


def test_functions_that_nothing_calls_are_left_out():
    text = "static double a(double x)\n{\n    return x;\n}\n\nstatic double b(double x)\n{\n    return a(x);\n}\n"
    assert used_functions(text + "\ndouble c(double x)\n{\n    return a(x);\n}\n", ("c",)).count("static") == 1
