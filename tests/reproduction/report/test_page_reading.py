"""Reading a report in headless Chromium: by mouse, keys and touch, on a phone, on paper, with hostile names in it."""

import base64

import pytest

from lwr_dyn.reproduction.report.page import write_report
from tests.axe import SCREENS, faint_texts, seen, sideways, violations
from tests.headless import logs, screenshot
from tests.pages.replay.driven import LAPTOP, PHONE, middle, number, opened, screen, started, until
from tests.reproduction.report.reported import HOSTILE, report


@pytest.fixture(scope="module")
def window(browser, report_path):
    with screen(browser, **LAPTOP):
        opened(browser, report_path)
        yield browser


@pytest.mark.slow
def test_a_number_shows_its_origin_by_keys_and_mouse(window):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    button = middle(window, number(window, "2.924"))
    popover = window.find_element("id", button.get_attribute("popovertarget"))
    window.execute_script("arguments[0].focus()", button)
    ActionChains(window).send_keys(Keys.ENTER).perform()
    until(window, popover.is_displayed)
    for text in (
        "Greatest inertias: joint 1, b [kg m\u00b2]", "after an erratum", "read from: Table IV, row 1",
        "computed as: max over q of B_ii + k_r^2 I_m", "unit: kg mm^2 -> kg m^2", "errata: E2, E9",
    ):  # fmt: skip
        assert text in popover.text
    screenshot(window, "report_number.png")
    ActionChains(window).send_keys(Keys.ESCAPE).perform()
    until(window, lambda: not popover.is_displayed())
    differing = number(window, ".0333")
    differing.click()
    shown = window.find_element("id", differing.get_attribute("popovertarget"))
    assert shown.text.startswith("Greatest inertias: joint 1, y\ndiffers")
    beside, at = shown.rect, differing.rect
    assert abs(beside["x"] - at["x"]) < 300
    assert abs(beside["y"] - at["y"]) < 300
    ActionChains(window).send_keys(Keys.ESCAPE).perform()


@pytest.mark.slow
def test_what_came_out_is_folded_and_what_did_not_is_not(window):
    table = window.find_element("id", "table-IV")
    words = table.find_elements("css selector", "td.verdict")
    shown = [one for one in words if one.is_displayed()]
    assert len(words) == 24
    assert [one.text for one in shown].count("differs") == 4
    assert len(shown) == 12  # after an erratum, differs, not reproducible
    middle(window, table.find_element("css selector", "summary")).click()
    assert len([one for one in words if one.is_displayed()]) == 24
    table.find_element("css selector", "summary").click()


@pytest.mark.slow
def test_a_line_of_the_map_leads_to_its_table_and_a_link_opens_its_erratum(window):
    from selenium.webdriver.common.keys import Keys

    window.execute_script("window.scrollTo(0, 0)")
    window.find_elements("css selector", ".map a")[1].send_keys(Keys.ENTER)
    top = "return document.getElementById('table-K').getBoundingClientRect().top"
    until(window, lambda: 0 <= window.execute_script(top) < 800)
    entry = window.find_element("id", "erratum-E2")
    assert entry.get_attribute("open") is None
    link = next(one for one in window.find_elements("css selector", "a.erratum-link") if one.is_displayed())
    link.send_keys(Keys.ENTER)
    until(window, lambda: entry.get_attribute("open") is not None)
    assert "B_11 with y and z exchanged" in entry.text
    window.find_element("css selector", ".open-all").send_keys(Keys.ENTER)
    assert all(e.get_attribute("open") for e in window.find_elements("css selector", "details.erratum"))
    assert "proven, FAILS" in window.find_element("id", "erratum-E3").text
    assert "no computation decides it" in window.find_element("id", "erratum-E4").text
    window.find_element("css selector", ".open-all").send_keys(Keys.ENTER)


def test_evidence_is_folded_unless_it_fails(window):
    states = window.execute_script(
        """return [...document.querySelectorAll("#evidence .evidence")].map((e) =>
          [e.querySelector("h3").textContent, e.querySelector(".count").textContent, e.open])"""
    )
    assert states == [
        ["Cross-checks of the models", "it holds", False],
        ["Audit of the runs: energy and inverse dynamics", "0 hold, 1 FAIL", True],
        ["Model spread", "4 lines", False],
        ["Files beside this page", "1, 12 kB", False],
        ["The paper, and the versions used", "", False],
    ]


