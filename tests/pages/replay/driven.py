"""Driving a report in a browser."""

from contextlib import contextmanager

from tests.headless import logs, waiting

PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
LAPTOP = {"width": 1280, "height": 800, "deviceScaleFactor": 1, "mobile": False}


def until(browser, holds):
    waiting(browser, 12).until(lambda _: holds())


def opened(browser, path):
    """Open a report and wait until all of it is drawn; what was logged before is dropped."""
    browser.get("about:blank")
    logs(browser)
    browser.get(path.as_uri())
    until(browser, lambda: browser.execute_script("return !!(window.lwrReport && lwrReport.ready)"))


def traffic(browser, *inside):
    """What was asked for beside data (and other kinds of address `inside`) since it was last looked at, and said."""
    sent, said = logs(browser)
    return [address for address in sent if not address.startswith(("data:", *inside))], said


@contextmanager
def without_webgl(browser):
    """Pages opened here get no context of WebGL."""
    blind = """const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
          return /webgl/.test(kind) ? null : get.call(this, kind, ...rest); };"""
    added = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": blind})
    try:
        yield
    finally:
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", {"identifier": added["identifier"]})


@contextmanager
def screen(browser, **metrics):
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": metrics["mobile"]})
    try:
        yield browser
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})


def started(browser):
    """Start the 3D view of the report that is open, if it has not been, and wait for it."""
    if not browser.execute_script("return !!window.lwrReplay"):
        browser.execute_script("document.getElementById('start-3d').click()")
        until(browser, lambda: browser.execute_script("return !!(window.lwrReplay && lwrReplay.ready)"))


def number(window, text):
    """The first number of this print that is in sight."""
    return next(
        one for one in window.find_elements("css selector", ".ledger .n") if one.is_displayed() and one.text == text
    )


def middle(window, element):
    window.execute_script("arguments[0].scrollIntoView({ block: 'center' })", element)
    return element
