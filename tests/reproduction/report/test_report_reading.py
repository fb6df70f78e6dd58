"""Reading a report in headless Chromium: by mouse, keys and touch, on a phone, on paper, with hostile names in it."""

import base64

import pytest

from lwr_dyn.reproduction.report.page import write_report
from tests.headless import logs, screenshot
from tests.reproduction.report.reported import HOSTILE, report
from tests.viewer.driven import LAPTOP, PHONE, opened, screen, until


@pytest.fixture(scope="module")
def window(browser, report_path):
    with screen(browser, **LAPTOP):
        opened(browser, report_path)
        yield browser


def test_cells_show_their_origin_by_keys_and_mouse(window):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    tip = window.find_element("id", "tip")
    window.execute_script("document.querySelector('.scroll').focus()")
    ActionChains(window).send_keys(Keys.TAB).perform()
    cell = window.switch_to.active_element
    assert cell.get_attribute("data-place") == "joint 1, b [kg m^2]"
    assert cell.get_attribute("aria-describedby") == "tip"
    for text in ("after erratum", "Table IV, row 1", "max over q of B_ii + k_r^2 I_m", "kg mm^2 -> kg m^2"):
        assert text in tip.text
    ActionChains(window).send_keys(Keys.ARROW_DOWN, Keys.ARROW_RIGHT).perform()
    assert window.switch_to.active_element.get_attribute("data-place") == "joint 2, mass"
    screenshot(window, "report_cell.png")
    ActionChains(window).send_keys(Keys.ESCAPE).perform()
    assert not tip.is_displayed()
    ActionChains(window).move_to_element(window.find_elements("css selector", ".cell")[3]).perform()
    assert tip.text.startswith("joint 1, y\ndiffers")


def test_verdicts_are_words_and_shapes(window):
    for word, sign, count in (
        ("reproduced", "reproduced", 8),
        ("after erratum", "after", 4),
        ("differs", "differs", 4),
    ):
        words = window.execute_script(
            """const words = [...document.querySelectorAll(".cell .word")];
            return words.filter((e) => e.textContent === arguments[0]).length""",
            word,
        )
        assert words == len(window.find_elements("css selector", f".cell .sign.{sign}")) == count
    assert [e.text for e in window.find_elements("css selector", ".tile b")] == ["8", "4", "4", "0", "0", "0", "4"]


def test_tiles_lead_from_cell_to_cell(window):
    window.execute_script("window.scrollTo(0, 0)")
    tile, places = window.find_elements("css selector", ".tile")[2], []
    for _ in range(5):
        window.execute_script("arguments[0].click()", tile)
        places.append(window.execute_script("return document.activeElement.dataset.place"))
    assert places == [f"joint {j}, y" for j in (1, 2, 3, 4, 1)]


def test_erratum_opens_from_its_link_and_by_keys(window):
    from selenium.webdriver.common.keys import Keys

    entry = window.find_element("id", "erratum-E2")
    assert entry.get_attribute("open") is None
    window.find_element("css selector", "a.erratum-link").send_keys(Keys.ENTER)
    until(window, lambda: entry.get_attribute("open") is not None)
    assert "B_11 with y and z exchanged" in entry.text
    window.find_element("css selector", ".open-all").send_keys(Keys.ENTER)
    assert all(e.get_attribute("open") for e in window.find_elements("css selector", "details.erratum"))
    assert "proven, FAILS" in window.find_element("id", "erratum-E3").text
    assert "no computation decides it" in window.find_element("id", "erratum-E4").text


def test_keyboard_reaches_and_plays_the_replay(window):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    window.execute_script("lwrReplay.setTime(0); document.activeElement.blur(); window.scrollTo(0, 0)")
    window.find_element("css selector", ".skip").send_keys(Keys.ENTER)
    until(window, lambda: window.switch_to.active_element.get_attribute("id") == "summary")
    order = []
    for _ in range(8):  # tiles without numbers are left out
        window.execute_script("window.focusedBefore = document.activeElement")
        ActionChains(window).send_keys(Keys.TAB).perform()
        until(window, lambda: window.execute_script("return document.activeElement !== window.focusedBefore"))
        order.append(window.execute_script("return document.activeElement.id || document.activeElement.textContent"))
    assert order[:4] == ["8reproduced", "4after erratum", "4differs", "4not reproducible"]
    assert order[4:] == ["Replay", "Figure 2", "stage", "play"]
    window.find_element("id", "stage").send_keys(Keys.ARROW_RIGHT)
    assert window.execute_script("return lwrReplay.time()") == pytest.approx(0.1)
    window.find_element("id", "stage").send_keys(" ")
    assert window.execute_script("return lwrReplay.playing()")
    window.find_element("id", "stage").send_keys(" ")


