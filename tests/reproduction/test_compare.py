"""Verdicts are computed: to the digits, after the fewest errata, by how much otherwise; changed data turns them."""

import copy
import tomllib

import pytest

from lwr_dyn.foundation.errors import OptionError, PaperError
from lwr_dyn.reproduction.case import COMPUTED, REPEATED, STRUCTURAL, ComparedExpression
from lwr_dyn.reproduction.compare import (
    AFTER,
    ASSUMED,
    DIFFERS,
    REPRODUCED,
    ComparedNumber,
    agree,
    compare_numbers,
    compared,
    same,
    value_of,
)
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import PrintedCell, ResultBlock, read_results, results_of_tables, studies
from tests.reproduction.mutants import by_cell, usual_judgement


@pytest.fixture(scope="module")
def found():
    return {paper: usual_judgement(paper) for paper in studies()}


def changed_numbers(paper, **data):
    return compare_numbers(paper_study(paper).with_data(**data), from_known_maxima=True)


def of(judgement, path):
    return next(j for j in judgement.numbers if j.cell.path == path)


@pytest.mark.slow
def test_nothing_printed_is_left_unexplained_and_nothing_derived_differs(found):
    for judgement in found.values():
        assert judgement.counts()[DIFFERS] == 0
        derived = judgement.counts(derived=True)
        assert derived[REPRODUCED] == sum(derived.values()) > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("paper", "cell", "verdict", "errata"),
    [
        ("lwr4plus", "figure_1.mass[0]", REPRODUCED, ()),
        ("lwr4plus", "table_iv.b[6]", AFTER, ("table2-rows",)),
        ("lwr4plus", "table_iv.b[0]", AFTER, ("table2-rows", "table2-c5z")),
        ("lwr4plus", "table_iv.b[1]", AFTER, ("table2-rows", "table1-swapped-yz", "table2-c5z")),
        ("lwr4plus", "table_vi.Kd[5]", AFTER, ("table6-exchanged",)),
        ("lwr4plus", "table_vi.Kd[4]", REPRODUCED, ()),
        ("lwr4plus", "rotor_inertia.I_m[0]", AFTER, ("rotor-inertia-power",)),
        ("lwr4", "matrices.A3[2][3]", REPRODUCED, ()),
        ("wam7", "equations_3_4.dq_c[0]", REPRODUCED, ()),
        ("wam7", "figure_4.position[0]", AFTER, ("figure4-acceleration",)),
        ("wam7", "figure_7.joint_1[1]", ASSUMED, ()),
        ("wam7", "figure_4.velocity[1]", AFTER, ("figure4-acceleration",)),
        ("kr30ha", "point_1.D[0]", REPRODUCED, ()),
        ("kr30ha", "symbolic.A1[0][2]", AFTER, ("symbolic-signs",)),
        ("kr30ha", "composite.T06[0][3]", REPRODUCED, ()),
        ("kr30ha", "appendix_a.volume[0]", AFTER, ("table2-offset", "kuka-signs")),
    ],
)
def test_the_verdict_of_a_cell_and_the_fewest_errata_that_it_takes(found, paper, cell, verdict, errata):
    one = of(found[paper], f"results.{cell}")
    assert (one.verdict, one.errata) == (verdict, errata)


@pytest.mark.slow
def test_what_is_not_printed_is_named_and_the_distance_under_assumptions_given(found):
    one = of(found["wam7"], "results.figure_7.joint_1[1]")
    assert one.missing == ("gains.kp", "gains.kd")
    assert one.miss == 0.0  # with the manufacturer's gains it stays within the axis


@pytest.mark.slow
def test_a_changed_cell_turns_what_depends_on_it_and_nothing_else(found):
    tables = copy.deepcopy(dict(paper_study("lwr4plus").data.tables))
    tables["inertial"]["mass"]["values"][6] *= 1.01
    changed, same = by_cell(changed_numbers("lwr4plus", tables=tables)), by_cell(found["lwr4plus"])
    turned = {path for path in same if changed[path] != same[path]}
    assert {"results.figure_1.mass[0]", "results.torques.g[1]"} <= turned
    assert not any(path.startswith(("results.table_ii.", "results.table_vi.", "results.limits.")) for path in turned)
    tables = dict(paper_study("lwr4plus").data.tables)
    assert by_cell(changed_numbers("lwr4plus", tables=tables)) == same


