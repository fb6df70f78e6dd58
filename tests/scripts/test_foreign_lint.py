"""The survey of `lint` over public URDFs: outcomes are told apart, codes are counted by file."""

import signal
from types import SimpleNamespace

import pytest

from scripts.foreign_arms import Done
from scripts.foreign_lint import LintOutcome, linted, survey, table

ONE_ERROR = '{"findings": [{"severity": "error", "code": "mass-zero"}, {"severity": "note", "code": "density"}]}'
ENDS = {
    "refused": Done(2, "", "lwr-dyn: arm.urdf: not a file; allowed: a file\n", 0.1),
    "crashed": Done(3, "", "Traceback: ValueError: x\n", 0.1),
    "over the limit": Done(-signal.SIGXCPU, "", "", 30.1),
    "judged": Done(1, ONE_ERROR, "", 0.1),
}


@pytest.mark.parametrize("kind", ENDS)
def test_outcomes_are_told_apart(kind, tmp_path):
    worker = SimpleNamespace(run=lambda arguments, limit: ENDS[kind])
    outcome = linted(tmp_path / "arm.urdf", worker)
    assert outcome.kind == kind
    assert outcome.found == (frozenset({("error", "mass-zero"), ("note", "density")}) if kind == "judged" else set())


def test_codes_are_counted_by_file(tmp_path):
    outcomes = [
        LintOutcome(tmp_path, "judged", "", frozenset({("error", "mass-zero")}), 0.1),
        LintOutcome(tmp_path, "judged", "", frozenset({("error", "mass-zero"), ("warning", "density")}), 0.1),
        LintOutcome(tmp_path, "crashed", "Traceback: x", frozenset(), 0.1),
    ]
    lines = table(outcomes).splitlines()
    assert lines[:3] == ["2 judged, 1 crashed", "files with errors: 2", "files with warnings: 1"]
    assert "| mass-zero | 2 | 0 | 0 |" in lines
    assert lines[-1].startswith("crashed | ")


@pytest.mark.slow
def test_broken_files_are_judged_too(tmp_path):
    (tmp_path / "cut.urdf").write_text("<robot><link", encoding="utf-8")
    (tmp_path / "empty.urdf").write_text("", encoding="utf-8")
    outcomes = survey(sorted(tmp_path.glob("*.urdf")), processes=1)
    assert [outcome.found for outcome in outcomes] == [{("error", "xml-syntax")}] * 2
