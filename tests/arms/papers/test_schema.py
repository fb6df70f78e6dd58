"""Every unit against its definition in SI; records of a paper convert at every depth; limits move by their zero."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.arms.papers import schema
from lwr_dyn.arms.papers.catalog import open_paper, template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.arms.papers.schema import PER_JOINT, RESULTS, TABLES, UNITS, Column, Erratum, Patch, to_si
from lwr_dyn.foundation.errors import PaperError

RULES = {f"{table}.{name}": rule for table, columns in TABLES.items() for name, rule in columns.items()}


@pytest.mark.parametrize("name", RULES)
def test_every_quantity_of_the_schema_has_a_unit_in_si(name):
    for quantity in RULES[name].quantities:
        assert 1.0 in [factor for known, factor in UNITS.values() if known == quantity]


def test_what_a_table_must_have_where_a_cell_may_be_unknown_and_shapes_of_rows():
    of_the_body = {"inertial.mass", "inertial.com", "inertial.inertia"}
    bounds = {f"limits.{name}" for name in ("lower", "upper", "velocity", "effort")}
    drives = {"rotors.gear_ratio", "rotors.inertia", "rotors.armature", "friction.viscous", "friction.coulomb"}
    assert {name for name, rule in RULES.items() if rule.may_be_unknown} == of_the_body | bounds | drives
    dh = {f"dh.{name}" for name in ("alpha", "a", "d")}
    frames, springs = {"origins.xyz", "origins.rpy"}, {"elasticity.stiffness", "elasticity.damping"}
    required = {name for name, rule in RULES.items() if rule.required}
    assert required == of_the_body | dh | frames | springs | {"gains.kp", "gains.kd"}
    # One a joint or one of the whole arm; a number, a vector, a tensor, or one number a joint.
    of_the_arm = {name for name, rule in RULES.items() if not rule.per_joint}
    vectors = {"base.gravity", "base.xyz", "base.rpy", "flange.xyz", "flange.rpy", "poses.mastering_wrist"}
    vectors |= {"poses.zero_flange", "poses.flange_rpy"}
    scalars = {"base.mass", "drawing.pedestal", *(name for name in RULES if name.startswith("ratings."))}
    assert of_the_arm == vectors | scalars
    vectors |= {"frames.origin", "origins.xyz", "origins.rpy", "origins.axis", "poses.axis"}
    vectors |= {"inertial.com", "inertial.rpy"}
    shapes = dict.fromkeys(vectors, (3,)) | {"inertial.inertia": (3, 3)}
    shapes |= dict.fromkeys(("transmission.signs", "transmission.matrix"), (PER_JOINT,))
    assert {name: rule.row for name, rule in RULES.items() if rule.row} == shapes


def test_units_are_what_they_are_and_columns_in_mixed_ones_and_nested_rows_become_si():
    mixed = Column("limits.lower", (90.0, 50.0), ("deg", "mm"), "p. 1", "printed")
    np.testing.assert_array_equal(mixed.si(), [np.pi / 2, 0.05])
    tensor = Column("inertial.inertia", (((1.0, 2.0), (3.0, 4.0)),), ("kg mm^2",), "p. 1", "printed")
    np.testing.assert_allclose(tensor.si(), [[[1e-6, 2e-6], [3e-6, 4e-6]]], rtol=1e-15)
    assert {unit: factor for unit, (_, factor) in UNITS.items() if factor != 1.0} == pytest.approx(DEFINED, rel=1e-15)
    assert to_si(2.5, "mm") == pytest.approx(2.5e-3, rel=1e-15)


def test_patches_of_an_erratum_are_of_tables_or_of_results():
    table, result = Patch("dh.a.values[0]", 1, 2), Patch(f"{RESULTS}table_v.x[0]", 3, 4)
    erratum = Erratum("id", "p. 1", "1", "2", "why", "effect", "proven", (table, result))
    assert (erratum.of_tables(), erratum.of_results()) == ((table,), (result,))
    assert erratum.tables() == {"dh"}
    changing = replace(erratum, severity="model")
    assert changing.changes_arm
    for other in ({"status": "likely"}, {"severity": "result"}, {"severity": ""}, {"patches": (result,)}):
        assert not replace(changing, **other).changes_arm


def test_errata_left_in_place_are_those_about_the_tables_of_the_reading():
    paper = open_paper("lwr4plus")
    patches = {name: (Patch(f"{name}.mass.values[0]", 1, 2),) for name in ("inertial", "dh")}
    own, of_dh, of_set = (
        Erratum(name, "p. 1", "1", "2", "w", "e", "proven", patches[table], "model", set_name)
        for name, table, set_name in (("own", "inertial", ""), ("of_dh", "dh", ""), ("of_set", "inertial", "given"))
    )
    published = schema.PublishedSet("given", "about", "p. 1", "dh", {"inertial": {}})
    plain = schema.Reading("plain", "about", ("of_dh",))
    on_set = schema.Reading("on_set", "about", (), "given")
    changed = replace(paper, errata=(own, of_dh, of_set), sets={"given": published}, reading=plain,
                      readings={"plain": plain, "on_set": on_set})  # fmt: skip
    assert [e.id for e in changed.errata_of("")] == ["own", "of_dh"]
    assert [e.id for e in changed.errata_of("given")] == ["of_dh", "of_set"]
    assert changed.left_in_place() == ("own",)
    assert changed.left_in_place("on_set") == ("of_dh", "of_set")


def test_numbers_of_a_paper_are_in_si_and_absent_columns_are_empty():
    paper = open_paper("lwr4plus")
    assert paper.numbers("inertial.mass") == tuple(paper.columns["inertial.mass"].si())
    assert paper.cell("inertial.mass", 2) == paper.numbers("inertial.mass")[2]
    assert (paper.numbers("no.column"), paper.cell("no.column")) == ((), None)
    assert paper.reading_names[0] == paper.default_reading
    assert sorted(paper.reading_names) == sorted(paper.readings)
    assert repr(paper) == f"Paper('lwr4plus', reading={paper.reading.name!r}, file={paper.file!r})"


DEFINED = {
    "deg": math.pi / 180, "mm": 1e-3, "g": 1e-3, "kg mm^2": 1e-3**2, "kg cm^2": 1e-2**2, "N mm": 1e-3,
    "deg/s": math.pi / 180, "rpm": 2 * math.pi / 60, "mm/s": 1e-3,
}  # fmt: skip
GOOD = template("own.toml", "own", "RR")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('unit = "kg",', 'unit = [["kg"], "kg"],'),
        ("# names =", 'names = [["A1"], "a"] #'),
        ("# names =", 'names = ["", "a"] #'),
        ("values = [2.0, 2.0]", f"values = [2.0, {10**400}]"),
        ("values = [2.0, 2.0]", "values = [2.0, 1e300]"),
        ('name = "own"', 'name = "a\\u0000b"'),
        ('title = "My arm"', "title = " + "[" * 5000),
    ],
)
def test_odd_values_are_one_error_too(old, new):
    assert old in GOOD
    with pytest.raises(PaperError):
        parse_paper(GOOD.replace(old, new, 1), "own.toml")


@pytest.mark.parametrize("at", ["", "DH", "inertial!!mass??values[0]", "inertial.mass.values[-1]"])
def test_a_patch_needs_a_whole_path(at):
    erratum = f"""
[[erratum]]
id = "x"
where = "w"
printed = "p"
read_as = "r"
why = "y"
effect = "e"
status = "open"
patch = [{{ at = "{at}", printed = 2.0, read = 3.0 }}]
[reading.printed]
about = "all"
errata = ["x"]
"""
    with pytest.raises(PaperError, match="no cell"):
        parse_paper(GOOD + erratum, "own.toml")
    twice = erratum.split("[reading")[0].replace(at or 'at = ""', "inertial.mass.values[0]" if at else 'at = "a.b"')
    with pytest.raises(PaperError, match="'x' twice"):
        parse_paper(GOOD + twice + erratum, "own.toml")


def test_a_table_of_runs_belongs_to_others_and_is_not_unknown():
    assert (
        parse_paper(GOOD + "\n[run]\nseconds = 1\n", "own.toml").default_reading
        == parse_paper(GOOD, "own.toml").default_reading
    )
