"""Numbers and names of a data file are read back as they were."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.arms.export.data_file import ColumnText, literal, quoted, table_text


@pytest.mark.slow
@pytest.mark.hypothesis
@given(st.text(st.characters(codec="utf-8")))
def test_a_text_comes_back(text):
    assert tomllib.loads(f"x = {quoted(text)}") == {"x": text}


@pytest.mark.hypothesis
@given(st.lists(st.floats(allow_nan=False, allow_infinity=False)))
def test_numbers_come_back(values):
    assert tomllib.loads(f"x = {literal(values)}") == {"x": values}


def test_a_table_without_columns_is_left_out():
    assert table_text("limits", []) == []
    column = ColumnText("lower", [1.0, None], ["rad", "m"], "a page")
    text = "\n".join(table_text("limits", [column]))
    assert tomllib.loads(text)["limits"]["lower"]["values"] == [1.0, "unknown"]
