"""Input checks of arrays: what passes comes back as float64, what does not is one `ShapeError` that names it."""

from dataclasses import dataclass

import numpy as np
import pytest

from lwr_dyn.foundation.arrays import fixed_array, freeze_arrays, joint_array, read_only, real_array, same_batch
from lwr_dyn.foundation.errors import ShapeError


@pytest.mark.parametrize("value", [[0, 1], (True, False), np.zeros((4, 3, 2), dtype=np.int8), np.zeros((0, 2))])
def test_joint_vectors_of_any_number_type_and_batch_become_float64(value):
    array = joint_array("q", value, 2)
    assert array.dtype == np.float64
    assert array.shape == np.shape(value)
    np.testing.assert_array_equal(array, value)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (0.0, "q: a single number; allowed: 2 numbers, one per joint"),
        ([1.0, 2.0, 3.0], "q: 3 numbers; allowed: 2 numbers, one per joint"),
        ([1.0], "q: 1 number; allowed: 2 numbers, one per joint"),
        (["a", "b"], "q: not an array of numbers; allowed: real numbers"),
        ([[1.0], [2.0, 3.0]], "q: not an array of numbers; allowed: real numbers"),
        (None, "q: nan; allowed: finite numbers"),
        ([1j, 0.0], "q: complex numbers; allowed: real numbers"),
        ([[0.0, 1.0], [np.inf, np.nan]], "q: inf at index (1, 0); allowed: finite numbers"),
    ],
)
def test_what_is_no_joint_vector_is_refused(value, message):
    with pytest.raises(ShapeError) as fault:
        joint_array("q", value, 2)
    assert str(fault.value) == message


def test_a_fixed_shape_is_exact_and_any_shape_is_free():
    assert fixed_array("point", (0, 0, 1), (3,)).tolist() == [0.0, 0.0, 1.0]
    with pytest.raises(ShapeError, match="point: an array of 1 x 3 numbers; allowed: 3 numbers"):
        fixed_array("point", [[0, 0, 1]], (3,))
    with pytest.raises(ShapeError, match="mass: 2 numbers; allowed: one number"):
        fixed_array("mass", [1, 2], ())
    assert real_array("x", [[[1]]]).shape == (1, 1, 1)


def test_batches_broadcast_or_name_the_arrays_that_do_not():
    assert same_batch(q=np.zeros((5, 1, 7)), dq=np.zeros((4, 7)), ddq=np.zeros(7)) == (5, 4)
    with pytest.raises(ShapeError, match=r"q, dq: q \(5, 7\), dq \(4, 7\); allowed: leading axes that broadcast"):
        same_batch(q=np.zeros((5, 7)), dq=np.zeros((4, 7)))


def test_fields_of_a_record_become_copies_that_cannot_be_changed():
    @dataclass(frozen=True)
    class Record:
        x: np.ndarray

        def __post_init__(self):
            freeze_arrays(self, "x")

    given = np.ones(2)
    kept, copy = Record(given).x, read_only(given)
    given[0] = 5.0
    assert kept.tolist() == copy.tolist() == [1.0, 1.0]
    for array in (kept, copy):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 2.0
