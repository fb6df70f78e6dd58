"""Hypothesis profiles, and a browser that has no network.

Hypothesis runs a seeded share of its examples here; `scripts/soak.py` runs the full counts.
"""

import os
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

from tests.examples import SOAK
from tests.headless import FLAGS, browser_programs

slow_machine = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile("ci", max_examples=25, deadline=None, derandomize=True, suppress_health_check=slow_machine)
settings.register_profile("soak", max_examples=SOAK, deadline=None, suppress_health_check=slow_machine)
settings.load_profile(os.environ.get("LWR_DYN_HYPOTHESIS", "ci"))


@pytest.fixture(scope="session", autouse=True)
def kernel_cache(tmp_path_factory) -> Iterator:
    """Kernels that tests compile are kept for the session, not in the user's cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LWR_DYN_CACHE", str(tmp_path_factory.mktemp("kernels")))
        yield


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
