"""What links add to B_ii and g_i, against the recursion; and the search, against the full product."""

import itertools

import numpy as np
import pytest

from lwr_dyn.checks.conventions.evidence import DerivedNumber, evidence_number
from lwr_dyn.checks.conventions.hypotheses import other_ends
from lwr_dyn.checks.conventions.printed_table import CHOICES, TENSOR, TableChoice, link_options
from lwr_dyn.checks.conventions.search import allowances, contribution_rows, fit_numbers, number_rows
from lwr_dyn.dynamics.newton_euler import Recursion
from tests.checks.conventions.scrambled_tables import scrambled_table
from tests.random_arms import random_arm

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
            ours = np.einsum("pij,ij->p", contribution_rows(chain, quantity, i, q), parameters(chain))
            assert np.abs(ours - expected).max() <= ROUNDING * max(1.0, np.abs(expected).max())


def _small_table():
    """Three links, no rows shifted."""
    tables = (scrambled_table(np.random.default_rng([3, k])) for k in range(100))
    return next(t for t in tables if t.table.n == 3 and not t.truth.shift)


def test_search_finds_what_the_full_product_finds():
    one = _small_table()
    table, truth = one.table, one.truth
    recursion, q = Recursion.of(one.chain), np.array([0.3, -1.1, 0.8])
    diagonal = np.diag(recursion.mass_matrix(q))
    numbers = tuple(DerivedNumber("inertia", j, evidence_number(f"{diagonal[j]:.4g}"), q) for j in range(3))
    ends = other_ends(table, truth.table.convention)
    options = [link_options(table, i, truth.table, ends[i], CHOICES[:8]) for i in range(3)]
    rows = number_rows(table.chain(truth.table.convention), table, numbers)
    allowed = [tuple(range(len(o.choices))) for o in options]
    result = fit_numbers(rows, options, allowed)
    found = {way for box in result.sets for way in itertools.product(*box)}
    room = allowances(rows, options)
    expected = set()
    for way in itertools.product(*allowed):
        sums = sum(rows.coefficients[:, i] @ options[i].parameters[o] for i, o in enumerate(way))
        if (np.abs(sums - rows.value) <= room).all():
            expected.add(way)
    assert found == expected
    assert 0 < len(expected) < np.prod([len(a) for a in allowed])


def test_a_number_that_nothing_gives_is_named():
    one = _small_table()
    q = np.array([0.3, -1.1, 0.8])
    numbers = (DerivedNumber("inertia", 1, evidence_number("1234.5"), q),)
    ends = other_ends(one.table, one.truth.table.convention)
    options = [link_options(one.table, i, one.truth.table, ends[i]) for i in range(3)]
    rows = number_rows(one.chain, one.table, numbers)
    result = fit_numbers(rows, options, [tuple(range(len(o.choices))) for o in options])
    assert result.sets == ()
    assert result.failed == (0,)
    assert result.nearest > 100


def test_options_are_distinct_and_the_identity_is_first():
    one = scrambled_table(np.random.default_rng(5))
    choice = TableChoice(one.truth.table.convention, "com")
    found = link_options(one.table, 0, choice, np.zeros(3))
    assert found.choices[0][0] == CHOICES[0]
    assert sum(len(c) for c in found.choices) == len(CHOICES) == 22
