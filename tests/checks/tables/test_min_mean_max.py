"""Statistics that contradict each other: what is found, in which words, and what is accepted."""

import pytest

from lwr_dyn.checks.tables.min_mean_max import min_mean_max, rank_correlation, rows_text, statistic_columns
from lwr_dyn.checks.tables.sheet import sheet_of_csv

HEAD = "case,mean,max,min\n"
RANGE = "numbers between -1.0 and 5.0"


def found(text):
    return list(min_mean_max(sheet_of_csv(text, "x.csv", "t")))


ONE_ROW = {
    "upside down": (
        HEAD + "a,1.0,5.0,-1.0\nb,2.0,1.0,3.0\n", "column-order", "t, row 2, max", [("mean", "min", "max")],
        "maximum 1.0 is below minimum 3.0; it fits in the order (mean, min, max)",
    ),
    "mean outside": (
        HEAD + "a,6.1,5.0,-1.0\nb,2.0,3.0,1.0\n", "mean-outside", "t, row 1, mean", [("max", "mean", "min")],
        f"mean 6.1 can be neither the signed mean nor the mean of absolute values of {RANGE}; "
        "it fits in the order (max, mean, min)",
    ),
    "signed among absolute": (
        HEAD + "a,-0.5,5.0,-1.0\nb,1.2,1.0,-1.5\nc,1.4,1.0,-1.5\n", "mean-outside", "t, row 1, mean",
        [], f"mean -0.5 cannot be the absolute mean of {RANGE}, which all other rows print",
    ),
    "rms": (
        "case,rms,max,min\na,9.0,5.0,-1.0\nb,2.0,3.0,1.0\n", "mean-outside", "t, row 1, max", [("max", "rms", "min")],
        f"rms 9.0 is impossible for {RANGE}; it fits in the order (max, rms, min)",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ONE_ROW)
def test_an_impossible_row(name):
    text, rule, place, orders, sentence = ONE_ROW[name]
    (finding,) = (x for x in found(text) if x.counts)
    assert (finding.rule, finding.severity, finding.confidence) == (rule, "error", "certain")
    assert (finding.place, finding.sentence) == (place, sentence)
    assert finding.suspected == (f"another order of the cells: {orders}" if orders else "a wrong cell in this row")
    row = place.split(", ")[1]
    assert [cell.rpartition(", ")[0] for cell in finding.cells] == [f"t, {row}"] * 3


def test_rows_in_another_order_are_one_finding():
    (finding,) = found(HEAD + "a,5.0,-1.0,2.0\nb,6.0,-2.0,3.0\nc,0.5,1.0,0.0\n")
    assert finding.sentence == (
        "rows 1 to 2: maximum below minimum in rows 1 to 2; headed (mean, max, min), their cells fit in the order "
        "(max, min, mean)"
    )
    assert finding.numbers == {"heading": ["mean", "max", "min"], "orders": [["max", "min", "mean"]], "rows": [1, 2]}
    assert (finding.rule, finding.place) == ("column-order", "t, rows 1 to 2")
    assert finding.printed == "mean 5.0, max -1.0, min 2.0; mean 6.0, max -2.0, min 3.0"


def test_means_of_absolute_values_are_a_note():
    (finding,) = found(HEAD + "a,0.5,1.0,-1.5\nb,1.2,1.0,-1.5\nc,1.4,1.0,-1.5\n")
    assert (finding.severity, finding.counts, finding.printed) == ("note", False, "mean 1.2, max 1.0, min -1.5")
    assert finding.sentence.startswith("rows 2 to 3 fit only as means of absolute values")


@pytest.mark.parametrize(
    ("row", "count"),
    [
        ("1.04,1.0,-1.0", 0), ("1.06,1.00,-1.00", 1), ("0.95,2.0,1.0", 0), ("0.94,2.0,1.0", 1), ("0.8,2.0,1.0", 1),
        ("1.0,0.9,1.0", 0), ("2.0,-1.0,-3.0", 0), ("4.0,-1.0,-3.0", 1), ("-4.0,-1.0,-3.0", 1), ("-,1.0,3.0", 0),
    ],
)  # fmt: skip
def test_rounding_is_allowed_and_no_more(row, count):
    assert len([x for x in found(f"{HEAD}a,{row}\n") if x.counts]) == count


def test_a_block_that_follows_another_when_moved_a_row():
    rows = [(1, 2), (4, 9), (2, 5), (8, 16), (5, 11), (3, 6), (9, 21)]
    text = "case,a max,a min,b max,b min\n"
    for i, (_, range_) in enumerate(rows):
        moved = rows[i - 1][0] if i else 7
        first = (0, moved) if 0 < i < 7 else (moved, 0)  # out of order: maximum below minimum
        text += f"c{i},{first[0]}.0,{first[1]}.0,{range_}.0,0.0\n"
    order, shifted = found(text)
    assert (order.rule, order.place) == ("column-order", "t, a, rows 2 to 7")
    assert (shifted.rule, shifted.severity, shifted.confidence) == ("rows-shifted", "warning", "possible")
    assert shifted.numbers["shift"] == -1
    assert shifted.numbers["moved"] == pytest.approx(1.0)
    assert shifted.sentence.startswith("rows 2 to 7: moved one row up, their ranges rank as those of t, b do")


def test_words_and_ranks():
    assert [rows_text(x) for x in ([2], [1, 2, 3], [0, 3])] == ["row 3", "rows 2 to 4", "rows 1, 4"]
    assert rank_correlation([1.0, 2.0, 3.0, 4.0], [2.0, 1.0, 3.0, 4.0]) == pytest.approx(0.8)
    sheet = sheet_of_csv("i,x max,x min,y max,y mean\n1,2,1,3,2\n", "x.csv", "t")
    assert [group.name for group in statistic_columns(sheet.tables[0])] == ["t, x"]  # y has no minimum
