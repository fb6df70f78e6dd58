"""Derivatives by central differences of order eight, which are exact for the polynomials of motion profiles."""

from itertools import pairwise

import numpy as np

STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


def slope(values, step):
    """Derivatives (k, ...) from the values (8 k, ...) at `places_around` k places."""
    values = np.asarray(values)
    return np.einsum("ks...,s->k...", values.reshape(-1, 8, *values.shape[1:]), WEIGHTS) / step


def places_around(places, step):
    """(8 k,) about the places (k,)."""
    return (np.asarray(places)[:, None] + step * STENCIL).ravel()


def check_derivatives(at, places, step, names, **tolerance):
    """Of the record `at(places)` each of the names is the derivative of the one before."""
    here, around = at(places), at(places_around(places, step))
    for value, rate in pairwise(names):
        expected = slope(getattr(around, value), step)
        np.testing.assert_allclose(getattr(here, rate), expected, err_msg=rate, **tolerance)