def test_no_verdict_is_written_in_the_data():
    for paper in studies():
        for block in paper_study(paper).data.results.blocks.values():
            assert block.compute in paper_study(paper).formulas
            assert paper_study(paper).formulas[block.compute].formula


def number(printed="2.5", value=2.53, verdict=ASSUMED, span=None, step="", row=("1.0", "3.0"), **more):
    """One of a row whose printed numbers go from 1 to 3."""
    cell = PrintedCell("results.b.c[0]", "r", "c", printed, "kg", span, step)
    others = tuple(PrintedCell(f"results.b.d[{k}]", "r", "d", text, "kg") for k, text in enumerate(row))
    away = (
        PrintedCell("results.b.d[9]", "other row", "d", "99", "kg"),
        PrintedCell("results.b.d[8]", "r", "d", "99", "m"),
    )
    block = ResultBlock("b", "Table 1", "table", "f", (cell, *others, *away), {}, range_of=("d",))
    return ComparedNumber(block, cell, verdict, value=value, **more)


@pytest.mark.parametrize(
    ("given", "miss", "digits", "near"),
    [
        ({"value": 2.53}, 0.03, 0.3, True), ({"value": 2.8}, 0.3, 3.0, True), ({"value": 2.81}, 0.31, 3.1, False),
        ({"value": 2.2}, -0.3, -3.0, True), ({"value": 2.19}, -0.31, -3.1, False), ({"row": ()}, 0.03, 0.3, True),
        ({"value": 2.6, "row": ()}, 0.1, 1.0, False), ({"value": None}, None, None, False),
        ({"value": ComparedExpression("q", True)}, None, None, True), ({"verdict": DIFFERS}, 0.03, 0.3, None),
        ({"span": ("2.4", "2.6")}, 0.0, 0.0, True), ({"value": 3.0, "span": ("2.4", "2.6")}, 0.4, 4.0, False),
        ({"value": 2.0, "span": ("2.4", "2.6")}, -0.4, -4.0, False),
    ],
)  # fmt: skip
def test_how_far_a_number_is_off_and_whether_that_is_near(given, miss, digits, near):
    """Near is within the digits, the range of a figure, or 15 % of the range of its row: 0.3 of 1 to 3."""
    one = number(**given)
    assert (one.miss, one.digits) == (miss if miss is None else pytest.approx(miss), digits and pytest.approx(digits))
    assert one.near is near


def test_a_number_agrees_to_its_digits_or_within_its_range():
    cell = number().cell
    assert [agree(cell, "2.5", x) for x in (2.45, 2.549, 2.551, float("nan"), float("inf"), None)] == [
        True, True, False, False, False, False,
    ]  # fmt: skip
    spanned = number(span=("2.4", "2.6")).cell
    assert [agree(spanned, "2.5", x) for x in (2.4, 2.6, 2.39, 2.61)] == [True, True, False, False]
    assert [agree(cell, "q", ComparedExpression("q", x)) for x in (True, False)] == [True, False]
    stepped = number("0", step="0.01").cell
    assert [agree(stepped, "0", x) for x in (0.004, 0.006)] == [True, False]


@pytest.mark.parametrize(
    ("verdict", "basis", "outcome"),
    [
        (REPRODUCED, REPEATED, REPEATED), (AFTER, STRUCTURAL, STRUCTURAL), (REPRODUCED, COMPUTED, REPRODUCED),
        (DIFFERS, REPEATED, DIFFERS), (AFTER, "", AFTER),
    ],
)  # fmt: skip
def test_what_agrees_and_is_not_computed_is_counted_by_its_basis(verdict, basis, outcome):
    one = number(verdict=verdict, basis=basis, errata=("e",), missing=("gains.kp",))
    assert one.outcome == outcome
    assert one.to_json() == {
        "cell": "results.b.c[0]", "where": "Table 1", "row": "r", "column": "c", "printed": "2.5", "unit": "kg",
        "derived": False, "value": 2.53, "verdict": verdict, "basis": basis or None, "outcome": outcome, "near": None,
        "errata": ["e"], "miss": pytest.approx(0.03), "last_digits": pytest.approx(0.3), "missing": ["gains.kp"],
        "computed_by": "f",
    }  # fmt: skip
    assert number(value=ComparedExpression("q1", True)).to_json()["value"] == "q1"


