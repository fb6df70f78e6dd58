"""Paths in space: unit speed, derivatives against differences, joints, blends."""

import math
from itertools import pairwise

import numpy as np
import pytest

from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.model.spatial import rot_x, rot_z
from lwr_dyn.trajectory.blends import blended
from lwr_dyn.trajectory.path import path_of
from lwr_dyn.trajectory.segments import arc, line

STENCIL = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
STEP = 1e-4
"""[m] Eighth-order differences of curves with radii of centimetres: truncation 1e-16, rounding 1e-16 / 1e-4 = 1e-12."""
UNIT = 1e-12
DIFFERENCE = 1e-11
"""Times 1 for dp; ddp gets it relative to its own size, up to 100 / m."""


def letter():
    """A line, a corner of 90 deg, a line, a bend into a half circle."""
    return path_of(
        [
            line((0, 0, 0.3), (0, 0, 0)),
            line((0, 0, 0), (0, 0.1, 0)),
            arc((0, 0.1, 0), (0, 0.1, 0.075), (1, 0, 0), math.pi),
        ]
    )


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


def test_joints_tell_corners_from_bends():
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


def test_blended_joints_have_continuous_tangent_and_curvature():
    path = blended(letter(), corners=0.03, bends=0.01)
    assert len(path.segments) == 5
    for joint in path.joints():
        assert joint.turn < 1e-7
        assert joint.bend < 1e-7
    assert path.corners() == ()
    for segment in path.segments:
        assert_smooth_curve(segment)


@pytest.mark.parametrize("turn_deg", [20, 90, 140])
def test_the_length_on_a_blend_is_the_length_of_its_chords(turn_deg):
    turn = math.radians(turn_deg)
    after = (math.cos(turn), math.sin(turn), 0)
    path = blended(path_of([line((-1, 0, 0), (0, 0, 0)), line((0, 0, 0), after)]), corners=0.3)
    blend = path.segments[1]
    ends = np.linspace(0.0, blend.length, 4)
    for a, b in pairwise(ends):
        chords = [np.linalg.norm(np.diff(blend.at(np.linspace(a, b, k)).p, axis=0), axis=1).sum() for k in (2001, 4001)]
        assert (4.0 * chords[1] - chords[0]) / 3.0 == pytest.approx(b - a, abs=1e-12)  # without the sagitta's square


def test_blends_stay_near_the_path_they_round():
    sharp, size = letter(), 0.005
    eased = blended(sharp, bends=size)
    dense = sharp.at(np.linspace(0, sharp.length, 200_001)).p
    near = eased.at(np.linspace(0.39, 0.41, 41)).p
    away = max(float(np.min(np.linalg.norm(dense - p, axis=1))) for p in near)
    assert 1e-6 < away < 0.1 * size**2 / 0.075  # a fraction of the sagitta size^2 / radius
    assert abs(eased.length - sharp.length) < 1e-5


def test_a_corner_that_turns_back_is_kept_for_a_stop():
    path = blended(path_of([line((0, 0, 0), (0, 1, 0)), line((0, 1, 0), (0, 0.5, 0))]), corners=0.1)
    (corner,) = path.corners()
    assert corner.turn == pytest.approx(math.pi)
    assert path.sections() == (1.0, 0.5)


def test_blends_may_use_up_a_segment_but_no_more():
    path = path_of([line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (1, 1, 0)), line((1, 1, 0), (0, 1, 0))])
    assert len(blended(path, corners=0.5).segments) == 4  # the middle line is gone
    with pytest.raises(OptionError, match=r"0\.6 m and 0\.6 m at the ends of segment 1; allowed: together at most"):
        blended(path, corners=0.6)
    with pytest.raises(OptionError, match=r"corners: -0\.1"):
        blended(path, corners=-0.1)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: line((0, 0, 0), (0, 0, 0)), "line: 0 m long"),
        (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 0), 1.0), "normal"),
        (lambda: arc((1, 0, 0.1), (0, 0, 0), (0, 0, 1), 1.0), "off the arc's plane"),
        (lambda: arc((1, 0, 0), (1, 0, 0), (0, 0, 1), 1.0), "radius 0 m"),
        (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 1), 7.0), "angle 7 rad"),
        (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 1), math.nan), "angle nan rad"),
        (lambda: path_of([]), "at least one segment"),
        (lambda: path_of([line((0, 0, 0), (1, 0, 0)), line((1.5, 0, 0), (2, 0, 0))]), "a gap of 0.5 m between 0 and 1"),
    ],
)
def test_what_is_no_path_is_refused(make, says):
    with pytest.raises(OptionError, match=says):
        make()


def test_points_have_three_finite_coordinates():
    with pytest.raises(ShapeError, match="start"):
        line((0, 0), (1, 1, 1))
    with pytest.raises(ShapeError, match="nan"):
        line((0, 0, 0), (1, np.nan, 1))
    with pytest.raises(ShapeError):
        arc((1, 0, 0), (0, 0, 0), rot_x(0.1), 1.0)
