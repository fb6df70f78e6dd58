"""The report in headless Chromium without a network: replay and figures in step, cells by mouse, keys and touch."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.reproduction.report.content import Page, Replay
from lwr_dyn.reproduction.report.page import report_html, write_report
from tests.headless import logs, screenshot
from tests.reproduction.report.reported import CONTROLLERS
from tests.viewer.driven import LAPTOP, opened, screen, until

POSE = 1e-6
"""[m], and the same for rotation entries: largest difference between the pose on the page and FK."""
LARGEST_PAGE = 6_000_000
"""Bytes of a report at most."""
PIXELS = 1.0
"""A cursor stands where its time is, to a pixel."""


@pytest.fixture(scope="module")
def window(browser, report_path):
    with screen(browser, **LAPTOP):
        opened(browser, report_path)
        yield browser


def cursors(window, plot):
    """Of a plot, panel by panel: where its cursor is and where the time axis says it should be [px]."""
    return window.execute_script(
        """const chart = lwrReport.charts.find((one) => one.id === arguments[0]), t = lwrReplay.time();
        return [...chart.place.querySelectorAll(".cursor")].map((line, p) => {
          const axis = p ? String(p + 1) : "", at = line.getBoundingClientRect();
          const box = chart.graph.querySelector(`.draglayer .x${axis}y${axis} .nsewdrag`).getBoundingClientRect();
          const [a, b] = chart.graph.layout[`xaxis${axis}`].range;
          return [at.left + at.width / 2, box.left + (box.width * (t - a)) / (b - a), line.hidden];
        })""",
        plot,
    )


def area(window, plot):
    """The first panel's plot area in the window, scrolled into sight: an element to point at."""
    element = window.execute_script(
        """const chart = lwrReport.charts.find((one) => one.id === arguments[0]);
        return chart.graph.querySelector(".draglayer .xy .nsewdrag")""",
        plot,
    )
    window.execute_script("arguments[0].scrollIntoView({ block: 'center' })", element)
    return element


def test_page_loads_nothing_logs_nothing_and_draws_all(window, report_path, report_content):
    # The module's first look at the page: the logs start before it was opened.
    sent, said = logs(window)
    assert [address for address in sent if not address.startswith(("data:", "blob:"))] == [report_path.as_uri()]
    assert said == []
    drawn = window.execute_script(
        "return lwrReport.charts.map((c) => [c.id, c.graph.querySelectorAll('.scatterlayer .trace').length])"
    )
    plots = [*report_content.figures, *report_content.sections[0].figures]
    assert drawn == [[plot.id, sum(len(panel.curves) for panel in plot.panels)] for plot in plots]
    assert window.find_elements("css selector", ".notice") == []


@pytest.mark.parametrize("k", [0, 1234, 3000])
@pytest.mark.parametrize("run", [0, 1])
def test_pose_on_the_page_is_forward_kinematics(window, arm, two_runs, run, k):
    pose = window.execute_script(
        "lwrReplay.setTime(arguments[0]); return lwrReplay.flangePose(arguments[1])", two_runs[run].t[k], run
    )
    np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(arm, two_runs[run].q[k]), rtol=0, atol=POSE)


def test_still_pose_shows_frames_and_scrubbing_returns_to_the_replay(window, arm):
    seen = """const stage = lwrReplay.stage;
        return [stage.runs, stage.stills].map((arms) => arms.map((arm) => stage.node(arm.root).visible))"""
    window.find_elements("css selector", "#poses button")[1].click()
    assert window.execute_script(seen) == [[False, False], [True]]
    assert window.find_element("id", "still-note").text == "DH frames, arm stretched up"
    pose = window.execute_script("return lwrReplay.flangePose(2)")
    np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(arm, np.zeros(7)), rtol=0, atol=POSE)
    screenshot(window, "report_still.png")
    area(window, "errors").click()
    assert window.execute_script(seen) == [[True, True], [False]]


