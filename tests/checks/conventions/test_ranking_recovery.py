"""The readings of scrambled tables are recovered; the thousand run in `scripts/soak.py recovery`."""

import dataclasses

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


def test_shortest_number_in_a_range():
    assert shortest_between(0.23, 0.34) == 0.3
    assert shortest_between(-0.0207, -0.0205) == -0.0206


def test_cells_are_named_as_papers_do():
    assert CellChange("com", 4, 2, 0.0, 0.0).name == "c5z"
    assert CellChange("inertia", 1, 5, 0.0, 0.0).name == "I2yz"
    assert CellChange("mass", 2, 0, 0.0, 0.0).name == "m3"
