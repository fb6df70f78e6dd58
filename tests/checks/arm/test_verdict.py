"""Verdicts: the side on which a bound lies, and what a report says of those that fail."""

import pytest

from lwr_dyn.checks.arm.model_laws import Verdict
from lwr_dyn.checks.arm.run_checks import CheckReport

LOW, EQUAL, HIGH = (Verdict(f"v{x:g}", x, 1.0, "N m") for x in (0.5, 1.0, 2.0))
ABOVE = Verdict("smallest moment", 1.0, 1.0, "", "above")


def test_at_most_includes_the_tolerance_and_above_does_not():
    assert [v.holds for v in (LOW, EQUAL, HIGH, ABOVE)] == [True, True, False, False]
    assert Verdict("x", 1.5, 1.0, "", "above").holds


@pytest.mark.parametrize(
    ("verdicts", "not_judged", "holds", "summary"),
    [
        ((LOW, EQUAL), (), True, "all 2 checks hold"),
        ((LOW, HIGH), ("limits: none",), False, "1 of 2 checks fails, 1 not judged"),
        ((LOW, HIGH, ABOVE), (), False, "2 of 3 checks fail"),
    ],
)
def test_a_report_counts(verdicts, not_judged, holds, summary):
    report = CheckReport("arm", "printed", verdicts, not_judged=not_judged)
    assert (report.holds, report.summary()) == (holds, summary)
    assert report.document.title == f"arm, reading printed: {summary}"


def test_the_table_of_a_page_has_what_fails_first():
    report = CheckReport("arm", "printed", (LOW, HIGH, EQUAL), not_judged=("limits",))
    table, left = report.document.sections[0].parts
    assert [row[0] for row in table.cells] == ["v2", "v0.5", "v1"]
    assert left.lines == ("not judged: limits",)
    assert report.table().text().splitlines()[0] == "arm, reading printed"
    assert report.table().cells[1] == ("v2", "2", "at most", "1", "N m", "FAILS")
