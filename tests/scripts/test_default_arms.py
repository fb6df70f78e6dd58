"""A seeded share of the public arms through the commands without an option; outcomes are told apart."""

import json
import random
import signal

import pytest

from scripts import default_arms
from scripts.default_arms import COMMANDS, Done, ListedArm, judged, of_compare, of_gains, of_simulate, of_sweep, of_tune

SHARE = {"simulate": 3, "compare": 1, "gains": 1, "study": 1}
"""Arms of each command: a study takes ten seconds."""


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
@pytest.mark.parametrize("command", COMMANDS)
def test_a_seeded_share_runs_inside_its_limits_or_says_why_not(command, capsys):
    arms = default_arms.listed_arms()
    assert len(arms) == 40
    here, share = [arm for arm in arms if arm.path.is_file()], SHARE[command]
    outcomes = default_arms.survey(random.Random(20261126).sample(here, share), 1, command)
    assert {one.kind for one in outcomes} <= {"ran", "refused"}
    assert "ran" in {one.kind for one in outcomes}
    assert len(default_arms.table(outcomes).splitlines()) == share + 2
    assert default_arms.words(arms, outcomes).startswith(f"{share} of 40 arms here: ")
    assert len(capsys.readouterr().err.splitlines()) == share


@pytest.mark.parametrize("kind", ENDS)
def test_outcomes_are_told_apart(kind):
    assert judged(ENDS[kind], of_simulate).kind == kind


def compared(*runs, failures=()):
    rows = [{"typed": law, "unstable": cut, "metrics": {"within_limits": within}} for law, cut, within in runs]
    return of_compare({"runs": rows, "failures": list(failures)})


def test_a_comparison_is_judged_by_its_worst_run_unknown_limits_are_kept_and_a_tip_is_passed_on(tmp_path):
    left_out = ["robust: left out: at 1000 Hz it is unstable"]
    assert compared(("pid", False, True), ("adaptive", False, None), failures=left_out).kind == "ran"
    found = compared(("pid", False, True), ("robust", True, None), ("adaptive", False, False))
    assert (found.kind, found.gist) == ("outside its limits", "3 laws, 0 left out; outside: robust, adaptive")
    assert compared(("pid", False, True), failures=["robust: the simulation diverges"]).kind == "diverged"
    assert compared(failures=left_out).kind == "refused"
    found = judged(Done(0, record(None), "", 1.0), of_simulate)
    assert (found.kind, found.gist, found.tip_mm) == ("ran", "pid, 2 steps a sample, move", 1.5)
    assert ListedArm(tmp_path, "hand").words == (str(tmp_path), "--tip", "hand")
    assert ListedArm(tmp_path, None).words == (str(tmp_path),)


@pytest.mark.parametrize(("value", "kind"), [(3.0, "ran"), (None, "crashed"), (0.0, "crashed")])
def test_gains_are_numbers_above_0(value, kind):
    record = {"joints": [{"Kp": 1.0, "Kd": value}], "sampled": {"pid": {"holds": True}, "pd-gravity": {"holds": False}}}
    found = of_gains(record)
    assert (found.kind, found.gist) == (kind, "1 joints; hold at 1000 Hz: pid")


def test_a_study_is_judged_by_its_events_and_gains_that_are_found_by_the_bound():
    for event, complete, kind in (("simulated", True, "ran"), ("torque cut", True, "outside its limits"),
                                  ("diverged", True, "diverged"), ("simulated", False, "diverged")):  # fmt: skip
        found = {"pid": {"events": {event: {"count": 1}}}}
        assert of_sweep({"summary": {"controllers": found}, "complete": complete, "runs": 8}).kind == kind
    record = {"controller": "pid", "found": {"controller.omega_n": 20.0}}
    for check, kind in (({"keeps_bound": True}, "ran"), ({"keeps_bound": False}, "outside its limits"),
                        (None, "outside its limits")):  # fmt: skip
        found = of_tune({**record, "check": check})
        assert found.kind == kind
        assert check is None or found.gist == "pid: omega_n 20"
