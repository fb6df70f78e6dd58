"""The page of a comparison: its numbers, no request, names escaped, and axe and contrast on all four screens."""

import re
from dataclasses import replace

import pytest

import lwr_dyn
from lwr_dyn.pages.figures.run_figures import path_figure, tip_error_figure
from lwr_dyn.pages.plotting.drawn_panel import POINTS, chart_html, drawn_panels
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.studies.compare.comparison import comparison_html
from tests.axe import SCREENS, faint_texts, seen, sideways, violations

BAD = '<img src=x onerror="alert(1)">'


@pytest.fixture(scope="module")
def compared(two_runs):
    return lwr_dyn.compare(*two_runs, labels=["late & early", BAD])


@pytest.fixture(scope="module")
def opened(compared, browser, tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "x.html"
    compared.save(file)
    browser.get(file.as_uri())
    return browser


def test_it_has_the_numbers_and_the_best_in_bold(compared):
    text = comparison_html(compared)
    for one in compared.runs:
        assert f"{one.figures.tip_rms_mm:.4g}" in text
    best = min(one.figures.tip_rms_mm for one in compared.runs)
    assert f"<b>{best:.4g} *</b>" in text
    assert "errors of the tip: rigid links and joints" in text
    assert text == comparison_html(compared)


def test_names_are_escaped_and_nothing_is_loaded(compared):
    text = comparison_html(compared)
    assert "<img" not in text
    assert "&lt;img" in text
    assert "<script" not in text
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", text)
    assert re.findall(r"url\((?!data:)", text) == []
    assert "<img" not in compared._repr_html_()
    assert 200 < len(compared._repr_html_()) < 2200
    assert "* the smallest of its plant" in compared._repr_html_()


def test_a_line_keeps_its_ends_and_its_extremes(arm, two_runs):
    shown = replayed_runs(two_runs, arm)
    text = chart_html(tip_error_figure(shown), shown)
    lines = [re.findall(r"(-?\d+),(-?\d+)", d) for d in re.findall(r'<path class="r\d" d="M([^"H]*)"', text)]
    assert len(lines) == 2
    for points in lines:
        assert len(points) <= 4 * POINTS + 2
        across = [int(a) for a, _ in points]
        assert (across[0], across[-1]) == (0, 2000)
    top = min(int(down) for points in lines for _, down in points)
    (panel,) = drawn_panels(tip_error_figure(shown), shown)
    assert top == round(1000 * (1.0 - float(panel.y.share(panel.peak))))


def test_a_path_says_how_much_its_errors_are_magnified(arm, two_runs):
    near = [replace(run, q=run.q_ref + 1e-3 * (run.q - run.q_ref)) for run in two_runs]
    figure = path_figure(replayed_runs(two_runs, arm))
    assert "true to scale" in chart_html(figure, replayed_runs(two_runs, arm))
    shown = replayed_runs(near, arm)
    (panel,) = drawn_panels(figure, shown)
    assert panel.magnified > 1
    text = chart_html(figure, shown)
    assert f"errors \u00d7 {panel.magnified}<" in text
    wide, of_path = re.search(r"width:([\d.]+)%\"></i>path ([\d.]+) mm", text).groups()
    narrow, of_error = re.search(r"width:([\d.]+)%\"></i>error ([\d.]+) mm", text).groups()
    scale = float(of_path) / float(wide) / (float(of_error) / float(narrow))
    assert scale == pytest.approx(panel.magnified, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), SCREENS)
def test_a_browser_finds_nothing_against_it(width, dark, opened):
    with seen(opened, width, dark):
        assert violations(opened) == []
        assert faint_texts(opened) == []
        assert sideways(opened) == 0


def test_it_makes_no_request(opened):
    names = opened.execute_script("return performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert [name for name in names if not name.startswith("data:")] == []
