"""Parts of a report as HTML: their words and marks, of the invented report."""

import re
from html import unescape
from itertools import count

import pytest

from lwr_dyn.foundation.tables import Table
from lwr_dyn.reproduction.report import blocks
from lwr_dyn.reproduction.report.content import Check, FileFact, Page, ReportCell, ReportSection
from tests.reproduction.report.reported import errata, expressions, inertia_table


def words(html):
    """Its texts, "|" between elements."""
    return re.sub(r"\s*\n\s*", "|", unescape(re.sub(r"(<[^>]*>)+", "\n", html))).strip("|")


def test_the_map_has_a_key_and_a_line_a_table():
    html = blocks.number_map(Page("p", tables=(inertia_table(), expressions())))
    assert re.findall(r'<li><i class="g (v\d)"></i>([^<]*)', html) == [
        ("v1", "8 reproduced"), ("v2", "5 after an erratum"), ("v4", "4 differ"), ("v5", "1 structural"),
        ("v8", "1 assumed, near"), ("v3", "1 assumed, not near"), ("v7", "4 not reproducible"),
    ]  # fmt: skip
    many = "4 after an erratum, 8 reproduced, 4 differs, 4 not reproducible"
    few = "1 after an erratum, 1 assumed, near, 1 assumed, not near, 1 structural"
    assert re.findall(r'<li( class="small")?><a href="([^"]*)" title="([^"]*)"', html) == [
        ("", "#table-IV", f"Greatest inertias: {many}"), (' class="small"', "#table-K", f"Energies: {few}"),
    ]  # fmt: skip
    assert re.findall(r'class="mc" role="img" aria-label="([^"]*)"', html) == [many, few]
    lines = [re.findall(r'class="g (v\d)"', line) for line in html.split('class="mc"')[1:]]
    assert lines == [["v2", "v1", "v1", "v4", "v7"] * 4, ["v2", "v8", "v3", "v5"]]
    assert re.findall(r'class="mn">(\d+)', html) == ["20", "4"]
    assert blocks.number_map(Page("p")) is None


def test_a_table_of_numbers_line_by_line():
    html = blocks.number_table_html(expressions(), {"E2"}, count(7))
    assert words(html) == (
        "Energies|below Table IV|number|printed|recomputed|off, in last digits|half is the bound|verdict"
        "|line 1|K = 1/2 m v**2 + 1/2 I w**2|Energies: line 1|after an erratum|errata: E1|I*w**2/2 + m*v**2/2"
        "|after an erratum|E1"
        "|line 2|4.6|Energies: line 2|assumed, near|4.7|+1|assumed, near"
        "|line 3|4.6|Energies: line 3|assumed, not near|0.8|\u221238|assumed, not near"
        "|1 structural|number|printed|recomputed|verdict|line 4|1|Energies: line 4|structural|1|structural"
    )
    shown = re.findall(r'id="p(\d+)"', html)
    assert re.findall(r'popovertarget="p(\d+)"', html) == shown
    assert sorted(map(int, shown)) == [7, 8, 9, 10]
    assert 'colspan="3"' in html
    assert 'id="table-K"' in html
    one = words(blocks.number_table_html(inertia_table(), {"E2"}, count()))
    assert one.startswith("Greatest inertias|Table IV, page 3 \u00b7 kg m\u00b2|number|")
    assert (
        "|joint 1, b [kg m\u00b2]|2.924|Greatest inertias: joint 1, b [kg m\u00b2]|after an erratum"
        "|read from: Table IV, row 1|computed as: max over q of B_ii + k_r^2 I_m|unit: kg mm^2 -> kg m^2"
        "|note: q2 counted from the vertical|errata: E2, E9|2.92437|+0.37|after an erratum|E2|E9|joint 1, y|"
    ) in one


@pytest.mark.parametrize(
    ("digits", "mark", "text"),
    [
        (0.0, '<u style="left:50%;width:0%">', "0"),
        (0.004, '<u style="left:50%;width:0%">', "0"),
        (0.37, '<u style="left:50%;width:37%">', "+0.37"),
        (0.5, '<u style="left:50%;width:50%">', "+0.5"),
        (-0.21, '<u style="right:50%;width:21%">', "\u22120.21"),
        (79.0, '<u class="beyond" style="left:50%;width:50%">', "+79"),
    ],
)
def test_how_far_ours_is_off(digits, mark, text):
    html = blocks._residual(ReportCell("1", digits=digits))
    assert mark in html
    assert words(html) == text


@pytest.mark.parametrize(
    ("place", "tail"),
    [
        (0, "|proven|proof|the tables disagree|B_11 with I2 as printed: 2.879|B_11 with y and z exchanged: 2.908"
            "|checked|the computation comes out as stated|effect|none|severity|high"),
        (2, "|proven, FAILS|proof|the tables disagree|B_11 with I2 as printed: 2.879"
            "|B_11 with y and z exchanged: 2.908|checked|THE COMPUTATION DOES NOT COME OUT AS STATED"
            "|effect|timing|severity|low"),
        (3, "|likely|reason|the tables disagree|checked|no computation decides it|effect|timing|severity|low"),
    ],
)  # fmt: skip
def test_an_erratum(place, tail):
    entry = errata()[place]
    html = blocks.erratum_html(entry)
    e = entry.erratum
    assert words(html) == f"{e.id}|{e.where}|{e.printed}|\u2192|right:|{e.read_as}{tail}"
    assert f"<del>{e.printed}</del>" in html
    assert f'class="status {("proven", "", "fails", "likely")[place]}"' in html


GOOD, EXPECTED, BAD = (
    Check("a", "1", "2", True, "n"),
    Check("b", "3", "2", False, "", True),
    Check("c", "3", "2", False),
)


@pytest.mark.parametrize(
    ("checks", "count", "fails"),
    [
        ([GOOD], "it holds", False),
        ([GOOD, GOOD], "all 2 hold", False),
        ([GOOD, EXPECTED], "1 hold, 1 fail as expected", False),
        ([GOOD, EXPECTED, BAD], "1 hold, 1 fail as expected, 1 FAIL", True),
    ],
)
def test_checks_stand_open_when_one_fails_that_should_not(checks, count, fails):
    html = blocks.checks_html("C", checks)
    outcomes = {GOOD: "a|n|1|2|holds", EXPECTED: "b|3|2|fails as expected", BAD: "c|3|2|FAILS"}
    assert words(html) == "|".join(["C", count, "check|value|allowed|outcome", *(outcomes[one] for one in checks)])
    assert (" open>" in html, 'class="count alarm"' in html, '<td class="alarm">' in html) == (fails,) * 3


def test_a_section_and_files():
    table = Table("t", ("h",), [(1,)])
    html = blocks.section_html(ReportSection("s", "S", "one\n\na  b\nc", (table,)), ())
    assert words(html) == "S|5 lines|one|a  b|c|t|h|1"
    assert 'id="section-s"' in html
    assert '<p>one</p><pre tabindex="0" role="region" aria-label="a  b">a  b\nc</pre>' in html
    assert words(blocks.section_html(ReportSection("s", "S", "one"), ())) == "S|1 line|one"
    files = [FileFact("r.json", 1234567, "ab", "w"), FileFact("s", 5, "cd")]
    assert words(blocks.files_html(files)) == (
        "Files beside this page|2, 1.2 MB|file|what|bytes|SHA-256|r.json|w|1\u202f234\u202f567|ab|s|5|cd"
    )
    assert words(blocks.facts_html([("a", "b"), ("c", "d")])) == "a|b|c|d"
