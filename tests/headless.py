"""Chromium without a screen and without a network."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
    "--window-size=1440,900",
)
QUICK = ("--disable-gpu-compositing", "--webgl-antialiasing-mode=none")
"""For tests: without a GPU a frame takes a third of the time so; pictures for people are taken without these."""
OF_QUICK = "GPU stall due to ReadPixels"
"""What the driver says of pages with WebGL under `QUICK`, as each frame is read back; no page of ours causes it."""


def browser_programs() -> tuple[str, str]:
    """Chromium and its driver as installed; absent they fail the run in CI and skip it elsewhere."""
    found = shutil.which("chromium") or shutil.which("chromium-browser"), shutil.which("chromedriver")
    if None not in found:
        return found
    reason = "chromium and chromedriver are not installed (Debian: chromium, chromium-driver)"
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


@contextmanager
def browser_window(profile: Path, more_flags: tuple[str, ...] = ()) -> Iterator:
    """A Chromium without a network whose console and requests are logged; `profile` is a folder of its own."""
    chromium, driver = browser_programs()
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in (*FLAGS, *more_flags, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    window = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    window.set_script_timeout(120)  # rules of axe on a long page, on a machine that does other things
    try:
        yield window
    finally:
        window.quit()


def waiting(browser, seconds: float):
    """Selenium's wait, which asks each 20 ms instead of twice a second."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(browser, seconds, poll_frequency=0.02)


@contextmanager
def small_window(browser) -> Iterator[None]:
    """A window in which little is drawn: drawing without a GPU takes longer than all else that a page does."""
    size = browser.get_window_size()
    browser.set_window_size(500, 200)
    try:
        yield
    finally:
        browser.set_window_size(size["width"], size["height"])


def opened(browser, address: str) -> None:
    """Open a page and wait until its player stands; what was logged before is dropped."""
    browser.get("about:blank")
    logs(browser)
    browser.get(address)
    waiting(browser, 60).until(lambda w: w.execute_script("return !!(window.lwrReplay && lwrReplay.ready)"))


def logs(browser) -> tuple[list[str], list[str]]:
    """(addresses requested, the messages of the console) since the last call."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    sent += [m["params"]["url"] for m in messages if m["method"] == "Network.webSocketCreated"]
    said = [f"{entry['level']}: {entry['message']}" for entry in browser.get_log("browser")]
    return sent, [message for message in said if OF_QUICK not in message]


def screenshot(browser, name: str) -> None:
    """Keep what is on the page for people to look at, in the folder LWR_DYN_SCREENSHOTS."""
    folder = os.environ.get("LWR_DYN_SCREENSHOTS")
    if folder:
        browser.save_screenshot(str(Path(folder) / name))
