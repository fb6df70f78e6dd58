import numpy as np
import pytest

from lwr_dyn.checks.urdf.hulls import depth, directions, gap, reach_along, solid_hull, support_points
from lwr_dyn.checks.urdf.judgement import primitive_points
from tests.tolerances import EXACT

TURN = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
SHIFT = np.array([0.3, -1.2, 2.0])
BOX, CUBE = np.array([0.2, 0.7, 1.1]), solid_hull(primitive_points("box", (1.0, 1.0, 1.0)))


@pytest.mark.parametrize(
    ("kind", "size", "volume", "variances", "diameter", "rel"),
    [
        ("box", tuple(BOX), BOX.prod(), BOX**2 / 12.0, np.linalg.norm(BOX), 1e-10),
        ("cylinder", (0.3, 0.9), np.pi * 0.081, (0.0225, 0.0225, 0.0675), np.hypot(0.6, 0.9), 1e-4),
        ("sphere", (0.4,), 4.0 / 3.0 * np.pi * 0.4**3, (0.032,) * 3, 0.8, 0.01),
        ("capsule", (0.2, 0.5), np.pi * 0.04 * (0.5 + 0.8 / 3.0), None, 0.9, 0.01),
    ],
)
def test_a_solid_has_its_volume_centre_covariance_and_diameter(kind, size, volume, variances, diameter, rel):
    """By the formulas of full bodies; round ones are polytopes of nearly the same spread."""
    hull = solid_hull(primitive_points(kind, size) @ TURN.T + SHIFT)
    assert hull.volume == pytest.approx(volume, rel=0.01 if kind == "capsule" else 1e-10)
    assert hull.centroid == pytest.approx(SHIFT, abs=2e-4)
    if variances is not None:
        assert hull.covariance == pytest.approx(TURN @ np.diag(variances) @ TURN.T, rel=rel, abs=rel * 0.05)
    assert hull.diameter == pytest.approx(diameter, rel=0.015)


def test_a_thousand_support_directions_lose_at_most_three_percent_of_a_round_body():
    ball = np.random.default_rng(1).normal(size=(60_000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    kept = support_points(ball)
    assert len(kept) <= len(directions()) < 700
    assert np.linalg.norm(directions(), axis=1) == pytest.approx(1.0)
    assert 0.97 < solid_hull(kept).volume / (4.0 / 3.0 * np.pi) < 1.0
    odd = np.vstack([primitive_points("box", (1.0, 1.0, 1.0)), [[np.nan, 0, 0], [np.inf, 0, 0]]])
    assert len(support_points(odd)) == 8


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), np.eye(3), np.zeros((9, 3)), np.random.default_rng(0).normal(size=(40, 3)) * [1, 1, 0]]
)
def test_sheets_and_lines_have_no_hull(points):
    assert solid_hull(points) is None


def test_depth_gap_and_reach_of_boxes():
    """Depth is below 0 inside; a gap is along the line of the bodies, 0 where they meet."""
    moved = solid_hull(primitive_points("box", (2.0, 2.0, 2.0)) @ TURN.T + SHIFT)
    assert (depth(moved, SHIFT), depth(moved, SHIFT + 3.0 * TURN[:, 0])) == pytest.approx((-1.0, 2.0))
    pose = np.eye(4)
    for place, apart in (((0.0, 1.7, 0.3), 0.7), ((0.2, 0.9, 0.0), 0.0), ((0.1, 0.2, 0.3), 0.0)):
        pose[:3, 3] = place
        assert gap(CUBE, CUBE, pose) == pytest.approx(apart)
    turned = np.eye(4)
    turned[:3, :3], turned[:3, 3] = [[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]], (3.0, 0.0, 0.0)
    long = solid_hull(primitive_points("box", (2.0, 0.01, 0.01)))
    assert gap(CUBE, long, turned) == pytest.approx(3.0 - 0.5 - 0.6 - 0.004)
    back, forth = reach_along(
        solid_hull(primitive_points("box", (2.0, 4.0, 6.0))), np.eye(3), np.array([0.5, 0.0, -1.0])
    )
    assert (*back, *forth) == pytest.approx((1.5, 2.0, 2.0, 0.5, 2.0, 4.0), rel=EXACT)
