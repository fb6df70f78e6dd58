"""Columns that are proportional, and rows that repeat another column's: each finding in its words."""

import pytest

from lwr_dyn.checks.tables.proportions import column_pairs, constant_ratio, proportions, ratio, shifts
from lwr_dyn.checks.tables.sheet import TableError, sheet_of_csv
from lwr_dyn.model.printed_number import PrintedNumber

START = "i,a,b\n1,2.00,1.00\n2,3.00,1.50\n3,5.00,2.50\n"
FAULTS = {
    "power of ten": (
        START + "4,7.00,35.0\n", "power-of-ten", "likely", ("t, row 4, a", "t, row 4, b"),
        "7.00 times 1e1, or 35.0 times 1e-1",
        "t, row 4, a prints 7.00 and t, row 4, b prints 35.0: a / b is 2 in the other 3 rows, here off by 1e-1",
    ),
    "exchanged in one column": (
        START + "4,7.00,4.50\n5,9.00,3.50\n6,11.0,5.50\n", "swapped", "likely", ("t, row 4, a", "t, row 5, a"),
        "9.00, 7.00",
        "t, row 4, a prints 7.00 and t, row 5, a prints 9.00: exchanged, a / b is 2 in every row as it is in 4 of 6 "
        "as printed (so does exchanging t, row 4, b with t, row 5, b)",
    ),
    "exchanged in one row": (
        START + "4,3.50,7.00\n", "swapped", "certain", ("t, row 4, a", "t, row 4, b"), "7.00, 3.50",
        "t, row 4, a prints 3.50 and t, row 4, b prints 7.00: exchanged, a / b is 2 in every row as it is in 3 of 4 "
        "as printed",
    ),
    "declared": (
        "# ratio: a / b\n" + START + "4,7.00,3.90\n", "ratio", "certain", ("t, row 4, a", "t, row 4, b"), "a / b = 2",
        "a / b is 1.79487 here and 2 in 3 other rows",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_broken_ratio(name):
    text, rule, sure, cells, suspected, sentence = FAULTS[name]
    (finding,) = proportions(sheet_of_csv(text, "x.csv", "t"))
    assert (finding.rule, finding.severity, finding.confidence) == (rule, "error", sure)
    assert (finding.cells, finding.suspected, finding.sentence) == (cells, suspected, sentence)
    assert finding.numbers["ratio"] == pytest.approx(2.0)
    assert finding.numbers["of"] == "a / b"
    assert 4 in finding.numbers["broken"]


@pytest.mark.parametrize(
    "rows", ["4,7.00,3.90\n", "4,7.00,3.50\n", "4,7.00,9.00\n5,7.00,1.10\n6,8.00,1.70\n", "4,7.00,-\n", "4,0,35.0\n"]
)
def test_a_row_that_no_fault_explains_is_no_finding(rows):
    assert list(proportions(sheet_of_csv(START + rows, "x.csv", "t"))) == []


def test_two_constants_are_no_ratio_and_few_rows_neither():
    for text in ("i,a,b\n1,2.00,1.00\n2,2.00,1.00\n3,2.00,1.00\n4,7.00,35.0\n", START):
        pairs = [p for p in column_pairs(sheet_of_csv(text, "x.csv", "t")) if p.name == "a / b"]
        assert [constant_ratio(p) for p in pairs] == [None] * len(pairs)


def test_a_ratio_is_an_interval_and_none_where_it_is_open():
    two, coarse = PrintedNumber("2.00", 2.0, 0.005), PrintedNumber("0.1", 0.1, 0.05)
    assert ratio(two, PrintedNumber("-4.00", -4.0, 0.005)) == pytest.approx((-0.501875, -0.498125))
    assert ratio(two, coarse) is ratio(None, two) is ratio(two, None) is None
    assert ratio(PrintedNumber("0.00", 0.0, 0.005), two) is None


def test_a_declared_ratio_of_unknown_columns_is_refused():
    with pytest.raises(TableError, match=r"x.csv: t, ratio: 'a / c'; allowed: COLUMN / COLUMN of this file"):
        list(proportions(sheet_of_csv("# ratio: a / c\n" + START, "x.csv", "t")))


@pytest.mark.parametrize(
    ("x", "y", "shift", "first", "since", "sense", "agree"),
    [
        ("2 3 5 7", "9 2 3 5", 1, 1, "", "lower", 0),
        ("9 2 3 5", "2 3 5 7", -1, 1, "", "higher", 0),
        ("2 3 5 7 11", "2 9 3 5 7", 1, 2, " from row 2 on", "lower", 1),
    ],
)
def test_rows_that_are_shifted(x, y, shift, first, since, sense, agree):
    rows = "".join(f"r{k},{a},{b}\n" for k, (a, b) in enumerate(zip(x.split(), y.split(), strict=True)))
    (finding,) = shifts(sheet_of_csv("i,x,y\n" + rows, "x.csv", "t"))
    assert (finding.rule, finding.severity, finding.confidence) == ("rows-shifted", "error", "likely")
    assert (finding.printed, finding.suspected) == (x.replace(" ", ", "), y.replace(" ", ", "))
    assert (finding.numbers["shift"], finding.numbers["from_row"]) == (shift, first)
    assert finding.sentence == (
        f"t.x{since} repeats the sizes of t.y when each stands one row {sense}; as printed "
        f"{agree} of {len(x.split())} rows agree: one of the two is shifted"
    )


@pytest.mark.parametrize(("x", "y"), [("2 3 5 7", "2 3 5 7"), ("2 2 3 3", "9 2 2 3"), ("2 3 5 7", "9 2 3 6")])
def test_rows_that_are_not(x, y):
    rows = "".join(f"r{k},{a},{b}\n" for k, (a, b) in enumerate(zip(x.split(), y.split(), strict=True)))
    assert list(shifts(sheet_of_csv("i,x,y\n" + rows, "x.csv", "t"))) == []
    assert list(shifts(sheet_of_csv("i,x [m],y [mm]\n" + rows, "x.csv", "t"))) == []
