"""Surveys of public arms by `check` and `lint`: no traceback, none over the limit; outcomes are told apart."""

import random
import signal
from pathlib import Path
from types import SimpleNamespace

import pinocchio as pin
import pytest

from scripts import foreign_lint
from scripts.foreign_arms import Done, check_file, has_moving_joint, installed_urdfs, survey, table
from scripts.foreign_lint import LintOutcome

PUBLIC = Path(pin.__file__).parents[4] / "share" / "example-robot-data"
SHARE = 6
ONE_ERROR = '{"findings": [{"severity": "error", "code": "mass-zero"}, {"severity": "note", "code": "density"}]}'
ENDS = {
    "refused": Done(2, "", "lwr-dyn: arm.urdf: tree: two roots; allowed: one root\n", 0.1),
    "crashed": Done(3, "", "Traceback: ValueError: x\n", 0.1),
    "over the limit": Done(-signal.SIGXCPU, "", "", 30.1),
    "fails": Done(1, '{"verdicts": [{"name": "B symmetric", "holds": false}]}', "", 0.1),
    "holds": Done(0, '{"verdicts": []}', "", 0.1),
    "judged": Done(1, ONE_ERROR, "", 0.1),
}


@pytest.mark.slow
def test_a_seeded_share_of_the_public_arms_ends_with_a_verdict_or_one_line(capsys):
    arms = [path for path in installed_urdfs([PUBLIC]) if has_moving_joint(path)]
    outcomes = survey(random.Random(20261122).sample(arms, SHARE), processes=1)
    assert {outcome.kind for outcome in outcomes} <= {"holds", "fails", "refused"}
    assert max(outcome.seconds for outcome in outcomes) < 30.0
    assert len(table(outcomes).splitlines()) > SHARE
    assert len(capsys.readouterr().err.splitlines()) == SHARE


@pytest.mark.parametrize("kind", ENDS)
def test_outcomes_are_told_apart(kind, tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text("<robot", encoding="utf-8")
    worker = SimpleNamespace(run=lambda arguments, limit: ENDS[kind])
    if kind != "judged":
        outcome = check_file(path, worker)
        assert outcome.kind == kind
        assert "lwr-dyn" not in outcome.gist
    if kind not in ("fails", "holds"):
        judged = foreign_lint.linted(path, worker)
        assert judged.kind == kind
        assert judged.found == ({("error", "mass-zero"), ("note", "density")} if kind == "judged" else set())


def test_codes_are_counted_by_file(tmp_path):
    outcomes = [
        LintOutcome(tmp_path, "judged", "", frozenset({("error", "mass-zero")}), 0.1),
        LintOutcome(tmp_path, "judged", "", frozenset({("error", "mass-zero"), ("warning", "density")}), 0.1),
        LintOutcome(tmp_path, "crashed", "Traceback: x", frozenset(), 0.1),
    ]
    lines = foreign_lint.table(outcomes).splitlines()
    assert lines[:3] == ["2 judged, 1 crashed", "files with errors: 2", "files with warnings: 1"]
    assert "| mass-zero | 2 | 0 | 0 |" in lines
    assert lines[-1].startswith("crashed | ")


@pytest.mark.slow
def test_broken_files_are_judged_too(tmp_path):
    for name, text in (("cut.urdf", "<robot><link"), ("empty.urdf", "")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    outcomes = foreign_lint.survey(sorted(tmp_path.glob("*.urdf")), processes=1)
    assert [outcome.found for outcome in outcomes] == [{("error", "xml-syntax")}] * 2
