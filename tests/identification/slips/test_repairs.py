"""Slips undone."""

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.identification.slips.printed_cells import printed_cells
from lwr_dyn.identification.slips.repairs import exchanges, of_cells, of_columns


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
