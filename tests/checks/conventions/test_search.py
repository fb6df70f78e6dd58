"""What links add to B_ii and g_i, against the recursion; and the search, against the full product."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.checks.conventions import search
from lwr_dyn.checks.conventions.evidence import DerivedNumber, evidence_number
from lwr_dyn.checks.conventions.hypotheses import other_ends
from lwr_dyn.checks.conventions.printed_table import CHOICES, TENSOR, TableChoice, link_options
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import JointKind
from tests.checks.conventions.scrambled_tables import scrambled_table
from tests.random_arms import random_arm

Q = np.array([0.3, -1.1, 0.8])
ROUNDING = 1e-12
"""Relative, a few hundred roundings of 1e-16."""


def parameters(chain):
    rows = []
    for body in chain.bodies:
        origin = body.inertia_origin()
        rows.append([body.mass, *(body.mass * body.com), *(origin[r, c] for r, c in TENSOR)])
    return np.array(rows)


@pytest.mark.parametrize("seed", range(12))
def test_contributions_sum_to_the_recursion(seed):
    chain = random_arm(seed, ("RR", "RPRRR", "PRRPRRR", "RRRRRRR")[seed % 4]).chain
    q = np.random.default_rng(seed).uniform(-2, 2, (4, chain.n))
    recursion = Recursion.of(chain, "none")
    B, g = recursion.mass_matrix(q), recursion.gravity_vector(q)
    for i in range(chain.n):
        for quantity, expected in (("inertia", B[:, i, i]), ("gravity", g[:, i])):
            ours = np.einsum("pij,ij->p", search.contribution_rows(chain, quantity, i, q), parameters(chain))
            assert np.abs(ours - expected).max() <= ROUNDING * max(1.0, np.abs(expected).max())


def small(numbers=()):
    """Three links, no rows shifted: the table, its options and the rows of numbers at one pose."""
    tables = (scrambled_table(np.random.default_rng([3, k])) for k in range(100))
    one = next(t for t in tables if t.table.n == 3 and not t.truth.shift)
    ends = other_ends(one.table, one.truth.table.convention)
    options = [link_options(one.table, i, one.truth.table, ends[i], CHOICES[:8]) for i in range(3)]
    diagonal = np.diag(Recursion.of(one.chain).mass_matrix(Q))
    texts = numbers or [(j, f"{diagonal[j]:.4g}") for j in range(3)]
    derived = tuple(DerivedNumber("inertia", j, evidence_number(text), Q) for j, text in texts)
    return one, options, search.number_rows(one.table.chain(one.truth.table.convention), one.table, derived)


def test_search_finds_what_the_full_product_finds():
    _, options, rows = small()
    allowed = [tuple(range(len(o.choices))) for o in options]
    found = {way for box in search.fit_numbers(rows, options, allowed).sets for way in itertools.product(*box)}
    room = search.allowances(rows, options)
    expected = set()
    for way in itertools.product(*allowed):
        sums = sum(rows.coefficients[:, i] @ options[i].parameters[o] for i, o in enumerate(way))
        assert search.values(rows, options, way) == pytest.approx(sums)
        if (np.abs(sums - rows.value) <= room).all():
            expected.add(way)
    assert found == expected
    assert 0 < len(expected) < np.prod([len(a) for a in allowed])


def test_a_number_that_nothing_gives_is_named():
    _, options, rows = small([(1, "1234.5")])
    result = search.fit_numbers(rows, options, [tuple(range(len(o.choices))) for o in options])
    assert (result.sets, result.failed, result.matched, result.nearest > 100) == ((), (0,), 0, True)


def test_the_room_of_a_number_is_half_its_digit_and_four_deviations_of_the_table():
    """A misfit is half of the chi-square with the variance of a digit, that of a uniform error, and of the table."""
    _, options, rows = small([(2, "0.5")])
    (deviation,) = np.sqrt(((rows.coefficients * [o.deviation for o in options]) ** 2).sum(axis=(1, 2)))
    assert search.allowances(rows, options) == pytest.approx([0.05 + 4.0 * deviation], rel=1e-5)
    (value,) = search.values(rows, options, (0, 0, 0))
    assert search.misfit(rows, options, (0, 0, 0)) == pytest.approx(
        (value - 0.5) ** 2 / (0.05**2 / 3 + deviation**2) / 2
    )


def test_corners_are_the_quarter_turns_in_the_box_beyond_a_joint():
    """A slide's ends; a narrow range's middle; a whole turn counts once; without limits half a turn either way."""
    table = small()[0].table
    kinds = (JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.PRISMATIC)
    lower, upper = np.array([-3.0, 0.1, 0.2]), np.array([3.0, 0.7, 0.6])
    turn = np.pi / 2
    free = replace(table, lower=None, upper=None, kinds=(JointKind.REVOLUTE,) * 3)
    assert sorted({x for x in search.corners(free, 1)[:, 2].round(9)}) == pytest.approx([-turn, 0.0, turn, 2 * turn])
    assert search.corners(free, 2).tolist() == [[0.0, 0.0, 0.0]]
    boxed = replace(table, kinds=kinds, lower=lower, upper=upper)
    assert search.corners(boxed, 0) == pytest.approx(np.array([[0.0, 0.4, 0.2], [0.0, 0.4, 0.6]]))
    wide = search.corners(replace(boxed, lower=lower - 9.0, upper=upper + 9.0), -1)
    assert sorted({round(x, 9) for x in wide[:, 0] % (4 * turn)}) == pytest.approx([0.0, turn, 2 * turn, 3 * turn])
    with pytest.raises(MissingDataError, match="limits of joint_3"):
        search.corners(replace(boxed, lower=None), 0)


def test_options_are_distinct_and_the_identity_is_first():
    one = scrambled_table(np.random.default_rng(5))
    choice = TableChoice(one.truth.table.convention, "com")
    found = link_options(one.table, 0, choice, np.zeros(3))
    assert found.choices[0][0] == CHOICES[0]
    assert sum(len(c) for c in found.choices) == len(CHOICES) == 22
