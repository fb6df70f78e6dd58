"""The strict reader: what breaks the schema is refused with file, field and what is allowed."""

import json

import pytest

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper, template
from lwr_dyn.arms.papers.reader import paper_of_tables, parse_paper
from lwr_dyn.arms.urdf.model_files import provenance_text
from lwr_dyn.foundation.errors import FileAccessError, PaperError, UnknownNameError
from lwr_dyn.foundation.fields import LARGEST, parse_toml

GOOD = template("own.toml", "own", "RP", "standard")

FAULTS = {
    "broken TOML": ("schema = 1", "schema = = 1", "TOML: .*; allowed: valid TOML"),
    "other schema": ("schema = 1", "schema = 2", "schema: 2; allowed: 1"),
    "unknown table": ("[flange]", "[flanges]", "flanges: unknown field; allowed: .*"),
    "unknown column": ("mass = {", "weight = {", r"inertial.mass: missing; allowed: a column"),
    "unknown column beside the others": ("[inertial]", "[inertial]\nweight = 1", "inertial.weight: unknown field"),
    "missing DH": ("alpha = {", "# alpha = {", "dh.alpha: missing"),
    "missing convention": ('convention = "standard"', "", "dh.convention: missing; allowed: one of standard, modified"),
    "unknown convention": ('"standard"\n', '"craig"\n', "dh.convention: 'craig'; allowed: one of standard, modified"),
    "missing page": (', where = "fill in", kind = "assumed" }\na =', ', kind = "assumed" }\na =',
                     "dh.alpha.where: missing"),
    "unknown kind": ('kind = "assumed" }\na =', 'kind = "guess" }\na =',
                     "dh.alpha.kind: 'guess'; allowed: one of printed"),
    "unit of the other kind of joint": ('unit = ["deg", "m"], w', 'unit = ["m", "m"], w',
                                        "'m' for joint_1; allowed: .* revolute"),
    "point of the tensor not said": ('about = "com", ', "", "inertia.about: missing; allowed: one of com, origin"),
    "axes not said": ('axes = "frame", ', "", "inertia.axes: missing; allowed: one of frame"),
    "sign of products not said": ('products = "tensor", ', "", "inertia.products: missing; allowed: one of tensor"),
    "sigma beyond all robots": ('unit = "kg", where', f'unit = "kg", sigma = [{2 * LARGEST}, 1], where',
                                "mass.sigma.*2e.30; allowed: a number below 1e.30"),
    "unknown joint kind": ('"prismatic"]', '"screw"]',
                           r"joints.kinds\[1\]: 'screw'; allowed: one of revolute, prismatic"),
    "no DH table": ("[dh]", "[frames]", "dh: missing; allowed: a table of DH columns"),
    "a sign a joint": ('products = "tensor"', 'products = ["tensor"]',
                       "inertial.inertia.products: 1 entries; allowed: one word, or 2, one per joint"),
    "no joints": ('kinds = ["revolute", "prismatic"]', "kinds = []", "joints.kinds: an empty list"),
    "same name twice": ('# names = ["A1", "A2"]  ', 'names = ["A1", "A1"]  #',
                        "joints.names: .*allowed: 2 different names"),
    "a name too few": ('# names = ["A1", "A2"]  ', 'names = ["A1"]  #', r"joints.names: \['A1'\]; allowed: 2 diff"),
    "a name of no letter": ('# names = ["A1", "A2"]  ', 'names = ["A1", "A\\u0007"]  #',
                            r"joints.names\[1\]: 'A\\x07'; allowed: text of printable characters"),
    "a blank name": ('# names = ["A1", "A2"]  ', 'names = [" ", "A2"]  #', r"joints.names\[0\]: ' '; allowed: text of"),
}  # fmt: skip
"""What is said of numbers and units of a column is in `test_columns.py`."""


@pytest.mark.parametrize("name", FAULTS)
def test_a_breach_is_refused_with_file_field_and_what_is_allowed(name):
    old, new, message = FAULTS[name]
    assert old in GOOD, "the fault does not touch the template any more"
    with pytest.raises(PaperError, match=f"^own.toml: .*{message}"):
        parse_paper(GOOD.replace(old, new, 1), "own.toml")


ERRATUM = """
[[erratum]]
id = "mass-2"
where = "Table 1"
printed = "2.0"
read_as = "3.0"
why = "sum"
effect = "none"
status = "proven"
patch = [{ at = "inertial.mass.values[1]", printed = 2.0, read = 3.0 }]
[reading.printed]
about = "as printed"
[reading.corrected]
about = "put right"
errata = ["mass-2"]
"""


