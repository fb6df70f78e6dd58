"""What is identified, and where a number comes from."""

from types import SimpleNamespace

import numpy as np

from lwr_dyn.identification.motion import identifiable
from lwr_dyn.identification.motion.identifiable import FROM_BOTH, FROM_LOG, FROM_TABLE, cell_origins
from lwr_dyn.identification.regression import least_squares
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, NO_ERROR, NOT_EXCITED, ZERO


def test_where_a_number_comes_from():
    assert cell_origins(np.array([0.1, 0.5, 0.95, 1.0])) == (FROM_LOG, FROM_BOTH, FROM_TABLE, FROM_TABLE)


def test_states_of_parameters():
    values, sigma = np.array([1.0, -1.0, 0.1, 0.1, 0.1, 7.0]), np.array([*[0.1] * 5, np.inf])
    own = np.array([0.0, 5.0, 0.2, 0.0, 2.0, 1.0])

    def states(dof):
        half = sigma * least_squares.student_factor(dof)
        return identifiable.parameter_states(
            SimpleNamespace(values=values, half_widths=half, determined=np.isfinite(sigma)), own
        )

    not_determined = identifiable.NOT_DETERMINED
    assert states(10**6) == (*[IDENTIFIED] * 2, NOT_EXCITED, ZERO, ZERO, not_determined)
    assert states(0) == (*[NO_ERROR] * 5, not_determined)
