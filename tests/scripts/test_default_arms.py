"""A seeded share of the public arms through `simulate` without an option; outcomes are told apart."""

import json
import random
import signal

import pytest

from scripts.default_arms import Done, ListedArm, judged, listed_arms, survey, table, words

SHARE = 3


def record(within):
    metrics = {"within_limits": within, "tip_max_mm": 1.5}
    meta = {"controller": {"name": "pid"}, "options": {"substeps": 2}, "note": {"task": "move"}}
    return json.dumps({"meta": meta, "metrics": metrics})


ENDS = {
    "ran": Done(0, record(True), "", 1.0),
    "outside its limits": Done(0, record(False), "", 1.0),
    "refused": Done(2, "", "note: the arm ends at x\nlwr-dyn: a: masses not given; needed for dynamics\n", 0.1),
    "diverged": Done(1, "", "lwr-dyn: the simulation diverges at t = 1 s: joint_1: nan\n", 0.1),
    "over the limit": Done(-signal.SIGXCPU, "", "", 300.0),
    "crashed": Done(3, "", "Traceback: ValueError: x\n", 0.1),
}


@pytest.mark.slow
def test_a_seeded_share_runs_inside_its_limits_or_says_why_not(capsys):
    arms = listed_arms()
    assert len(arms) == 40
    here = [arm for arm in arms if arm.path.is_file()]
    outcomes = survey(random.Random(20261126).sample(here, SHARE), processes=1)
    assert {one.kind for one in outcomes} <= {"ran", "refused"}
    assert "ran" in {one.kind for one in outcomes}
    assert len(table(outcomes).splitlines()) == SHARE + 2
    assert words(arms, outcomes).startswith(f"{SHARE} of 40 arms here: ")
    assert len(capsys.readouterr().err.splitlines()) == SHARE


@pytest.mark.parametrize("kind", ENDS)
def test_outcomes_are_told_apart(kind):
    assert judged(ENDS[kind])[0] == kind


def test_unknown_limits_count_as_kept_and_a_tip_is_passed_on(tmp_path):
    assert judged(Done(0, record(None), "", 1.0)) == ("ran", "pid, 2 steps a sample, move", 1.5)
    assert ListedArm(tmp_path, "hand").words == (str(tmp_path), "--tip", "hand")
    assert ListedArm(tmp_path, None).words == (str(tmp_path),)