def test_an_erratum_changes_only_its_reading_and_is_recorded():
    assert parse_paper(GOOD + ERRATUM, "own.toml").columns["inertial.mass"].values == (2.0, 2.0)
    mended = parse_paper(GOOD + ERRATUM, "own.toml", "corrected").columns["inertial.mass"]
    assert mended.values == (2.0, 3.0)
    assert mended.errata == {1: ("mass-2",)}
    tables = parse_toml(GOOD + ERRATUM, "own.toml")
    for reading, read, masses in (("corrected", (), (2.0, 2.0)), ("printed", ("mass-2", "other"), (2.0, 3.0))):
        paper = paper_of_tables(tables, "own.toml", reading, errata_read=read)
        assert paper.columns["inertial.mass"].values == masses


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("printed = 2.0, read", "printed = 2.1, read", "inertial.mass.values.1.: printed 2.0; allowed: 2.1 as stated"),
        ("mass.values[1]", "mass.values[7]", "no cell 'inertial.mass.values.7.'"),
        ("inertial.mass", "inertial.weight", "no cell"),
        ('errata = ["mass-2"]', 'errata = ["mass-3"]', "reading.corrected.errata: 'mass-3'; allowed: one of mass-2"),
        ('status = "proven"', 'status = "sure"', r"erratum\[0\].status: 'sure'; allowed: one of proven, likely, open"),
        ('effect = "none"\n', "", r"erratum\[0\].effect: missing"),
    ],
)
def test_an_erratum_must_find_its_printed_value(old, new, message):
    with pytest.raises(PaperError, match=message):
        parse_paper(GOOD + ERRATUM.replace(old, new, 1), "own.toml", "corrected")


SECOND = ERRATUM.partition("[reading.printed]")[0].replace("mass-2", "all-masses")


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize(
    ("cell", "read", "clash"),
    [("mass.values", "[2.0, 3.0]", True), ("mass.values[1]", "3.0", True), ("mass.values[0]", "3.0", False)],
)
def test_two_errata_of_a_reading_change_no_cell_twice_nor_one_inside_the_other(cell, read, clash, first):
    printed = "[2.0, 2.0]" if cell == "mass.values" else "2.0"
    patch = f'inertial.{cell}", printed = {printed}, read = {read}'
    second = SECOND.replace('inertial.mass.values[1]", printed = 2.0, read = 3.0', patch)
    both = ERRATUM.replace('errata = ["mass-2"]', 'errata = ["mass-2", "all-masses"]')
    text = GOOD + (second + both if first else both.replace("[reading.printed]", second + "[reading.printed]"))
    if not clash:
        assert parse_paper(text, "own.toml", "corrected").columns["inertial.mass"].values == (3.0, 3.0)
        return
    with pytest.raises(
        PaperError, match=r"errata \S+ and \S+: both read inertial.mass.values.*; allowed: one erratum of"
    ):
        parse_paper(text, "own.toml", "corrected")


def test_unknown_names_and_files_are_refused_with_what_is_known(tmp_path):
    for arguments, words in (
        (("lwr4pluss",), r"did you mean lwr4plus\?.*known: iiwa14, kr30ha, lwr4, lwr4plus, panda"),
        (("lwr4plus", "real"), "no reading of lwr4plus named 'real'; known: printed, computed, physical"),
    ):
        with pytest.raises(UnknownNameError, match=words):
            open_paper(*arguments)
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "latin.toml").write_bytes(b"\xff\xfe")
    for name, words in (("none", "no such file"), ("folder", "directory"), ("latin", "not UTF-8")):
        with pytest.raises(FileAccessError, match=words):
            open_paper(str(tmp_path / f"{name}.toml"))


def test_standard_errors_of_a_column_are_read_and_stand_in_the_sources():
    text = GOOD.replace('unit = "kg", where', 'unit = "kg", sigma = [0.25, "unknown"], where')
    paper = parse_paper(text, "own.toml")
    first, second = paper.columns["inertial.mass"].sigma
    assert first == 0.25
    assert second != second
    assert paper.columns["inertial.com"].sigma == ()
    sources = arm_from_paper(paper).sources
    assert [sources[f"link_{i}.mass"][0].sigma for i in (1, 2)] == [0.25, "unknown"]
    assert sources["link_1.com"][0].sigma is None
    sidecar = json.loads(provenance_text(arm_from_paper(paper)))
    assert sidecar["quantities"]["link_1.mass"][0]["sigma"] == 0.25
    assert "sigma" not in sidecar["quantities"]["link_1.com"][0]
