"""Scrambled tables find their way back; the thousand run in `scripts/soak.py recovery`."""

import dataclasses

import numpy as np
import pytest

from lwr_dyn.conventions.choices import CellChange
from lwr_dyn.conventions.recovery import numbered_trial, recovery
from lwr_dyn.conventions.repair import shortest_between
from lwr_dyn.conventions.resolve import resolve
from lwr_dyn.conventions.trials import same_bodies
from lwr_dyn.errors import MissingDataError

TABLES = 40
SEED = 20
"""Another series than the soak's."""


def test_scrambled_tables_are_recovered():
    found = recovery(TABLES, SEED)
    assert found.rate >= 0.99, found.statement()
    assert found.honest == 1.0, found.statement()
    assert found.missed == ()
    assert sum(found.undecidable.values()) > 0


def suitable(one):
    return one.kind == "numbers" and one.table.n == 4 and not one.truth.shift and abs(one.table.com[2, 2]) > 0.02


def test_a_wrong_cell_is_found_and_mended():
    """A com printed with 40 % of its value: the cell and its value come back from B_ii and g_i alone."""
    trials = [one for k in range(200) if suitable(one := numbered_trial(k, SEED))][:3]
    assert len(trials) == 3
    for one in trials:
        right = float(one.table.com[2, 2])
        found = resolve(one.table.with_cell("com", 2, 2, 0.4 * right), one.evidence)
        mended = [r for r in found.repairs if r.cell.name == "c3z" and r.low <= right <= r.high]
        assert mended, [(r.cell.name, r.low, r.high) for r in found.repairs]


def test_a_blank_com_that_no_row_fills_is_an_error():
    one = next(t for k in range(50) if (t := numbered_trial(k, SEED)).table.origin is None)
    com = one.table.com.copy()
    com[1] = np.nan
    with pytest.raises(MissingDataError, match="centre of mass of link_2"):
        resolve(dataclasses.replace(one.table, com=com), one.evidence)


def test_the_truth_is_missed_when_its_evidence_is_another_arms():
    one = next(t for k in range(50) if (t := numbered_trial(k, SEED)).kind == "both")
    numbers = tuple(
        dataclasses.replace(x, printed=dataclasses.replace(x.printed, value=1.05 * x.printed.value))
        for x in one.evidence.numbers
    )
    found = resolve(one.table, dataclasses.replace(one.evidence, numbers=numbers))
    assert not found.agree
    assert same_bodies(one.table, found.best.bodies, one.bodies)  # the second tensors still tell


def test_shortest_number_in_a_range():
    assert shortest_between(0.23, 0.34) == 0.3
    assert shortest_between(-0.0207, -0.0205) == -0.0206


def test_cells_are_named_as_papers_do():
    assert CellChange("com", 4, 2, 0.0, 0.0).name == "c5z"
    assert CellChange("inertia", 1, 5, 0.0, 0.0).name == "I2yz"
    assert CellChange("mass", 2, 0, 0.0, 0.0).name == "m3"
