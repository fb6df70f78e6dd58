"""A report with every part, and its page."""

import pytest

from lwr_dyn.reproduction.report.page import write_report
from tests.reproduction.report.reported import report


@pytest.fixture(scope="session")
def report_content(arm, two_runs):
    return report(arm, two_runs)


@pytest.fixture(scope="session")
def report_path(tmp_path_factory, report_content):
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(path, report_content)
    return path
