"""What is identified, and where a number comes from."""

from types import SimpleNamespace

import numpy as np

from lwr_dyn.identification.motion.identifiable import (
    FROM_BOTH,
    FROM_LOG,
    FROM_TABLE,
    NOT_DETERMINED,
    cell_origins,
    parameter_states,
)
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, NO_ERROR, NOT_EXCITED, ZERO


def test_where_a_number_comes_from():
    table = np.array([1.0, 1.0, 1.0, 0.0])
    assert cell_origins(np.array([0.1, 0.5, 0.95, 0.0]), table) == (FROM_LOG, FROM_BOTH, FROM_TABLE, FROM_TABLE)


def test_states_of_parameters():
    values, sigma = np.array([1.0, -1.0, 0.1, 0.1, 0.1, 7.0]), np.array([*[0.1] * 5, np.inf])
    log = SimpleNamespace(values=values, sigma=sigma, dof=10**6, determined=np.isfinite(sigma))
    own = np.array([0.0, 5.0, 0.2, 0.0, 2.0, 1.0])
    assert parameter_states(log, own) == (IDENTIFIED, IDENTIFIED, NOT_EXCITED, ZERO, ZERO, NOT_DETERMINED)
    none_left = SimpleNamespace(values=values, sigma=sigma, dof=0, determined=np.isfinite(sigma))
    assert parameter_states(none_left, own) == (*[NO_ERROR] * 5, NOT_DETERMINED)