@pytest.mark.parametrize("text", ["__import__('os')", "x.y", "cos(a, b)", "a b", "tan(q1)", "'C1'"])
def test_an_expression_is_arithmetic_or_refused(text):
    with pytest.raises(OptionError, match="expression"):
        value_of(text, 0)


def test_expressions_are_compared_by_value():
    assert same("-S1*C2", "-(sin(q1)*cos(q2))")
    assert not same("-S1*C2", "-sin(q1)*sin(q2)")
    assert not same("a1", "a2")
    assert not same("q1", "q2")
    assert same("sqrt(4)*pi - a", "2*pi - a")
    assert compared([["C1", "0"]], [["cos(q1)", "1"]]) == [
        [ComparedExpression("cos(q1)", True), ComparedExpression("1", False)]
    ]


SMALL = """
schema = 1
paper = "wam7"
[arm]
where = "title"
form = "text"
unit = "1"
compute = "joints"
cells = { count = ["7"] }
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('compute = "joints"', 'compute = "wishes"', "arm.compute: no function 'wishes'; allowed: one of total_mass"),
        ('compute = "joints"', "", "arm.compute: missing; allowed: a recomputing function, or needs"),
        ('compute = "joints"', 'compute = "joints"\nerrata = ["none-such"]', "arm.errata: no erratum 'none-such'"),
        ('compute = "joints"', 'compute = "joints"\nreading = "mine"', "arm.reading: 'mine'; allowed: one of manual"),
        ('"7"', "7", r"arm.cells.count\[0\]: 7; allowed: text, digit for digit"),
        ('form = "text"', 'form = "rumour"', "arm.form: 'rumour'; allowed: one of table"),
        ('form = "text"', 'form = "figure"', "arm.ranges: missing; allowed: ranges for figures"),
        ('unit = "1"', "", "arm.unit: missing"),
        ('unit = "1"', 'unit = "1"\ncolour = "red"', "arm.colour: unknown field; allowed: where, form, unit"),
        ("schema = 1", "schema = 2", "schema: 2; allowed: 1"),
        ('paper = "wam7"', 'paper = "lwr4"', "paper: 'lwr4'; allowed: wam7"),
        (
            'form = "text"',
            'form = "figure"\nranges = { count = [["8", "9"]] }',
            r"arm.ranges.count\[0\]: the value read, 7, lies outside; allowed: a value within 8 to 9",
        ),
    ],
)
def test_a_broken_file_of_results_is_refused_in_one_line(old, new, message):
    text = SMALL.replace(old, new)
    with pytest.raises(PaperError, match=message) as caught:
        changed_numbers("wam7", results=tomllib.loads(text))
    assert "\n" not in str(caught.value)


def test_the_small_file_is_good_and_broken_toml_is_refused():
    assert changed_numbers("wam7", results=tomllib.loads(SMALL)).counts()[REPRODUCED] == 1
    assert results_of_tables(tomllib.loads(SMALL), "x").paper == "wam7"
    with pytest.raises(PaperError, match="TOML"):
        read_results("a = = 1", "x.toml")


def test_a_reading_of_an_unknown_erratum_or_of_two_on_one_cell_is_refused():
    tables = copy.deepcopy(dict(paper_study("lwr4plus").data.tables))
    tables["reading"]["printed"]["errata"] = ["table-nine"]
    with pytest.raises(PaperError, match=r"reading.printed.errata: 'table-nine'; allowed: one of table2-rows"):
        changed_numbers("lwr4plus", tables=tables)
    tables = copy.deepcopy(dict(paper_study("lwr4plus").data.tables))
    twice = copy.deepcopy(next(e for e in tables["erratum"] if e["id"] == "table2-c5z")) | {"id": "again"}
    tables["erratum"].append(twice)
    tables["reading"]["computed"]["errata"].append("again")
    with pytest.raises(PaperError, match=r"errata table2-c5z and again: both read inertial.com.values\[4\]"):
        changed_numbers("lwr4plus", tables=tables)
    tables["default_reading"] = "printed"  # a reading that is not used is refused as well
    with pytest.raises(PaperError, match="errata table2-c5z and again"):
        changed_numbers("lwr4plus", tables=tables)
