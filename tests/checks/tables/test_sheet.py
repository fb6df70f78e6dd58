"""A table of a sheet: its rows, and its cells in words."""

from lwr_dyn.checks.tables.sheet import SheetColumn, SheetTable


def test_rows_are_those_of_the_columns_and_none_without_columns():
    table = SheetTable("t", (SheetColumn("a", ("1", "2", "3"), "m"),))
    assert (table.rows, SheetTable("empty", ()).rows) == (3, 0)
    assert table.place(2, "a") == "t, row 3, a"
