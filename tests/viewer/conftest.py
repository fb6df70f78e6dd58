"""An arm, two runs of it, and a browser that has no network."""

from collections.abc import Iterator

import pytest
from headless import FLAGS, browser_programs
from replayed import lagging_run

import lwr_dyn


@pytest.fixture(scope="session")
def arm():
    return lwr_dyn.load("lwr4plus")


@pytest.fixture(scope="session")
def two_runs(arm):
    return (lagging_run(arm, 0.04, "pd-gravity"), lagging_run(arm, 0.01, "inverse-dynamics"))


@pytest.fixture(scope="session")
def browser(tmp_path_factory) -> Iterator:
    chromium, driver = browser_programs()
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    profile = tmp_path_factory.mktemp("profile")
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    window = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    try:
        yield window
    finally:
        window.quit()
