"""The path of a reference in pieces, and profiles put together again."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.design.path_pieces import joined, path_of_reference
from lwr_dyn.trajectory.motion_profile import quintic

ARM = lwr_dyn.load("lwr4plus")


def test_each_piece_begins_at_its_cut_to_the_last_bit():
    """0.1 + 0.2 is not 0.3: a start before the corner would take the direction before it."""
    whole = joined([quintic(0.1, 1.0), quintic(0.2, 1.0), quintic(0.3, 1.0)], np.array([0.0, 0.1, 0.3, 0.6]))
    assert whole.at(np.array([1.0, 2.0])).s.tolist() == [0.1, 0.3]
    assert whole.length == 0.6


def test_ist_is_cut_at_its_corners_and_bends_are_known():
    path = path_of_reference(lwr_dyn.reference("ist", ARM))
    assert [round(piece.length, 3) for piece in path.pieces] == [0.3, 0.721, 0.05, 0.3]
    assert [piece.breaks.size for piece in path.pieces] == [0, 6, 0, 0]
    assert path.pieces[1].breaks[:2] == pytest.approx([0.095, 0.105], abs=1e-4)  # 5 mm before and after the first arc


@pytest.mark.slow
@pytest.mark.parametrize("task", ["ist", "line"])
def test_a_piece_is_the_path_with_its_derivatives(task):
    options = {} if task == "ist" else {"start": [0.0, 0.5, 0.0, -1.2, 0.0, 0.6, 0.0], "to_xyz": [-0.3, 0.2, 0.5]}
    reference = lwr_dyn.reference(task, ARM, **options)
    piece = path_of_reference(reference).pieces[0]
    s, h = np.linspace(0.1, 0.9, 9) * piece.length, 1e-6 * piece.length
    (q, first, second), ahead, behind = (piece.curve(x) for x in (s, s + h, s - h))
    assert (ahead[0] - behind[0]) / (2.0 * h) == pytest.approx(first, abs=1e-6)
    assert (ahead[1] - behind[1]) / (2.0 * h) == pytest.approx(second, abs=1e-4)
    assert q.shape == (9, 7)
