import numpy as np
import pytest

from lwr_dyn.checks.urdf.hulls import solid_hull
from lwr_dyn.checks.urdf.judgement import primitive_points
from lwr_dyn.checks.urdf.undoings import MassPoint, bound_ratio, log_distance, off_centre, outside, spread_ratios
from tests.tolerances import EXACT

SIZE = np.array([0.2, 0.3, 0.5])
HULL = solid_hull(primitive_points("box", tuple(SIZE)))
MASS = 3.0
FULL = MASS / 12.0 * np.diag((SIZE**2).sum() - SIZE**2)


def test_a_full_body_has_ratios_of_one():
    assert spread_ratios(FULL, MASS, HULL) == pytest.approx(np.ones(3), rel=1e-10)
    assert log_distance(spread_ratios(FULL, MASS, HULL)) == pytest.approx(0.0, abs=1e-9)


def test_ratios_scale_with_the_tensor_and_against_the_mass_in_batches():
    ratios = spread_ratios(np.array([FULL, 10.0 * FULL]), 2.0 * MASS, HULL)
    assert ratios == pytest.approx(np.array([[0.5] * 3, [5.0] * 3]), rel=1e-10)


def test_half_the_mass_at_either_end_reaches_the_bound():
    ends = MASS * (SIZE[2] / 2.0) ** 2
    point = MassPoint(MASS, np.zeros(3), np.diag([ends, ends, 1e-9]))
    assert bound_ratio(point, HULL) == pytest.approx(1.0, rel=1e-6)
    assert bound_ratio(MassPoint(MASS, np.zeros(3), FULL), HULL) == pytest.approx(1.0 / 3.0, rel=1e-9)
    assert bound_ratio(MassPoint(MASS, np.array([0.0, 0.0, 9.0]), FULL), HULL) < 1.0


def test_centres():
    assert outside(np.array([0.6, 0.0, 0.0]), HULL) == pytest.approx(0.5 / HULL.diameter, rel=EXACT)
    assert outside(np.zeros(3), HULL) < 0.0
    assert off_centre(np.array([0.0, 0.0, 0.5]), HULL) == pytest.approx(12.0**0.5, rel=1e-9)
