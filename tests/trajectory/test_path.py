"""Paths in space: corners and bends between segments, continuity, and what is refused."""

import math

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.spatial import rot_x, rot_z
from lwr_dyn.trajectory.path import arc, line, path_of


def letter():
    """A line, a corner of 90 deg, a line, a bend into a half circle."""
    return path_of(
        [
            line((0, 0, 0.3), (0, 0, 0)),
            line((0, 0, 0), (0, 0.1, 0)),
            arc((0, 0.1, 0), (0, 0.1, 0.075), (1, 0, 0), math.pi),
        ]
    )


def test_corners_are_distinguished_from_bends():
    corner, bend = letter().joints()
    assert corner.is_corner
    assert not corner.is_bend
    assert corner.turn == pytest.approx(math.pi / 2)
    assert bend.is_bend
    assert not bend.is_corner
    assert bend.bend == pytest.approx(1 / 0.075)
    np.testing.assert_allclose(letter().sections(), [0.3, 0.1 + 0.075 * math.pi])


def test_the_path_is_continuous_over_its_joints_and_clipped_at_its_ends():
    path = letter()
    for s in path.starts[1:-1]:
        a, b = path.at([s - 1e-12, s]).p
        np.testing.assert_allclose(a, b, atol=1e-11)
    np.testing.assert_allclose(path.at([-1.0, path.length + 1.0]).p, [[0, 0, 0.3], [0, 0.1, 0.15]], atol=1e-15)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: path_of([]), "at least one segment"),
        (lambda: path_of([line((0, 0, 0), (1, 0, 0)), line((1.5, 0, 0), (2, 0, 0))]), "a gap of 0.5 m between 0 and 1"),
    ],
)
def test_what_is_no_path_is_refused(make, says):
    with pytest.raises(OptionError, match=says):
        make()


STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
STEP = 1e-4
"""[m] Eighth-order differences of curves with radii of centimetres: truncation 1e-16, rounding 1e-16 / 1e-4 = 1e-12."""
UNIT = 1e-12
DIFFERENCE = 1e-11
"""Times 1 for dp; ddp gets it relative to its own size, up to 100 / m."""


def assert_smooth_curve(segment, margin=5 * STEP):
    s = np.linspace(margin, segment.length - margin, 41)
    here = segment.at(s)
    np.testing.assert_allclose(np.linalg.norm(here.dp, axis=1), 1.0, atol=UNIT)
    around = segment.at((s[:, None] + STEP * STENCIL).ravel())
    dp = np.einsum("ksx,s->kx", around.p.reshape(len(s), -1, 3), WEIGHTS) / STEP
    ddp = np.einsum("ksx,s->kx", around.dp.reshape(len(s), -1, 3), WEIGHTS) / STEP
    np.testing.assert_allclose(here.dp, dp, atol=DIFFERENCE)
    np.testing.assert_allclose(here.ddp, ddp, atol=DIFFERENCE * max(100.0, float(np.abs(ddp).max())))


@pytest.mark.parametrize(
    "segment",
    [
        line((1, 2, 3), (1.1, 2.2, 2.7)),
        arc((0.3, 0.1, 0), (0.2, 0.1, 0), (0, 0, 2), 1.3),
        arc((0.3, 0.1, 0), (0.2, 0.1, 0), (0, 0, 2), -2 * math.pi),
    ],
)
def test_segments_have_unit_speed_and_exact_derivatives(segment):
    assert_smooth_curve(segment)


def test_an_arc_ends_where_the_turn_about_its_normal_puts_it():
    start, centre, angle = np.array([0.3, 0.1, 0.5]), np.array([0.2, 0.1, 0.5]), -0.8
    segment = arc(start, centre, (0, 0, 7), angle)
    assert segment.length == pytest.approx(0.1 * 0.8)
    np.testing.assert_allclose(
        segment.at(np.array([segment.length])).p[0], centre + rot_z(angle) @ (start - centre), atol=1e-15
    )
    tangent = segment.at(np.array([0.0])).dp[0]
    np.testing.assert_allclose(tangent, [0, -1, 0], atol=1e-15)  # clockwise


def test_points_have_three_finite_coordinates():
    with pytest.raises(ShapeError, match="start"):
        line((0, 0), (1, 1, 1))
    with pytest.raises(ShapeError, match="nan"):
        line((0, 0, 0), (1, np.nan, 1))
    with pytest.raises(ShapeError):
        arc((1, 0, 0), (0, 0, 0), rot_x(0.1), 1.0)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: line((0, 0, 0), (0, 0, 0)), "line: 0 m long"),
        (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 0), 1.0), "normal"),
        (lambda: arc((1, 0, 0.1), (0, 0, 0), (0, 0, 1), 1.0), "off the arc's plane"),
        (lambda: arc((1, 0, 0), (1, 0, 0), (0, 0, 1), 1.0), "radius 0 m"),
        (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 1), 7.0), "angle 7 rad"),
        (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 1), math.nan), "angle nan rad"),
    ],
)
def test_what_is_no_segment_is_refused(make, says):
    with pytest.raises(OptionError, match=says):
        make()
