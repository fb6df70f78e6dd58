import numpy as np
import pytest

from lwr_dyn.checks.urdf.hulls import depth, directions, gap, reach_along, solid_hull, support_points
from lwr_dyn.checks.urdf.judgement import primitive_points
from tests.tolerances import EXACT

TURN = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
SHIFT = np.array([0.3, -1.2, 2.0])


def moved(points):
    return points @ TURN.T + SHIFT


def test_a_box_has_its_volume_centre_and_covariance():
    size = np.array([0.2, 0.7, 1.1])
    hull = solid_hull(moved(primitive_points("box", tuple(size))))
    assert hull.volume == pytest.approx(size.prod(), rel=EXACT)
    assert hull.centroid == pytest.approx(SHIFT, rel=EXACT)
    assert hull.covariance == pytest.approx(TURN @ np.diag(size**2 / 12.0) @ TURN.T, rel=1e-10, abs=EXACT)
    assert hull.diameter == pytest.approx(np.linalg.norm(size), rel=0.01)


def test_a_cylinder_has_its_volume_and_covariance():
    radius, length = 0.3, 0.9
    hull = solid_hull(primitive_points("cylinder", (radius, length)))
    across = radius**2 / 4.0
    assert hull.volume == pytest.approx(np.pi * radius**2 * length, rel=1e-10)
    assert hull.covariance == pytest.approx(np.diag([across, across, length**2 / 12.0]), rel=1e-4, abs=EXACT)


def test_a_sphere_and_a_capsule_have_their_volume_and_covariance():
    hull = solid_hull(primitive_points("sphere", (0.4,)))
    assert hull.volume == pytest.approx(4.0 / 3.0 * np.pi * 0.4**3, rel=1e-10)
    assert hull.covariance == pytest.approx(np.eye(3) * 0.4**2 / 5.0, rel=1e-2, abs=2e-4)
    capsule = solid_hull(primitive_points("capsule", (0.2, 0.5)))
    assert capsule.volume == pytest.approx(np.pi * 0.2**2 * (0.5 + 4.0 / 3.0 * 0.2), rel=0.01)


def test_a_thousand_support_directions_lose_at_most_three_percent_of_a_round_body():
    ball = np.random.default_rng(1).normal(size=(60_000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    kept = support_points(ball)
    assert len(kept) <= len(directions()) < 700
    assert 0.97 < solid_hull(kept).volume / (4.0 / 3.0 * np.pi) < 1.0


def test_support_points_pass_over_what_is_not_finite():
    points = np.vstack([primitive_points("box", (1.0, 1.0, 1.0)), [[np.nan, 0, 0], [np.inf, 0, 0]]])
    assert len(support_points(points)) == 8


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), np.eye(3), np.zeros((9, 3)), np.random.default_rng(0).normal(size=(40, 3)) * [1, 1, 0]]
)
def test_sheets_and_lines_have_no_hull(points):
    assert solid_hull(points) is None


def test_depth_is_below_zero_inside():
    hull = solid_hull(moved(primitive_points("box", (2.0, 2.0, 2.0))))
    assert depth(hull, SHIFT) == pytest.approx(-1.0)
    assert depth(hull, SHIFT + 3.0 * TURN[:, 0]) == pytest.approx(2.0)


def test_the_gap_between_two_boxes():
    hull = solid_hull(primitive_points("box", (1.0, 1.0, 1.0)))
    pose = np.eye(4)
    pose[:3, 3] = [0.0, 1.7, 0.3]
    assert gap(hull, hull, pose) == pytest.approx(0.7)
    pose[:3, 3] = [0.2, 0.9, 0.0]
    assert gap(hull, hull, pose) == 0.0


def test_reach_along_axes():
    hull = solid_hull(primitive_points("box", (2.0, 4.0, 6.0)))
    back, forth = reach_along(hull, np.eye(3), np.array([0.5, 0.0, -1.0]))
    assert np.allclose(back, [1.5, 2.0, 2.0])
    assert np.allclose(forth, [0.5, 2.0, 4.0])
