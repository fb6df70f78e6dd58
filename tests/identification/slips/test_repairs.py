"""Slips undone."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.identification.slips.printed_cells import MASS, Cell, printed_cells
from lwr_dyn.identification.slips.repairs import exchanges, of_cells, of_columns, repeats


@pytest.mark.parametrize("reading", ["printed", "physical"])
def test_a_repair_done_again_on_what_it_made_is_said_and_changes_something(reading):
    table = printed_cells(open_paper("lwr4plus", reading))
    for repair in exchanges(table):
        again = repair.again(repair.table)
        if "exchanged" in repair.text:
            np.testing.assert_array_equal(again.table.values, table.values)
        assert repair.cells
    for repair in of_cells(table):
        assert (repair.table.parameters() != table.parameters()).any()
    for repair in (*of_cells(table), *of_columns(table)):
        again = repair.again(table)
        assert again.text == repair.text
        np.testing.assert_array_equal(again.table.parameters(), repair.table.parameters())


def test_a_number_repeats_that_of_the_row_before_or_behind_it():
    table = printed_cells(open_paper("lwr4plus", "physical"))
    values = table.values.copy()
    values[:, MASS] = [3.0, 2.0, -2.0, 1.0, 0.0, 0.0, 1.0]
    table = replace(table, values=values, known=np.ones_like(table.known))
    found = [repeats(table, Cell(i, MASS)) for i in range(7)]
    assert found == [None, Cell(2, MASS), Cell(1, MASS), None, None, None, None]
