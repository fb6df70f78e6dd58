"""Tables, evidence and task files that are hostile: one error of ours, soon, whatever the numbers and names are."""

import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.checks.conventions.evidence import parse_evidence
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.checks.tables.formulas import equalities
from lwr_dyn.checks.tables.rules import lint
from lwr_dyn.checks.tables.sheet import TableError, sheet_of_csv
from lwr_dyn.checks.tables.toml_sheet import sheet_of_toml
from lwr_dyn.foundation.arrays import joint_array
from lwr_dyn.foundation.errors import LwrDynError, PaperError, ShapeError
from lwr_dyn.foundation.fields import parse_toml
from lwr_dyn.krl.writing.point_program import read_point_program

LONG = {"4301 digits": "9" * 4301, "hex of 4000 digits": "0x" + "f" * 4000, "of 65 bits": str(2**64)}
ROWS = "a,b\n1,2\n3,4\n5,6\n"


@pytest.mark.parametrize("number", LONG.values(), ids=LONG)
def test_an_integer_beyond_64_bits_is_refused_by_every_reader_of_toml(number, arm, tmp_path):
    readers = {
        lambda text: parse_toml(text, "x.toml"): PaperError, lambda text: parse_paper(text, "x.toml"): PaperError,
        lambda text: sheet_of_toml(text, "x.toml"): TableError,
        lambda text: parse_evidence(text, "x.toml", printed_table(open_paper("wam7"))): LwrDynError,
        lambda text: read_point_program(tmp_path / "x.toml", arm): PaperError,
    }  # fmt: skip
    for text in (f"schema = {number}\n", f"schema = 1\n[a]\nb = [[1, {number}]]\n"):
        (tmp_path / "x.toml").write_text(text)
        for read, error in readers.items():
            with pytest.raises(error, match=r"TOML: .*an integer too long"):
                read(text)


def test_the_largest_integers_are_read_and_one_too_large_for_a_float_is_no_array():
    assert parse_toml(f"a = {2**63 - 1}\nb = [-{2**63}]", "x")["a"] == 2**63 - 1
    with pytest.raises(ShapeError, match="not an array of numbers"):
        joint_array("q", [10**400, 0], 2)


@pytest.mark.parametrize("digits", ["9" * 60 + "a", "9 " * 50_000, "1e" * 200, "(" * 400, "1.1." * 200 + "a"])
def test_a_long_left_side_of_an_equation_costs_no_time(digits):
    """Ends at once, or, with a pattern that tries every split of the digits, never."""
    assert list(equalities(f"{digits} = 1")) == []
    assert [e.left for e in equalities("word " * 1000 + "350 + 820 = 1170")] == ["350 + 820"]


@pytest.mark.parametrize("title", ["1+x = 2", "1 + t.x = 2", "x(3) = 2", "1e308 * 10 = 2", "2^1e308 = 3", "1/0 = 1"])
def test_a_formula_with_a_name_or_without_a_value_is_passed_over(title):
    assert lint(sheet_of_csv(f"# title: {title}\n{ROWS}", "x.csv", "x")) == lint(sheet_of_csv(ROWS, "x.csv", "x"))


@pytest.mark.parametrize("unit", ["[[]]", "[{}]", "[1, 'm']", "{a = 1}", "3"])
def test_a_unit_that_is_no_text(unit):
    text = f"[t]\na = {{values = [1, 2, 3], unit = {unit}}}\n"
    assert sheet_of_toml(text, "x.toml").tables[0].columns[0].cells == ("1", "2", "3")


@pytest.mark.parametrize("number", ["1e308", "-1e308", "1e-320", "1.7976931348623157e308", "0.1e309"])
def test_extreme_values_are_linted(number):
    column = f"[{number}, 1.0, {number}, -{number.lstrip('-')}]"
    texts = [
        f"[t]\nmin = {column}\nmean = {column}\nmax = {column}\nKp = {column}\nKd = {column}\n",
        f"[t]\ninertia = [[{column[1:-1]}, 2, 3]]\n[t.lint]\nformula = ['min = 2 * max']\nratio = ['min / max']\n",
        f"[[r]]\nmass = {number}\n[[r]]\nmass = 2\n[[r]]\nmass = 4.0\n",
    ]
    for text in texts:
        lint(sheet_of_toml(text, "x.toml"))
    lint(sheet_of_csv(f"# total: a = {number}\n# ratio: a / b\na [kg],b [m]\n{number},1\n2,{number}\n", "x.csv", "x"))
