"""Fourier motions: rest at both ends, exact derivatives, what they refuse."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.excitation.objectives import MOST_HARMONICS, fourier_basis

T, H, N = 7.0, 4, 3


@pytest.fixture
def series():
    basis = fourier_basis(T, H, 30)
    return basis, np.random.default_rng(0).normal(size=(basis.count, N))


def test_it_is_at_rest_at_both_ends_and_outside(series):
    basis, X = series
    motion = basis.motion(X)
    ends = motion.sample([-1.0, 0.0, T, T + 1.0])
    assert np.abs(ends.dq).max() < 1e-13
    assert np.abs(ends.ddq).max() < 1e-12
    assert np.ptp(ends.q, axis=0).max() < 1e-13
    assert np.abs(motion.sample([0.3]).dq).min() > 1e-3


def test_every_motion_at_rest_at_its_ends_is_one_of_the_basis():
    basis = fourier_basis(T, H, 30)
    assert basis.count == 2 * H - 1
    assert np.allclose(basis.free[1:].T @ basis.free[1:], np.diag([0.0, *[1.0] * (2 * H - 2)]), atol=1e-14)


def test_speeds_and_accelerations_are_derivatives(series):
    basis, X = series
    t, h = np.linspace(0.5, 6.5, 50), 1e-5
    low, middle, high = (basis.motion(X).sample(t + d) for d in (-h, 0.0, h))
    assert np.abs((high.q - low.q) / (2 * h) - middle.dq).max() < 1e-8
    assert np.abs((high.dq - low.dq) / (2 * h) - middle.ddq).max() < 1e-8


def test_the_basis_is_the_motion_at_its_instants(series):
    basis, X = series
    found = basis.motion(X).sample(np.arange(30) * T / 30)
    for matrix, values in ((basis.position, found.q), (basis.speed, found.dq), (basis.acceleration, found.ddq)):
        assert np.abs(matrix @ X - values).max() < 1e-12


@pytest.mark.parametrize("numbers", [(0.0, 5), (np.nan, 5), (-1.0, 5), (10.0, 1), (10.0, MOST_HARMONICS + 1)])
def test_numbers_that_make_no_series_are_refused(numbers):
    with pytest.raises(OptionError):
        fourier_basis(*numbers, 10)
