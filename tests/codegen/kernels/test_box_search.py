"""The search over boxes, compiled, against the same text as Python, and against the function on a grid."""

import numpy as np
import pytest

from lwr_dyn.codegen.kernels.box_search import NUMBERS, box_search, search_text
from lwr_dyn.control.inertia.bernstein import WAVES, halves
from lwr_dyn.control.inertia.certificate import LEVELS, Halvings
from lwr_dyn.kinematics.closed_forms.python_text import python_text

SHAPE = (5, 3, 5)
"""A turning, a sliding and a turning joint."""


def halvings():
    lefts, rights = np.zeros((2, 3, LEVELS, WAVES, WAVES))
    for j, count in enumerate(SHAPE):
        for level in range(LEVELS):
            left, right = halves(count == 5, 1.0 / 2**level)
            lefts[j, level, :count, :count], rights[j, level, :count, :count] = left, right
    corners = np.arange(75).reshape(SHAPE)[np.ix_([0, 4], [0, 2], [0, 4])].ravel()
    return Halvings(np.array(SHAPE), lefts, rights, corners)


def by_python(given, pool, gap, known, most):
    names, out, rows = dict(NUMBERS), [0.0] * 3, len(pool) - 1
    exec(python_text(search_text()), names)
    flat, levels = pool.ravel().tolist(), [0.0] * ((rows + 1) * 3)
    names["search"](
        given.counts, 3, given.lefts.ravel(), 0, given.rights.ravel(), rows, given.corners, 8, levels, 75, [gap, known],
        most, out, flat, 0, 0,
    )  # fmt: skip
    return tuple(out)


@pytest.mark.parametrize(("rows", "most"), [(40, 10**6), (40, 9), (4, 10**6)])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_bound_is_that_of_the_text_as_python_and_above_all_values(seed, rows, most):
    """Enough boxes; too few; too few rows: the bound is larger then, and holds."""
    given, values = halvings(), np.random.default_rng(seed).uniform(-1.0, 1.0, 75)
    pool = np.zeros((rows, 75))
    pool[0] = values
    known = values[given.corners].max()
    bound, met, boxes = box_search()(given, pool.copy(), 1e-3, known, most)
    assert (bound, met, boxes) == by_python(given, pool, 1e-3, known, most)
    assert boxes < most + rows  # those that wait are counted
    assert known <= met <= bound <= max(values.max(), met)
    if rows == 40:
        assert (bound <= met + 1e-3 * abs(met)) == (most > 9)