@pytest.mark.slow
def test_keyboard_reaches_and_plays_the_replay(window):
    from selenium.webdriver.common.keys import Keys

    window.execute_script("document.activeElement.blur(); window.scrollTo(0, 0)")
    window.execute_script("document.querySelector('.skip').focus()")
    window.switch_to.active_element.send_keys(Keys.ENTER)
    until(window, lambda: window.switch_to.active_element.get_attribute("id") == "result")
    window.find_element("id", "start-3d").send_keys(Keys.ENTER)
    started(window)
    until(window, lambda: window.switch_to.active_element.get_attribute("id") == "stage")
    window.execute_script("lwrReplay.setTime(0)")
    window.find_element("id", "stage").send_keys(Keys.ARROW_RIGHT)
    assert window.execute_script("return lwrReplay.time()") == pytest.approx(0.1)
    window.find_element("id", "stage").send_keys(" ")
    assert window.execute_script("return lwrReplay.playing()")
    window.find_element("id", "stage").send_keys(" ")


@pytest.mark.slow
def test_print_shows_everything(window):
    started(window)
    window.execute_script("document.querySelectorAll('details[open]').forEach((e) => { e.open = false; })")
    shown = window.execute_script(
        """window.dispatchEvent(new Event("beforeprint"));
        const still = document.getElementById("print-still"), pen = still.getContext("2d");
        const pixels = pen.getImageData(0, 0, still.width, still.height).data;
        const folded = document.querySelectorAll("details:not([open])").length;
        window.dispatchEvent(new Event("afterprint"));
        return [folded, new Set(pixels).size, document.querySelectorAll("details[open]").length]"""
    )
    assert shown[0] == 0
    assert shown[1] > 50  # shades of an arm with light on it
    assert shown[2] == 0
    window.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        assert window.find_element("css selector", ".pop").value_of_css_property("display") == "block"
    finally:
        window.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    sheet = window.execute_cdp_cmd("Page.printToPDF", {"printBackground": True, "preferCSSPageSize": True})["data"]
    assert base64.b64decode(sheet).startswith(b"%PDF")


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), SCREENS)
def test_no_rule_of_accessibility_is_broken(browser, report_path, width, dark):
    opened(browser, report_path)
    with seen(browser, width, dark):
        browser.execute_script("document.querySelectorAll('details').forEach((e) => { e.open = true; })")
        assert violations(browser) == []
        assert faint_texts(browser) == []
        assert sideways(browser) == 0
        started(browser)
        assert sideways(browser) == 0
        if dark:
            screenshot(browser, f"report_dark_{width}.png")


@pytest.mark.slow
def test_origins_need_no_script(browser, report_path):
    from selenium.webdriver.common.keys import Keys

    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        with screen(browser, **LAPTOP):
            browser.get(report_path.as_uri())
            button = next(one for one in browser.find_elements("css selector", ".ledger .n") if one.text == "2.924")
            button.send_keys(Keys.ENTER)
            popover = browser.find_element("id", button.get_attribute("popovertarget"))
            until(browser, popover.is_displayed)
            assert "after an erratum" in popover.text
    finally:
        browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})


@pytest.mark.slow
def test_hostile_names_stay_text(browser, tmp_path, arm, two_runs):
    with screen(browser, **LAPTOP):
        write_report(tmp_path / "hostile.html", report(arm, two_runs, HOSTILE))
        opened(browser, tmp_path / "hostile.html")
        assert browser.find_element("tag name", "h1").text == "A paper with tables" + HOSTILE
        popovers = browser.execute_script("return [...document.querySelectorAll('.pop')].map((e) => e.textContent)")
        assert HOSTILE in popovers[0]
        started(browser)
        browser.execute_script("lwrReplay.setTime(1)")
        # the page's own still image is the only one
        assert browser.execute_script("return [window.broken, document.images.length]") == [None, 1]
        assert logs(browser)[1] == []


@pytest.mark.slow
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


@pytest.mark.slow
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
