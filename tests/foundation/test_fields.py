"""Fields of a table: each refusal names the file, the place and what is allowed."""

import math

import pytest

from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.foundation.fields import LARGEST, Fields, is_number, parse_toml

TABLE = {
    "name": "arm", "kind": "fitted", "closed": True, "mass": 2, "count": 3, "com": [1, 2, 3.5], "values": [1, 2],
    "words": ["a", "b"], "inner": {"deep": 1}, "rows": [{"x": 1}, {"x": 2}],
}  # fmt: skip

READS = {
    "text": (lambda f: f.text("name"), "arm"),
    "choice": (lambda f: f.choice("kind", ("fitted", "printed")), "fitted"),
    "default of a choice": (lambda f: f.choice("other", ("a", "b"), "none"), "none"),
    "truth": (lambda f: f.truth("closed"), True),
    "number": (lambda f: f.number("mass", above=0.0), 2.0),
    "numbers at their bounds": (
        lambda f: [f.number("mass", least=2, most=2), f.number_at("x", -LARGEST)],
        [2, -LARGEST],
    ),
    "a row at its bound": (lambda f: f.row("com", 3, most=3.5), (1.0, 2.0, 3.5)),
    "default of a number": (lambda f: f.number("other", None, least=5), None),
    "row": (lambda f: f.row("com", 3), (1.0, 2.0, 3.5)),
    "default of a row": (lambda f: f.row("other", 3, default=None), None),
    "numbers": (lambda f: f.numbers("values"), (1.0, 2.0)),
    "default of numbers": (lambda f: f.numbers("other", ()), ()),
    "texts": (lambda f: f.texts("words"), ("a", "b")),
    "table": (lambda f: f.table("inner").number("deep"), 1.0),
    "tables": (lambda f: [row.number("x") for row in f.tables("rows")], [1.0, 2.0]),
    "free keys": (lambda f: f.table("inner").unread(), ("deep",)),
}

REFUSALS = {
    "missing": (lambda f: f.text("title"), "task.title: missing; allowed: text"),
    "missing number": (lambda f: f.number("title"), "task.title: missing; allowed: a value"),
    "no text": (lambda f: f.text("mass"), "task.mass: 2; allowed: text"),
    "truth as integer": (lambda f: f.take("closed", int), "task.closed: True; allowed: an integer"),
    "other word": (lambda f: f.choice("kind", ("a", "b")), "task.kind: 'fitted'; allowed: one of a, b"),
    "missing word": (lambda f: f.choice_at("x", None, ("a",)), "task.x: missing; allowed: one of a"),
    "no truth": (lambda f: f.truth("mass"), "task.mass: 2; allowed: true or false"),
    "truth as number": (lambda f: f.number("closed"), "task.closed: True; allowed: a number"),
    "not above": (lambda f: f.number("mass", above=2.0), "task.mass: 2; allowed: a number above 2"),
    "outside": (lambda f: f.number("mass", least=3, most=4), "task.mass: 2; allowed: a number from 3 to 4"),
    "own words": (lambda f: f.number("mass", least=3, allowed="a lot"), "task.mass: 2; allowed: a lot"),
    "not finite": (lambda f: f.number_at("x[1]", math.nan), "task.x[1]: nan; allowed: a number"),
    "too large": (lambda f: f.number_at("x", 2 * LARGEST), "task.x: 2e+30; allowed: a number"),
    "short row": (lambda f: f.row("values", 3), "task.values: [1, 2]; allowed: a list of 3 finite numbers"),
    "row of words": (lambda f: f.row("words", 2, "two"), "task.words: ['a', 'b']; allowed: two"),
    "large row": (lambda f: f.row("com", 3, most=3.0), "task.com: [1, 2, 3.5]; allowed: a list of 3 finite numbers"),
    "no row": (lambda f: f.row_at("x", None, 3), "task.x: None; allowed: a list of 3 finite numbers"),
    "twice": (lambda f: Fields({"x": [1, 2, 1]}, "a.toml", "task").numbers("x"), "task.x[2]: 1.0 twice; allowed: each"),
    "empty": (lambda f: Fields({"x": []}, "a.toml", "task").texts("x"), "task.x: an empty list; allowed: one text"),
    "no number": (lambda f: f.numbers("words"), "task.words[0]: 'a'; allowed: a number"),
    "no texts": (lambda f: f.texts("values"), "task.values[0]: 1; allowed: a text"),
    "no table": (lambda f: f.table("mass"), "task.mass: 2; allowed: a table"),
    "row that is no table": (lambda f: f.tables("values"), "task.values[0]: 1; allowed: a table"),
    "inner place": (lambda f: f.table("inner").text("deep"), "task.inner.deep: 1; allowed: text"),
    "place in a list": (lambda f: f.tables("rows")[1].text("x"), "task.rows[1].x: 2; allowed: text"),
}


@pytest.mark.parametrize("name", READS)
def test_a_field_is_read_or_has_its_default(name):
    read, expected = READS[name]
    assert read(Fields(TABLE, "a.toml", "task")) == expected


@pytest.mark.parametrize("name", REFUSALS)
def test_a_refusal_names_file_place_and_what_is_allowed(name):
    read, message = REFUSALS[name]
    with pytest.raises(PaperError) as caught:
        read(Fields(TABLE, "a.toml", "task"))
    assert str(caught.value).startswith(f"a.toml: {message}")
    assert caught.value.file == "a.toml"


def test_a_field_that_was_not_read_is_unknown():
    fields = Fields({"name": "x", "nane": "y"}, "a.toml")
    assert fields.text("name") == "x"
    with pytest.raises(PaperError, match=r"a.toml: nane: unknown field \(did you mean name\?\); allowed: name"):
        fields.refuse_unknown()
    assert fields.text("nane") == "y"
    fields.refuse_unknown()


def test_a_table_itself_is_named_by_its_place():
    fault = Fields({}, "a.toml", "task[1]").refuse("", "empty", "a field")
    assert str(fault) == "a.toml: task[1]: empty; allowed: a field"
    with pytest.raises(PaperError, match=r"a.toml: task: 3; allowed: a table"):
        Fields(3, "a.toml", "task")


def test_truth_values_texts_and_infinity_are_no_numbers():
    assert [is_number(x) for x in (1, 2.5, True, "1", math.inf, math.nan)] == [True, True, False, False, False, False]


@pytest.mark.parametrize("text", ["x = = 1", f"x = {2**63}", f"x = [{{y = -{2**63 + 1}}}]"])
def test_broken_toml_is_refused(text):
    with pytest.raises(PaperError, match=r"a.toml: TOML: .*; allowed: valid TOML 1.0, with integers of 64 bits"):
        parse_toml(text, "a.toml")
    assert parse_toml("x = 1.5", "a.toml", parse_float=str) == {"x": "1.5"}
    assert parse_toml(f"x = [{2**63 - 1}, {-(2**63)}]", "a.toml") == {"x": [2**63 - 1, -(2**63)]}
