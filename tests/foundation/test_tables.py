"""A table's three forms show the same values; a row of another length is refused."""

import json

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table, aligned, json_text

HEADINGS = (
    "joint",
    Heading("mass", "kg", ".2f", key="m", shade=lambda value: 0.0 if value is None else value / 10),
    Heading("holds", format=lambda value: "yes" if value else "NO"),
)
TABLE = Table("Links", HEADINGS, [("a", 2.5, True), ("long", None, False)], note="as printed")


def test_text_is_aligned_under_headings_with_units():
    assert TABLE.text().splitlines() == [
        "Links",
        "joint  mass [kg]  holds",
        "-----  ---------  -----",
        "a      2.50       yes",
        "long              NO",
        "as printed",
    ]
    assert Table("", ["a"], [("b",)]).text() == "a\n-\nb"
    assert str(TABLE) == TABLE.text()


def test_cells_shades_and_records_have_the_same_rows():
    assert TABLE.cells == (("a", "2.50", "yes"), ("long", "", "NO"))
    assert TABLE.shades == ((None, 0.25, None), (None, 0.0, None))
    assert TABLE.record() == [
        {"joint": "a", "m": 2.5, "holds": True},
        {"joint": "long", "m": None, "holds": False},
    ]


@pytest.mark.parametrize("row", [("a",), ("a", 1.0, True, "more")])
def test_a_row_of_another_length_is_refused(row):
    with pytest.raises(OptionError) as fault:
        Table("Links", HEADINGS, [TABLE.rows[0], row])
    assert str(fault.value) == f"table 'Links', row 2: {len(row)} values; allowed: 3, one per column"


def test_widths_are_those_of_the_longest_cell_and_lines_have_no_spaces_at_the_end():
    lines = aligned([("1", "x"), ("1000", "")], ("n", "word")).splitlines()
    assert lines == ["n     word", "----  ----", "1     x", "1000"]
    assert aligned([], ("n",)) == "n\n-"


def test_json_has_lists_for_arrays_and_null_for_what_is_not_finite():
    record = {1: np.arange(2), "x": (np.float64(0.1), float("nan"), [-np.inf]), "b": np.bool_(True), "t": None}
    assert json.loads(json_text(record)) == {"1": [0, 1], "x": [0.1, None, [None]], "b": True, "t": None}
