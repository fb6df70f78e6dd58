"""An arm and two runs of it."""

import pytest

import lwr_dyn
from lwr_dyn.reproduction.report.page import write_report
from tests.viewer.replayed import lagging_run
from tests.viewer.reported import report


@pytest.fixture(scope="session")
def arm():
    return lwr_dyn.load("lwr4plus")


@pytest.fixture(scope="session")
def two_runs(arm):
    return (lagging_run(arm, 0.04, "pd-gravity"), lagging_run(arm, 0.01, "inverse-dynamics"))


@pytest.fixture(scope="session")
def report_content(arm, two_runs):
    return report(arm, two_runs)


@pytest.fixture(scope="session")
def report_path(tmp_path_factory, report_content):
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(path, report_content)
    return path
