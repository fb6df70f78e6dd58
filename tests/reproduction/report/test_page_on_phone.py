"""A report on a phone: what a finger does."""

import pytest

from tests.headless import logs, screenshot
from tests.pages.replay.driven import PHONE, middle, number, opened, screen, until

pytestmark = pytest.mark.slow


def test_a_tap_on_a_phone_shows_the_origin_inside_the_screen(browser, report_path):
    with screen(browser, **PHONE):
        opened(browser, report_path)
        button = middle(browser, number(browser, "2.924"))
        button.click()
        popover = browser.find_element("id", button.get_attribute("popovertarget"))
        assert "Table IV, row 1" in popover.text
        assert popover.rect["x"] >= 0
        assert popover.rect["x"] + popover.rect["width"] <= PHONE["width"]
        browser.execute_script("document.getElementById('plot-errors').scrollIntoView()")
        screenshot(browser, "report_phone.png")
        assert logs(browser)[1] == []


def test_finger_scrolls_over_a_figure_and_a_tap_sets_the_time(browser, report_path):
    with screen(browser, **PHONE):
        opened(browser, report_path)
        x, y, before = browser.execute_script(
            """const plane = document.querySelector("[data-plot=torque] .plane");
            plane.scrollIntoView({ block: "center" }); window.scrollBy(0, -120);
            const box = plane.getBoundingClientRect();
            return [box.left + box.width / 2, box.top + box.height / 2, window.scrollY]"""
        )

        def touch(kind, *points):
            at = [{"x": x, "y": y - up} for up in points]
            browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})

        touch("touchStart", 0)
        touch("touchEnd")
        until(browser, lambda: browser.execute_script("return lwrReport.time") == pytest.approx(3.0, abs=0.05))
        browser.execute_script("lwrReport.set(1)")
        touch("touchStart", 0)
        for up in range(20, 180, 20):
            touch("touchMove", up)
        touch("touchEnd")
        until(browser, lambda: browser.execute_script("return window.scrollY") > before + 60)
        assert browser.execute_script("return lwrReport.time") == 1
