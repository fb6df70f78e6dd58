"""The report in headless Chromium without a network: 3D on a click, figures in step with it, zoom and values."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.pages.figures.run_figures import path_figure
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.report.content import Page, Replay
from lwr_dyn.reproduction.report.page import main, report_html, write_report
from tests.headless import logs, screenshot
from tests.pages.replay.driven import LAPTOP, opened, screen, started, traffic, until, without_webgl
from tests.pages.replay.replayed import lagging_run
from tests.reproduction.report.reported import CONTROLLERS

POSE = 1e-6
"""[m], and the same for rotation entries: largest difference between the pose on the page and FK."""
LARGEST_PAGE = 2_000_000
"""Bytes of a report at most."""
PIXELS = 1.0
"""A cursor stands where its time is, to a pixel."""


@pytest.fixture(scope="module")
def window(browser, report_path):
    with screen(browser, **LAPTOP):
        opened(browser, report_path)
        yield browser


def planes(window, plot):
    """The planes of a figure, scrolled into sight."""
    found = window.find_elements("css selector", f"[data-plot={plot}] .plane")
    window.execute_script("arguments[0].scrollIntoView({ block: 'center' })", found[0])
    return found


def cursors(window, plot):
    """Of a plot, panel by panel: where its cursor is and where the time axis says it should be [px]."""
    return window.execute_script(
        """const chart = lwrReport.charts.find((one) => one.id === arguments[0]), t = lwrReport.time;
        return chart.panels.map(({ plane, x: [a, b] }) => {
          const line = plane.querySelector(".cursor"), at = line.getBoundingClientRect();
          const box = plane.getBoundingClientRect();
          return [at.left + at.width / 2, box.left + (box.width * (t - a)) / (b - a), line.hidden];
        })""",
        plot,
    )


@pytest.mark.slow
def test_page_loads_nothing_logs_nothing_and_shows_all_without_the_player(window, report_path, report_content):
    # The module's first look at the page: the logs start before it was opened.
    assert traffic(window, "blob:") == ([report_path.as_uri()], [])
    drawn = window.execute_script(
        """return [...document.querySelectorAll(".chart")].map((c) =>
          [c.dataset.plot, c.querySelectorAll("path.l, path.dots").length])"""
    )
    plots = [*report_content.figures, *report_content.sections[0].figures]
    assert drawn == [[plot.id, sum(len(panel.curves) for panel in plot.panels)] for plot in plots]
    assert window.find_elements("css selector", ".notice") == []
    assert window.execute_script("return [!!window.lwrReplay, !!window.THREE]") == [False, False]
    assert window.find_element("css selector", ".still img").is_displayed()


def test_a_figure_sets_the_time_before_the_player_is_there(window):
    planes(window, "errors")[0].click()
    until(window, lambda: window.execute_script("return lwrReport.time") > 0)
    assert window.execute_script("return lwrReport.time") == pytest.approx(3.0, abs=0.1)
    assert all(abs(at - asked) <= PIXELS for at, asked, _ in cursors(window, "torque"))


@pytest.mark.slow
@pytest.mark.parametrize("k", [0, 1230, 3000])
@pytest.mark.parametrize("run", [0, 1])
def test_pose_on_the_page_is_forward_kinematics(window, arm, two_runs, run, k):
    started(window)
    pose = window.execute_script(
        "lwrReplay.setTime(arguments[0]); return lwrReplay.flangePose(arguments[1])", two_runs[run].t[k], run
    )
    np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(arm, two_runs[run].q[k]), rtol=0, atol=POSE)


@pytest.mark.slow
def test_still_pose_shows_frames_and_a_figure_returns_to_the_replay(window, arm):
    started(window)
    seen = """const stage = lwrReplay.stage;
        return [stage.runs, stage.stills].map((arms) => arms.map((arm) => stage.node(arm.root).visible))"""
    window.execute_script("window.scrollTo(0, 0)")
    window.find_elements("css selector", "#poses button")[1].click()
    assert window.execute_script(seen) == [[False, False], [True]]
    assert window.find_element("id", "still-note").text == "DH frames, arm stretched up"
    pose = window.execute_script("return lwrReplay.flangePose(2)")
    np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(arm, np.zeros(7)), rtol=0, atol=POSE)
    screenshot(window, "report_still.png")
    planes(window, "errors")[0].click()
    until(window, lambda: window.execute_script(seen) == [[True, True], [False]])


@pytest.mark.slow
def test_curves_are_the_numbers_of_the_runs(window, two_runs):
    started(window)
    y, t = window.execute_script(
        "const c = lwrReport.charts[0].panels[1].curves[1]; return [[...c.y], [...c.x]]"  # second run, second joint
    )
    np.testing.assert_allclose(t, two_runs[1].t[::5], atol=1e-8)
    np.testing.assert_allclose(y, 1e3 * (two_runs[1].q_ref - two_runs[1].q)[::5, 1], atol=1e-5)


@pytest.mark.slow
def test_scrubber_moves_every_cursor(window):
    started(window)
    for t in (0.0, 2.5, 6.0):
        window.execute_script(
            """const bar = document.getElementById("scrub"); bar.value = arguments[0];
            bar.dispatchEvent(new Event("input"))""",
            t,
        )
        for plot, panels in (("errors", 2), ("torque", 7)):
            found = cursors(window, plot)
            assert len(found) == panels
            for at, asked, hidden in found:
                assert not hidden
                assert abs(at - asked) <= PIXELS


@pytest.mark.slow
def test_zoom_by_drag_keeps_cursors_true_and_the_time(window):
    from selenium.webdriver import ActionChains

    started(window)
    window.execute_script("lwrReplay.setTime(3)")
    plane = planes(window, "errors")[0]
    width = plane.size["width"]
    start = ActionChains(window).move_to_element_with_offset(plane, int(-width / 4), -20).click_and_hold()
    start.move_by_offset(int(width / 2), 0).release().perform()
    until(window, lambda: window.execute_script("return lwrReport.charts[0].range") is not None)
    low, high = window.execute_script("return lwrReport.charts[0].range")
    assert 1.3 < low < 1.7
    assert 4.3 < high < 4.7
    assert window.execute_script("return lwrReport.time") == 3
    for at, asked, hidden in cursors(window, "errors"):
        assert not hidden
        assert abs(at - asked) <= PIXELS
    window.execute_script("lwrReplay.setTime(5)")
    assert all(hidden for _, _, hidden in cursors(window, "errors"))
    window.find_element("css selector", "[data-plot=errors] .reset").click()
    assert window.execute_script("return lwrReport.charts[0].panels[0].x") == pytest.approx([0.0, 6.0])


@pytest.mark.slow
def test_values_at_the_cursor_are_text(window, two_runs):
    started(window)
    window.execute_script("lwrReplay.setTime(4)")
    assert "at 4.00 s" in window.find_element("css selector", "[data-plot=torque] .at").text
    shown = window.find_elements("css selector", "[data-plot=torque] .now")[1].text
    values = [float(value.replace("\u2212", "-")) for value in shown.split(" | ")]
    assert values == pytest.approx([run.tau_applied[2000, 1] for run in two_runs], rel=5e-3)


def test_the_time_bar_follows_where_the_3d_view_is_out_of_sight(window):
    started(window)
    docked = "return document.getElementById('controls').classList.contains('docked')"
    window.execute_script("document.getElementById('evidence').scrollIntoView()")
    until(window, lambda: window.execute_script(docked))
    window.execute_script("document.getElementById('bar').scrollIntoView({ block: 'center' })")
    until(window, lambda: not window.execute_script(docked))
    assert logs(window)[1] == []


@pytest.mark.slow
def test_without_webgl_figures_and_cursors_still_work(browser, report_path):
    with without_webgl(browser), screen(browser, **LAPTOP):
        opened(browser, report_path)
        browser.find_element("id", "start-3d").click()
        until(browser, lambda: browser.find_elements("css selector", ".notice"))
        assert "3D view could not start" in browser.find_element("css selector", ".notice").text
        planes(browser, "errors")[0].click()
        until(browser, lambda: browser.find_elements("css selector", "[data-plot=errors] .cursor"))
        assert all(abs(at - asked) <= PIXELS for at, asked, _ in cursors(browser, "errors"))


@pytest.mark.slow
@pytest.mark.parametrize(("lag", "factor"), [(0.005, 10), (0.0005, 100)])
def test_a_path_is_drawn_with_its_errors_magnified_and_the_page_says_how_much(browser, tmp_path, arm, lag, factor):
    runs = replayed_runs([lagging_run(arm, lag, "near"), lagging_run(arm, 0.5 * lag, "nearer")], arm)
    write_report(tmp_path / "path.html", Page("p", figures=(path_figure(runs, plane="xz"),), replay=Replay(runs)))
    with screen(browser, **LAPTOP):
        opened(browser, tmp_path / "path.html")
        plane = browser.find_element("css selector", "[data-plot=path] .plane")
        assert plane.get_attribute("data-magnified") == str(factor)
        assert f"errors \u00d7 {factor}" in browser.find_element("css selector", "[data-plot=path] .about").text
        found = browser.execute_async_script(
            """lwrReport.numbers().then(() => { const c = lwrReport.charts[0].panels[0].curves[1];
            arguments[0]([c.x[100], c.y[100]]); })"""
        )
        run = runs[0].run
        wanted, is_at = (lwr_dyn.forward_kinematics(arm, q[500])[[0, 2], 3] for q in (run.q_ref, run.q))
        np.testing.assert_allclose(found, wanted + factor * (is_at - wanted), atol=1e-6)
        bar = browser.find_element("css selector", "[data-plot=path] .scale")
        length, error = (float(text.split()[1]) for text in bar.text.split(", "))
        assert error * factor == pytest.approx(length)
        low, high = map(float, plane.get_attribute("data-x").split())
        drawn = bar.find_element("css selector", "i").rect["width"] / plane.rect["width"]
        assert drawn == pytest.approx(1e-3 * length / (high - low), abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("parts", ["still only", "figures only", "tables only"])
def test_parts_may_be_missing(browser, tmp_path, report_content, parts):
    replay = report_content.replay
    page = {
        "still only": replace(report_content, figures=(), sections=(), replay=Replay(stills=replay.stills)),
        "figures only": replace(report_content, figures=(), replay=None),
        "tables only": Page("tables", tables=report_content.tables),
    }[parts]
    write_report(tmp_path / "part.html", page)
    with screen(browser, **LAPTOP):
        opened(browser, tmp_path / "part.html")
        if parts == "still only":
            started(browser)
            assert browser.execute_script("return lwrReplay.stage.node(lwrReplay.stage.stills[0].root).visible")
        assert logs(browser)[1] == []
        assert browser.find_elements("css selector", ".notice") == []


@pytest.mark.slow
def test_same_records_give_the_same_small_page(report_content, report_path):
    text = report_html(report_content)
    assert text == report_path.read_text(encoding="utf-8")
    assert len(text.encode()) < LARGEST_PAGE
    assert text.count("</script>") == 3  # two packed libraries and the page's own
    assert CONTROLLERS[0] not in text.split("<main>")[0]


def test_a_part_can_be_jumped_to_and_all_but_the_result_show_their_heading():
    part = '<section id="{0}" class="part" tabindex="-1" aria-labelledby="{0}-title"><h2 id="{0}-title"{2}>{1}</h2>'
    text = str(main([("result", "Result", "", "a"), ("errata", "Errata", "3", "b")]))
    first, second = part.format("result", "Result", ' class="hidden-word"'), part.format("errata", "Errata", "")
    assert text == f'{first}<div class="body">a</div></section>{second}<div class="body">b</div></section>'
