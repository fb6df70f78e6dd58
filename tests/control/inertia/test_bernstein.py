"""Control values: they give the function back, they bound it, and halving never widens them."""

from math import comb

import numpy as np
import pytest

from lwr_dyn.control.inertia.bernstein import control_matrix, halves, nodes

INTERVALS = ((-0.3, 0.9), (2.0, 3.4), (0.1, 0.11), (-4.0, -2.3))


def wave(a, x):
    return a[0] + a[1] * np.cos(x) + a[2] * np.sin(x) + a[3] * np.cos(2 * x) + a[4] * np.sin(2 * x)


def parabola(a, x):
    return a[0] + a[1] * x + a[2] * x**2


def blended(control, is_turning, lower, upper, x):
    """The function from its control values, by the weights as they are defined."""
    w, t = (upper - lower) / 2, x - (upper + lower) / 2
    degree = len(control) - 1
    if not is_turning:
        s = (x - lower) / (upper - lower)
        return sum(comb(2, k) * (1 - s) ** (2 - k) * s**k * control[k] for k in range(3))
    S, R = np.sin((w - t) / 2) / np.sin(w), np.sin((w + t) / 2) / np.sin(w)
    c = [1, np.cos(w), (1 + 2 * np.cos(w) ** 2) / 3, np.cos(w), 1]
    return sum(comb(degree, k) * c[k] * control[k] * S ** (degree - k) * R**k for k in range(degree + 1))


def test_values_control_points_and_halves_agree():
    rng = np.random.default_rng(0)
    for is_turning, function, size in ((True, wave, 5), (False, parabola, 3)):
        for lower, upper in INTERVALS:
            a, x, middle = rng.normal(size=size), np.linspace(lower, upper, 101), (lower + upper) / 2
            values = function(a, nodes(is_turning, lower, upper))
            control = control_matrix(is_turning, lower, upper) @ values
            assert np.abs(blended(control, is_turning, lower, upper, x) - function(a, x)).max() < 1e-12
            assert control.max() >= function(a, x).max() - 1e-14
            assert control.min() <= function(a, x).min() + 1e-14
            left, right = halves(is_turning, (upper - lower) / 2)
            for matrix, ends in ((left, (lower, middle)), (right, (middle, upper))):
                y = np.linspace(*ends, 9)
                assert np.abs(blended(matrix @ control, is_turning, *ends, y) - function(a, y)).max() < 1e-12


@pytest.mark.parametrize("w", [0.87, 0.3, 1e-3, 1e-8])
@pytest.mark.parametrize("is_turning", [True, False])
def test_halving_takes_averages(is_turning, w):
    for matrix in halves(is_turning, w):
        assert (matrix >= 0).all()
        assert np.abs(matrix.sum(axis=1) - 1).max() < 1e-15


def test_the_nodes_and_corners_are_values():
    assert np.allclose(np.diff(nodes(True, 0.0, 0.0)).astype(float), 2 * np.pi / 5)
    assert nodes(False, -1.0, 3.0).tolist() == [-1.0, 1.0, 3.0]
    matrix = control_matrix(True, 0.2, 1.4)
    assert float(matrix[0] @ np.cos(nodes(True, 0.0, 0.0))) == pytest.approx(np.cos(0.2), abs=1e-15)
    assert float(matrix[-1] @ np.cos(nodes(True, 0.0, 0.0))) == pytest.approx(np.cos(1.4), abs=1e-15)
