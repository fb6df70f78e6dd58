"""Paths in space: corners and bends between segments, continuity, and what is refused."""

import math

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
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
