"""Records of a report: what cannot be shown is refused when it is built; runs are thinned, and the page says so."""

import gzip
import json
import re
import subprocess
import sys
from base64 import b64decode
from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.pages.figures.figure import Curve, Figure, Panel, Series
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.report import page as page_module
from lwr_dyn.reproduction.report.content import Page, Replay, ReportCell, ReportRow, ReportTable
from lwr_dyn.reproduction.report.page import page_stride, report_html, script_data
from tests.pages.replay.replayed import lagging_run
from tests.reproduction.report.reported import inertia_table, report

ROW = ReportRow("r", (ReportCell("1"),))
TWO = np.array([1.0, 2.0])


def plot_of(*curves):
    return Figure("p", "p", "", "x", "", (Panel("", "y", "", curves),))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ReportCell("1", verdict="fine"), "verdict: 'fine'; allowed: reproduced, after erratum"),
        (lambda: ReportTable("t", "t", "", ("a", "b"), (ROW,)), "row 'r': 1 cells; allowed: 2"),
        (lambda: Replay(), "no run and no still"),
        (lambda: Page("p", tables=(inertia_table(), inertia_table())), "ids of a page: IV more than once"),
        (lambda: report_html(Page("p", figures=(plot_of(Curve("c", Series(0, "q", 0))),))), "no run is shown"),
    ],
)  # fmt: skip
def test_what_cannot_be_shown_is_refused(make, message):
    with pytest.raises(OptionError, match=message):
        make()


def test_series_of_a_joint_that_is_not_there(arm, two_runs):
    page = Page("p", figures=(plot_of(Curve("c", Series(0, "q", 7))),), replay=Replay(replayed_runs(two_runs[:1], arm)))
    with pytest.raises(OptionError, match="joint of a series: 7; allowed: 0 to 6"):
        report_html(page)


def test_counts_are_those_of_the_cells_unless_given():
    assert Page("p", tables=(inertia_table(),)).counted == {
        "reproduced": 8, "after erratum": 4, "differs": 4, "not reproducible": 4,
        "structural": 0, "repeated in print": 0, "under assumed conditions": 0,
    }  # fmt: skip


def test_gaps_and_shared_numbers():
    x = np.linspace(0.0, 1.0, 100)
    y = np.where(x > 0.5, np.nan, x)
    data = script_data(Page("p", figures=(plot_of(Curve("a", y, x), Curve("b", x, x), Curve("c", TWO, TWO)),)))
    curves = data["figures"][0]["panels"][0]["curves"]
    assert curves[0]["x"] == curves[1]["x"] == curves[1]["y"] != curves[0]["y"]
    assert data["numbers"][curves[0]["y"]]["gaps"] == list(range(50, 100))
    assert data["numbers"][curves[2]["x"]] == [1.0, 2.0]


@pytest.mark.parametrize(
    ("samples", "seconds", "stride"),
    [(601, 6.0, 1), (1199, 6.0, 1), (1201, 6.0, 2), (3001, 6.0, 5), (1, 0.0, 1), (31, 6.0, 1)],
)
def test_a_page_has_100_samples_a_second_at_least(samples, seconds, stride):
    assert page_stride(SimpleNamespace(t=np.linspace(2.0, 2.0 + seconds, samples))) == stride


