"""A document: each part stands once, and text, record and schema follow from it; a table's forms show the same."""

import json
import subprocess
import sys
from typing import Annotated, Literal, NotRequired, TypedDict

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from numpy.typing import NDArray

from lwr_dyn.foundation.document import CAVEATS_ARE, Document, Fact, Note, PageFigure, Section, type_of
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Marked, Table, aligned, json_text


class Cruise(TypedDict):
    speed: Annotated[float, "rad/s."]
    sign: Literal[-1, 1]
    note: NotRequired[str]


def made(there: bool = True) -> Document:
    columns = (
        Heading("joint", key="joint"),
        Heading("peak", "N m", ".2f", "peak", "Largest torque, N m."),
        Heading("", key="sigma"),
        Heading("on pages", key=None, page=True),
    )
    table = Table(
        "Peaks", columns, [("a", 1.25, 0.5, "x"), ("b", float("nan"), None, "y")], key="peaks", says="One a joint."
    )
    first = Section("", [
        Note("at rest"), Fact("share", 0.25, "Of the poses.", "share", "%", lambda x: f"{100 * x:g}"),
        Note("no limits", when=False, key="notes"),
        Note(["a", "b"], key="notes", says="Rests on.", before="note: "), table,
    ])  # fmt: skip
    more = Section("Load", [Fact("mass", 2.0, "kg.", "mass", "kg"), Fact("hidden", [1, 2])], "load", "The load.", there)
    page = Section("Only there", [Fact("area", 3, head="area"), PageFigure(lambda: "<b>drawn</b>")], page=True)
    return Document("Title", "Verdict", [first, more, page], "lwr-dyn made", facts=[Fact("robot", "r", "Its name.")])


def test_the_text_has_what_has_a_head_and_holds():
    assert made().text().splitlines() == [
        "Verdict", "at rest", "share: 25 %", "note: a", "note: b", "Peaks", "joint  peak [N m]", "-----  ----------",
        "a      1.25", "b", "", "mass: 2.0 kg",
    ]  # fmt: skip
    assert "mass" not in made(there=False).text()


def test_the_record_has_what_has_a_key_as_computed():
    record = made().record()
    assert [*record] == ["robot", "share", "notes", "peaks", "load", "area"]
    assert record["peaks"][0] == {"joint": "a", "peak": 1.25, "sigma": 0.5}
    assert record["notes"] == ["a", "b"]
    assert record["load"] == {"mass": 2.0, "hidden": [1, 2]}
    assert made(there=False).record()["load"] is None


def test_keys_of_one_document_alone_are_allowed_by_the_schema_and_not_named():
    one = Document("", "", [Section("", [Fact("a", 1)]), Section("", [Fact("mine", [])], says="Its own.", own=True)])
    schema = one.schema()
    assert one.record() == {"a": 1, "mine": []}
    assert (schema["required"], [*schema["properties"]]) == (["a"], ["a"])
    assert schema["additionalProperties"] == {"description": "Its own."}
    assert Draft202012Validator(schema).is_valid({"a": 1, "other": "x"})


@pytest.mark.parametrize("there", [True, False])
def test_the_schema_is_of_the_record_and_says_what_the_parts_say(there):
    schema = made().schema()
    Draft202012Validator.check_schema(schema)
    assert [*Draft202012Validator(schema).iter_errors(json.loads(json_text(made(there).record())))] == []
    assert schema["title"] == "lwr-dyn made --json"
    assert schema["properties"]["peaks"]["items"]["properties"]["peak"]["description"] == "Largest torque, N m."
    assert schema["properties"]["load"] | {"properties": 0} == {
        "description": "The load.", "type": ["object", "null"], "properties": 0, "required": ["mass", "hidden"],
        "additionalProperties": False,
    }  # fmt: skip


def test_a_section_without_a_key_that_is_missing_leaves_its_keys_out():
    documents = [
        Document("", "", [Section("", [Fact("a", 1)]), Section("", [Fact("b", 2)], there=x)]) for x in (True, False)
    ]
    assert [d.record() for d in documents] == [{"a": 1, "b": 2}, {"a": 1}]
    assert documents[0].schema() == documents[1].schema()
    assert documents[0].schema()["required"] == ["a"]