def test_curves_are_the_numbers_of_the_runs(window, two_runs):
    y, t = window.execute_script(
        "const d = lwrReport.charts[0].graph.data[8]; return [[...d.y], [...d.x]]"  # second run, second joint
    )
    np.testing.assert_allclose(t, two_runs[1].t, atol=1e-8)
    np.testing.assert_allclose(y, 1e3 * (two_runs[1].q_ref - two_runs[1].q)[:, 1], atol=1e-5)
    x, z = window.execute_script("const d = lwrReport.charts[2].graph.data[1]; return [d.x[500], d.y[500]]")
    assert [x, z] == pytest.approx(
        list(lwr_dyn.forward_kinematics(lwr_dyn.load("lwr4plus"), two_runs[0].q[500])[[0, 2], 3]), abs=1e-8
    )


def test_scrubber_moves_every_cursor(window):
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


def test_click_and_drag_in_a_figure_set_the_time(window):
    from selenium.webdriver import ActionChains

    def time():
        return window.execute_script("return lwrReplay.time()")

    plane = area(window, "torque")
    ActionChains(window).move_to_element_with_offset(plane, int(plane.size["width"] / 4), 0).click().perform()
    per_pixel = 6.0 / plane.size["width"]
    assert time() == pytest.approx(4.5, abs=2 * per_pixel)
    line = window.find_element("css selector", "[data-plot=torque] .cursor")
    ActionChains(window).click_and_hold(line).move_by_offset(-60, 0).release().perform()
    assert time() == pytest.approx(4.5 - 60 * per_pixel, abs=4 * per_pixel)


def test_zoom_by_drag_keeps_cursors_true_and_the_time(window):
    from selenium.webdriver import ActionChains

    window.execute_script("lwrReplay.setTime(3)")
    plane = area(window, "errors")
    width = plane.size["width"]
    start = ActionChains(window).move_to_element_with_offset(plane, int(-width / 4), -20).click_and_hold()
    start.move_by_offset(int(width / 2), 0).release().perform()
    low, high = window.execute_script("return lwrReport.charts[0].graph.layout.xaxis.range")
    assert 1.3 < low < 1.7
    assert 4.3 < high < 4.7
    assert window.execute_script("return lwrReplay.time()") == 3
    for at, asked, hidden in cursors(window, "errors"):
        assert not hidden
        assert abs(at - asked) <= PIXELS
    window.execute_script("lwrReplay.setTime(5)")
    assert all(hidden for _, _, hidden in cursors(window, "errors"))
    window.execute_script("Plotly.relayout(lwrReport.charts[0].graph, { 'xaxis.range': [0, 6] })")


def test_values_at_the_cursor_are_text(window, two_runs):
    window.execute_script("lwrReplay.setTime(4)")
    box = window.find_element("css selector", "[data-plot=torque] + details")
    box.find_element("css selector", "summary").click()
    row = box.find_elements("css selector", "tr")[2]
    until(window, lambda: row.text.startswith("joint_2, pd-gravity "))
    assert float(row.text.split()[2]) == pytest.approx(two_runs[0].tau_applied[2000, 1], rel=1e-4)


def test_page_is_whole_at_the_end(window):
    window.execute_script("lwrReplay.setTime(4.2); document.getElementById('replay').scrollIntoView()")
    screenshot(window, "report.png")
    assert logs(window) == ([], [])


def test_without_webgl_figures_and_cursors_still_work(browser, tmp_path, report_path):
    blind = """const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
          return /webgl/.test(kind) ? null : get.call(this, kind, ...rest); };"""
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": blind})
    try:
        with screen(browser, **LAPTOP):
            opened(browser, report_path)
            assert "3D view could not start" in browser.find_element("css selector", ".notice").text
            area(browser, "errors").click()
            left = browser.execute_script(
                "return document.querySelector('.cursor').getBoundingClientRect().left - "
                "document.querySelector('.graph').getBoundingClientRect().left"
            )
            assert left > 200
    finally:
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", {"identifier": added["identifier"]})


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
        assert logs(browser)[1] == []
        assert browser.find_elements("css selector", ".notice") == []
        if parts == "still only":
            assert browser.execute_script("return lwrReplay.stage.node(lwrReplay.stage.stills[0].root).visible")


def test_same_records_give_the_same_small_page(report_content, report_path, arm, two_runs):
    text = report_html(report_content)
    assert text == report_path.read_text(encoding="utf-8")
    assert len(text.encode()) < LARGEST_PAGE
    assert text.count("</script>") == 4  # three packed libraries and the page's own
    assert CONTROLLERS[0] not in text.split("<main>")[0]
