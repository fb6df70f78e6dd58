"""Paths in space: corners and bends between segments, continuity, and what is refused."""

import math

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.spatial import rot_x, rot_z
from lwr_dyn.trajectory.path import PathJoint, arc, line, path_of
from tests.trajectory.differences import check_derivatives

STEP = 1e-4
"""[m] Eighth-order differences of curves with radii of centimetres: truncation 1e-16, rounding 1e-16 / 1e-4 = 1e-12."""


def letter():
    """A line, a corner of 90 deg, a line, a bend into a half circle."""
    strokes = [line((0, 0, 0.3), (0, 0, 0)), line((0, 0, 0), (0, 0.1, 0))]
    return path_of([*strokes, arc((0, 0.1, 0), (0, 0.1, 0.075), (1, 0, 0), math.pi)])


def test_corners_are_distinguished_from_bends():
    path = letter()
    corner, bend = path.joints()
    assert path.corners() == (corner,)
    assert (corner.s, corner.turn, corner.bend) == pytest.approx((0.3, math.pi / 2, 0.0))
    assert (bend.s, bend.turn, bend.bend) == pytest.approx((0.4, 0.0, 1 / 0.075))
    marks = [(x.is_corner, x.is_bend) for x in (corner, bend, PathJoint(0.1, 1e-6, 1e-6), PathJoint(0.1, 1.1e-6, 2.0))]
    assert marks == [(True, False), (False, True), (False, False), (True, False)]
    np.testing.assert_allclose(path.sections(), [0.3, 0.1 + 0.075 * math.pi])
    np.testing.assert_allclose(path.starts, [0.0, 0.3, 0.4, 0.4 + 0.075 * math.pi])


def test_the_path_is_continuous_over_its_joints_and_clipped_at_its_ends():
    path = letter()
    for s in path.starts[1:-1]:
        a, b = path.at([s - 1e-12, s]).p
        np.testing.assert_allclose(a, b, atol=1e-11)
    np.testing.assert_allclose(path.at([-1.0, path.length + 1.0]).p, [[0, 0, 0.3], [0, 0.1, 0.15]], atol=1e-15)
    here = path.at([0.3])
    np.testing.assert_array_equal(here.dp, [[0, 1, 0]])  # of the segment that begins there
    assert not any(
        x.flags.writeable for x in (here.p, here.dp, here.ddp, path.segments[0].start, path.segments[2].centre)
    )


def assert_smooth_curve(segment, margin=5 * STEP):
    s = np.linspace(margin, segment.length - margin, 41)
    here = segment.at(s)
    np.testing.assert_allclose(np.linalg.norm(here.dp, axis=1), 1.0, atol=1e-12)
    check_derivatives(segment.at, s, STEP, ("p", "dp"), atol=1e-11)
    most = max(100.0, float(np.abs(here.ddp).max()))
    check_derivatives(segment.at, s, STEP, ("dp", "ddp"), atol=1e-11 * most)


@pytest.mark.parametrize("turn", [None, 1.3, -2 * math.pi])
def test_segments_have_unit_speed_and_exact_derivatives(turn):
    start, centre = (0.3, 0.1, 0), (0.2, 0.1, 0)
    assert_smooth_curve(line((1, 2, 3), (1.1, 2.2, 2.7)) if turn is None else arc(start, centre, (0, 0, 2), turn))


def test_an_arc_ends_where_the_turn_about_its_normal_puts_it():
    start, centre, angle = np.array([0.3, 0.1, 0.5]), np.array([0.2, 0.1, 0.5]), -0.8
    segment = arc(start, centre, (0, 0, 7), angle)
    assert segment.length == pytest.approx(0.1 * 0.8)
    ends = segment.at(np.array([0.0, segment.length]))
    np.testing.assert_allclose(ends.p, [start, centre + rot_z(angle) @ (start - centre)], atol=1e-15)
    np.testing.assert_allclose(ends.dp[0], [0, -1, 0], atol=1e-15)  # clockwise


ARC = "; allowed: |angle| up to 2 pi, length at least 1e-06 m"
TURN = 2.0 * math.pi
BAD = [
    (lambda: path_of([]), OptionError, "segments: none; allowed: at least one segment"),
    (lambda: path_of([line((0, 0, 0), (1, 0, 0)), line((1.5, 0, 0), (2, 0, 0))]), OptionError,
     "segments: a gap of 0.5 m between 0 and 1; allowed: at most 1e-09 m"),
    (lambda: line((0, 0, 0), (9e-7, 0, 0)), OptionError, "line: 9e-07 m long; allowed: at least 1e-06 m from"),
    (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 0), 1.0), OptionError, "normal: the zero vector; allowed: a direction"),
    (lambda: arc((1, 0, 2e-9), (0, 0, 0), (0, 0, 1), 1.0), OptionError,
     "start: 2e-09 m off the arc's plane; allowed: at most 1e-09 m"),
    (lambda: arc((1, 0, 0), (1, 0, 0), (0, 0, 1), 1.0), OptionError, "arc: radius 0 m, angle 1 rad" + ARC),
    (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 1), 9e-7), OptionError, "arc: radius 1 m, angle 9e-07 rad" + ARC),
    (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 1), -7.0), OptionError, "arc: radius 1 m, angle -7 rad" + ARC),
    (lambda: arc((1, 0, 0), (0, 0, 0), (0, 0, 1), math.nan), OptionError, "arc: radius 1 m, angle nan rad" + ARC),
    (lambda: line((0, 0), (1, 1, 1)), ShapeError, "start: 2 numbers; allowed: 3 numbers"),
    (lambda: line((0, 0, 0), (1, np.nan, 1)), ShapeError, "end: nan at index (1,)"),
    (lambda: arc((1, 0, 0), (0, 0, 0), rot_x(0.1), 1.0), ShapeError, "normal: "),
]  # fmt: skip


@pytest.mark.parametrize(("make", "error", "says"), BAD, ids=[says for *_, says in BAD])
def test_what_is_no_path_is_refused(make, error, says):
    with pytest.raises(error) as fault:
        make()
    assert str(fault.value).startswith(says)
    assert len(path_of([line((0, 0, 0), (1, 0, 0)), line((1, 0, 1e-9), (2, 0, 0))]).segments) == 2  # off by rounding
    assert line((0, 0, 0), (1e-6, 0, 0)).length == 1e-6
    assert arc((1, 0, 1e-9), (0, 0, 0), (0, 0, 1), -TURN).length == pytest.approx(TURN)