def test_print_shows_everything(window):
    window.execute_script("document.querySelectorAll('details[open]').forEach((e) => { e.open = false; })")
    shown = window.execute_script(
        """window.dispatchEvent(new Event("beforeprint"));
        const still = document.getElementById("print-still"), pen = still.getContext("2d");
        const pixels = pen.getImageData(0, 0, still.width, still.height).data;
        const folded = document.querySelectorAll("details:not([open]):not(.values)").length;
        const width = lwrReport.charts[0].graph.layout.width;
        window.dispatchEvent(new Event("afterprint"));
        return [folded, new Set(pixels).size, width, document.querySelectorAll("details[open]").length]"""
    )
    assert shown[0] == 0
    assert shown[1] > 50  # shades of an arm with light on it
    assert shown[2] == 680
    assert shown[3] == 0
    sheet = window.execute_cdp_cmd("Page.printToPDF", {"printBackground": True, "preferCSSPageSize": True})["data"]
    assert base64.b64decode(sheet).startswith(b"%PDF")


def test_dark_screen_has_dark_colours(window):
    features = [{"name": "prefers-color-scheme", "value": "dark"}]
    colour = "return getComputedStyle(document.documentElement).backgroundColor"
    light = window.execute_script(colour)
    window.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    try:
        assert window.execute_script(colour) != light
        screenshot(window, "report_dark.png")
    finally:
        window.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_phone_needs_no_sideways_scroll_and_taps_show_the_origin(browser, report_path):
    with screen(browser, **PHONE):
        opened(browser, report_path)
        width, inner = browser.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
        assert width == inner == PHONE["width"]
        browser.find_elements("css selector", ".cell")[1].click()
        tip = browser.find_element("id", "tip")
        assert "Table IV, row 1" in tip.text
        assert tip.rect["x"] >= 0
        assert tip.rect["x"] + tip.rect["width"] <= PHONE["width"]
        browser.execute_script("document.getElementById('plot-errors').scrollIntoView()")
        screenshot(browser, "report_phone.png")
        assert logs(browser)[1] == []


def test_finger_scrolls_over_a_figure_and_a_tap_sets_the_time(browser, report_path):
    with screen(browser, **PHONE):
        opened(browser, report_path)
        x, y, before = browser.execute_script(
            """const plane = document.querySelector("[data-plot=torque] .nsewdrag");
            plane.scrollIntoView({ block: "center" }); window.scrollBy(0, -120);
            const box = plane.getBoundingClientRect();
            return [box.left + box.width / 2, box.top + box.height / 2, window.scrollY]"""
        )

        def touch(kind, *points):
            at = [{"x": x, "y": y - up} for up in points]
            browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})

        touch("touchStart", 0)
        touch("touchEnd")
        assert browser.execute_script("return lwrReplay.time()") == pytest.approx(3.0, abs=0.05)
        browser.execute_script("lwrReplay.setTime(1)")
        touch("touchStart", 0)
        for up in range(20, 180, 20):
            touch("touchMove", up)
        touch("touchEnd")
        until(browser, lambda: browser.execute_script("return window.scrollY") > before + 60)
        assert browser.execute_script("return lwrReplay.time()") == 1


def test_hostile_names_stay_text(browser, tmp_path, arm, two_runs):
    with screen(browser, **LAPTOP):
        write_report(tmp_path / "hostile.html", report(arm, two_runs, HOSTILE))
        opened(browser, tmp_path / "hostile.html")
        assert browser.execute_script("return [window.broken, document.images.length]") == [None, 0]
        assert browser.find_element("tag name", "h1").text == "A paper with tables" + HOSTILE
        browser.execute_script("document.querySelector('.cell').focus()")
        assert HOSTILE in browser.find_element("id", "tip").text
        legend = browser.execute_script("return document.querySelector('.legendtext').textContent")
        assert legend == "joint_1" + HOSTILE
        browser.execute_script("Plotly.Fx.hover(lwrReport.charts[0].graph, [{ curveNumber: 0, pointNumber: 9 }])")
        assert browser.execute_script("return [window.broken, document.images.length]") == [None, 0]
        assert logs(browser)[1] == []