def test_numbers_of_more_than_48_places_are_packed_and_of_more_than_1500_some_are_left_out():
    for size, packed_ in ((48, False), (49, True)):
        line = np.arange(float(size))
        line[3] = np.nan
        numbers = script_data(Page("p", figures=(plot_of(Curve("a", line, np.arange(float(size)))),)))["numbers"]
        assert [isinstance(x, dict) for x in numbers] == [packed_] * 2
        assert (numbers[1]["gaps"] if packed_ else [k for k, x in enumerate(numbers[1]) if x is None]) == [3]
    for size, kept in ((1500, 1500), (1501, 751), (3001, 1001)):
        x, names = np.arange(float(size)), tuple(map(str, range(size)))
        data = script_data(Page("p", figures=(plot_of(Curve("a", x, x, "points", text=names)),)))
        curve = data["figures"][0]["panels"][0]["curves"][0]
        assert (data["numbers"][curve["x"]]["shape"], len(curve["text"])) == ([kept], kept)
        assert (curve["text"][1], curve["text"][-1]) == (str(-(-size // 1500)), str(size - 1))


@pytest.mark.parametrize(
    ("heights", "cut"),
    [
        ([1] * 2, 1),
        ([1] * 3, 2),
        ([5, 1, 1], 1),
        ([1, 1, 5], 2),
        ([1, 5, 1], 2),
        ([3], 1),
        ([9, 1, 1], 1),
        ([1] * 4, 2),
    ],
)
def test_tables_are_parted_where_both_halves_are_about_as_high(heights, cut):
    assert page_module._cut(heights) == cut


def test_a_page_has_its_parts_with_their_counts_and_says_what_is_proven(arm, two_runs):
    page = report(arm, two_runs)
    parts = page_module.parts_of(page)
    assert [(place, number, len(body)) for place, _, number, body in parts] == [
        ("result", "", 2), ("motion", "", 3), ("numbers", "24", 2), ("errata", "4", 2), ("evidence", "", 5),
    ]  # fmt: skip
    shown = {place: f'<span class="cnt">{number}</span>' if number else "" for place, _, number, _ in parts}
    links = "".join(f'<a href="#{place}">{place.capitalize()}{count}</a>' for place, count in shown.items())
    assert page_module.header(page, parts) == (
        '<header class="top"><div><b>lwr_dyn</b><span>reproduction of recomputed</span></div>'
        f'<nav aria-label="parts of the report">{links}</nav></header>'
    )
    lead = '<div class="lead"><h1>A paper with tables</h1><p class="by">Authors</p>'
    assert parts[0][3][0].startswith(f'{lead}<p class="say"><b>8 of 24</b> come out.</p><div><ul class="key"')
    assert "4 entries, 2 of them proven by a computation that runs with this report." in parts[3][3][0]
    assert "Derived numbers" in parts[2][3][1]
    heads = re.findall(r'<h2 id="(\w+)-title"( class="hidden-word")?>', page_module.main(parts))
    assert heads == [(place, ' class="hidden-word"' * (place == "result")) for place, *_ in parts]
    bare = page_module.parts_of(Page("p"))
    assert [(place, len(body)) for place, _, _, body in bare] == [("result", 1)]
    assert bare[0][3][0] == '<div class="lead"><h1>p</h1></div>'


@pytest.mark.slow
def test_runs_are_on_the_page_at_100_samples_a_second_and_the_page_says_so(arm):
    runs = [lagging_run(arm, 0.01 * i, f"controller {i}", k=28001, duration=28.0) for i in (1, 2)]
    page = report(arm, runs)
    text = report_html(page)
    assert "Replay and cursors have 100 samples a second; the run files have 1000." in text
    record = packed(text)["runs"][0]
    assert record["samples"] == [2801, 28001]
    assert record["series"]["torque"]["shape"] == [2801, 7]
    assert "q" not in record["series"]


@pytest.mark.slow
def test_a_run_slower_than_the_page_is_whole(arm):
    slow = lagging_run(arm, 0.01, "slow", k=301, duration=6.0)
    shown = Page("p", replay=Replay(replayed_runs([slow], arm)))
    assert page_stride(slow) == 1
    assert packed(report_html(shown))["runs"][0]["samples"] == [301, 301]
    assert "All samples of the runs are on this page." in report_html(shown)


def packed(text):
    """The numbers of a page."""
    return json.loads(gzip.decompress(b64decode(re.search(r'id="packed-numbers">(.*?)</script>', text).group(1))))


@pytest.mark.slow
def test_neither_plotly_nor_matplotlib_is_imported_for_a_page():
    program = """
import sys
sys.modules["plotly"] = sys.modules["matplotlib"] = None
from lwr_dyn.reproduction.report.content import Page
from lwr_dyn.reproduction.report.page import report_html
from lwr_dyn.pages.figures.run_figures import register_figure
from lwr_dyn.reproduction.wam7 import study
print(len(report_html(Page("p"))) > 1000)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True"
