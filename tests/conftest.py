"""Hypothesis profiles, a browser that has no network, and how tests are spread over workers.

Hypothesis runs a seeded share of its examples here; `scripts/soak.py` runs the full counts.
"""

import gc
import os
import signal
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

from tests.distribution import in_order, scheduler
from tests.examples import SOAK
from tests.headless import QUICK, browser_window

pytest_plugins = ["tests.optional", "tests.share"]
os.environ.setdefault("OMP_NUM_THREADS", "1")  # a worker a core: threads of BLAS would wait for each other, up to 10 s
slow_machine = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile("ci", max_examples=25, deadline=None, derandomize=True, suppress_health_check=slow_machine)
settings.register_profile("soak", max_examples=SOAK, deadline=None, suppress_health_check=slow_machine)
settings.load_profile(os.environ.get("LWR_DYN_HYPOTHESIS", "ci"))


def pytest_configure() -> None:
    """A shell that runs tests in the background has them ignore Ctrl-C; tests that send it would wait for ever."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(hookwrapper=True)
def pytest_collection() -> Iterator[None]:
    """No garbage is looked for among the half million objects that collecting makes, nor later: they all stay."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items) -> None:
    items[:] = in_order(items)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    return scheduler(config, log) if config.getoption("dist") == "load" else None


@pytest.fixture(scope="session", autouse=True)
def kernel_cache(tmp_path_factory) -> Iterator:
    """Kernels that tests compile are kept for the session and all its workers, not in the user's cache."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LWR_DYN_CACHE", str(base / "kernels"))
        patch.setenv("XDG_CACHE_HOME", str(base / "user"))  # of the key that signs them
        yield


@pytest.fixture(scope="session")
def chromium(tmp_path_factory) -> Iterator:
    with browser_window(tmp_path_factory.mktemp("profile"), QUICK) as window:
        yield window


@pytest.fixture(scope="module")
def browser(chromium) -> Iterator:
    """The worker's browser; behind a file of tests it is left empty, as a page goes on drawing when no test looks."""
    yield chromium
    chromium.get("about:blank")


@pytest.fixture
def lwr_dyn_command(capsys):
    """The command as a function: arguments in; exit code, stdout and stderr out."""
    from lwr_dyn.cli.main import main

    def run(*arguments):
        with pytest.raises(SystemExit) as stop:
            main(list(arguments))
        out, err = capsys.readouterr()
        return stop.value.code, out, err

    return run


@pytest.fixture(scope="session")
def arm():
    """The LWR 4+ in its default reading."""
    import lwr_dyn

    return lwr_dyn.load("lwr4plus")


@pytest.fixture(scope="session")
def two_runs(arm):
    """Two short runs of that arm, made without a simulation."""
    from tests.pages.replay.replayed import lagging_run

    return (lagging_run(arm, 0.04, "pd-gravity"), lagging_run(arm, 0.01, "inverse-dynamics"))
