"""The readings of scrambled tables are recovered; the thousand run in `scripts/soak.py recovery`."""

import dataclasses
import math

import numpy as np
import pytest

from lwr_dyn.checks.conventions.cell_corrections import shortest_between
from lwr_dyn.checks.conventions.printed_table import CellChange
from lwr_dyn.checks.conventions.ranking import rank_readings
from lwr_dyn.foundation.errors import MissingDataError
from tests.checks.conventions.recovery import numbered_table, recovery
from tests.checks.conventions.scrambled_tables import same_bodies

TABLES = 20
SEED = 20
"""Another series than the soak's."""


@pytest.mark.slow
def test_scrambled_tables_are_recovered():
    found = recovery(TABLES, SEED)
    assert found.rate >= 0.99, found.statement()
    assert found.kept_or_recovered == 1.0, found.statement()
    assert found.missed == ()
    assert sum(found.undecidable.values()) > 0


def test_a_blank_com_that_no_row_fills_is_an_error():
    one = next(t for k in range(50) if (t := numbered_table(k, SEED)).table.origin is None)
    com = one.table.com.copy()
    com[1] = np.nan
    with pytest.raises(MissingDataError, match="centre of mass of link_2"):
        rank_readings(dataclasses.replace(one.table, com=com), one.evidence)


def test_the_truth_is_missed_when_its_evidence_is_another_arms():
    one = next(t for k in range(50) if (t := numbered_table(k, SEED)).kind == "both")
    numbers = tuple(
        dataclasses.replace(x, printed=dataclasses.replace(x.printed, value=1.05 * x.printed.value))
        for x in one.evidence.numbers
    )
    found = rank_readings(one.table, dataclasses.replace(one.evidence, numbers=numbers))
    assert not found.agree
    assert same_bodies(one.table, found.best.bodies, one.bodies)  # the second tensors still decide it


THIRD = 1.0 / 3.0


@pytest.mark.parametrize(
    ("low", "high", "shortest"),
    [(0.23, 0.34, 0.3), (-0.0207, -0.0205, -0.0206), (-0.02386, -0.02372, -0.0238), (0.4, 1.6, 1.0), (-3.2, -2.9, -3.0),
     (THIRD, THIRD, THIRD), (THIRD, math.nextafter(THIRD, 1.0), THIRD)],  # narrower than sixteen digits: its middle
)  # fmt: skip
def test_the_number_of_fewest_decimals_in_a_range(low, high, shortest):
    assert shortest_between(low, high) == pytest.approx(shortest, rel=1e-16)
    assert low <= shortest_between(low, high) <= high


def test_cells_are_named_as_papers_do():
    cells = (("com", 4, 2), ("inertia", 1, 5), ("mass", 2, 0))
    assert [CellChange(*cell, 0.0, 0.0).name for cell in cells] == ["c5z", "I2yz", "m3"]
