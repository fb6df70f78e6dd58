"""Records of a report: what cannot be shown is refused when it is built; runs are thinned, and the page says so."""

import gzip
import json
import re
import subprocess
import sys
from base64 import b64decode

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.pages.figures.figure import Curve, Figure, Panel, Series
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
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


def test_gaps_and_shared_numbers(arm, two_runs):
    x = np.linspace(0.0, 1.0, 100)
    y = np.where(x > 0.5, np.nan, x)
    data = script_data(Page("p", figures=(plot_of(Curve("a", y, x), Curve("b", x, x), Curve("c", TWO, TWO)),)))
    curves = data["figures"][0]["panels"][0]["curves"]
    assert curves[0]["x"] == curves[1]["x"] == curves[1]["y"] != curves[0]["y"]
    assert data["numbers"][curves[0]["y"]]["gaps"] == list(range(50, 100))
    assert data["numbers"][curves[2]["x"]] == [1.0, 2.0]


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