@pytest.mark.parametrize("value", [None, []])
def test_a_value_that_shows_no_type_needs_a_kind(value):
    with pytest.raises(TypeError, match=r"odd: .* does not show its type; give `kind`"):
        Document("", "", [Section("", [Fact("odd", value)])]).schema()
    found = Document("", "", [Section("", [Fact("odd", value, kind=list[str] | None)])]).schema()
    assert found["properties"]["odd"] == {"type": ["array", "null"], "items": {"type": "string"}}


def test_types_of_the_schema():
    assert type_of(Cruise) == {
        "type": "object",
        "properties": {
            "speed": {"description": "rad/s.", "type": ["number", "null"]}, "sign": {"enum": [-1, 1]},
            "note": {"type": "string"},
        },
        "required": ["speed", "sign"],
        "additionalProperties": False,
    }  # fmt: skip
    assert type_of(Literal["a"] | None) == {"enum": ["a", None]}
    assert type_of(int | str | None) == {"anyOf": [{"type": "integer"}, {"type": "string"}, {"type": "null"}]}
    assert type_of(NDArray[np.float64]) == {"type": "array", "items": {"type": ["number", "null"]}}
    found = Document("", "v", [Section("", [Fact("m", {"a": 1})])], caveats=["is printed"])
    assert (found.text(), found.record()) == ("is printed\nv", {"caveats": ["is printed"], "m": {"a": 1}})
    inside = {"type": "object", "properties": {"a": {"type": "integer"}}, "required": ["a"]}
    assert found.schema()["properties"] == {
        "caveats": {"description": CAVEATS_ARE, "type": "array", "items": {"type": "string"}},
        "m": inside | {"additionalProperties": False},
    }
    assert type_of(dict[str, bool]) == {"type": "object", "additionalProperties": {"type": "boolean"}}


def test_columns_may_be_the_lists_of_the_record():
    columns = (Heading("joint", key=None), Heading("peak", key="peak", kind=list[float] | None), Heading("", key="at"))
    known, unknown = (
        Document("", "", [Section("", [Table("", columns, [("a", x, 1.0), ("b", x, 2.0)], columnwise=True)])])
        for x in (0.5, None)
    )
    assert known.record() == {"peak": [0.5, 0.5], "at": [1.0, 2.0]}
    assert unknown.record() == {"peak": None, "at": [1.0, 2.0]}
    assert unknown.schema() == known.schema()


def test_marks_and_errors_stand_in_cells():
    columns = (Heading("x", key="x", format=".1f"), Heading("value", key="v", sigma="s"), Heading("", key="s"))
    table = Table("", columns, [(Marked(1.0, "best"), 2.0, 0.1)])
    assert table.cells[0][:2] == ("1.0 *", "2 +- 0.1")
    assert table.text().splitlines()[0].split() == ["x", "value"]


def test_no_numpy_is_loaded():
    code = "import sys, lwr_dyn.foundation.document; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


HEADINGS = (
    "joint",
    Heading("mass", "kg", ".2f", key="m", shade=lambda value: 0.0 if value is None else value / 10),
    Heading("holds", format=lambda value: "yes" if value else "NO"),
)
TABLE = Table("Links", HEADINGS, [("a", 2.5, True), ("long", None, False)], note="as printed")


def test_text_is_aligned_under_headings_with_units():
    assert TABLE.text().splitlines() == [
        "Links", "joint  mass [kg]  holds", "-----  ---------  -----", "a      2.50       yes",
        "long              NO", "as printed",
    ]  # fmt: skip
    assert Table("", ["a"], [("b",)]).text() == "a\n-\nb"
    assert str(TABLE) == TABLE.text()


def test_cells_shades_and_records_have_the_same_rows():
    assert TABLE.cells == (("a", "2.50", "yes"), ("long", "", "NO"))
    assert TABLE.shades == ((None, 0.25, None), (None, 0.0, None))
    rows = ("a", 2.5, True), ("long", None, False)
    assert TABLE.record() == [dict(zip(("joint", "m", "holds"), row, strict=True)) for row in rows]


def test_a_unit_without_a_heading_is_refused():
    with pytest.raises(OptionError, match=r"heading: unit \[kg\] alone"):
        Heading("", "kg")


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
