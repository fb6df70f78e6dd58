"""The verdict of an audit: the largest gap against its tolerance."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.simulation.audit import Audit


def test_a_run_is_closed_where_the_largest_gap_is_within_its_tolerance():
    gaps = Audit(1e-6, 0.0, {}, actuator_gap=2e-6, energy_gap=None, other_road=None, tolerance=1e-5)
    assert (gaps.worst_energy, gaps.worst, gaps.is_closed()) == (2e-6, pytest.approx(0.2), True)
    tight = replace(gaps, tolerance=1e-6)
    assert (tight.worst, tight.is_closed()) == (pytest.approx(2.0), False)
    assert not replace(gaps, residual=np.nan).is_closed()
