"""`lwr-dyn tune`: what is typed reaches the search, a known optimum through real rollouts, bad input in one line."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.cli.tune import evaluator
from lwr_dyn.foundation.document import Document
from lwr_dyn.studies.sweep.gain_search import SearchedGain, gain_aim
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.tune import SearchSize

STUDY = """
robot = "lwr4plus"
reading = "physical"
controllers = ["inverse-dynamics", "inverse-dynamics:omega-n=80"]
[task]
name = "point-to-point"
from-deg = [0, 30, 0, -60, 0, 30, 0]
to-deg = [5, 35, 0, -60, 0, 30, 0]
duration = 0.3
[metrics]
quantiles = [0.95]
[[parameter]]
path = "payload.mass"
low = 2
high = 5
[[parameter]]
path = "payload.known"
value = 0
[[parameter]]
path = "loop.delay"
values = [0, 1]
"""
SMALL = ("--runs", "8", "--population", "6", "--generations", "6", "--check-runs", "40", "--front", "0")
FOUND = {"keeps_bound": True, "document": Document("", "tuned", ())}


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "moves.toml"
    path.write_text(STUDY, encoding="utf-8")
    return str(path)


@pytest.fixture
def tuned(study, printed):
    return lambda *words: printed("tune", study, *SMALL, *words)


@pytest.mark.parametrize(
    ("words", "law", "gains", "options", "code"),
    [
        ((), "inverse-dynamics", [("omega_n", 10.0, 250.0), ("xi", 0.4, 2.0)], ("tip_max:0.99", 1.0, SearchSize()), 0),
        (("--law", "inverse-dynamics:omega-n=80", "--jobs", "2", "--seed", "5", *SMALL, "--aim", "tip_q95:0.9",
          "--torque-share", "0.5"), "inverse-dynamics:omega-n=80", [("omega_n", 16.0, 400.0), ("xi", 0.4, 2.0)],
         ("tip_q95:0.9", 0.5, SearchSize(8, 6, 6, 40, 0, 5)), 1),
        (("--gain", "omega-n=5:9"), "inverse-dynamics", [("omega_n", 5.0, 9.0)],
         ("tip_max:0.99", 1.0, SearchSize()), 0),
    ],
)  # fmt: skip
def test_what_is_typed_reaches_the_search(asked, lwr_dyn_command, study, words, law, gains, options, code):
    """The gains as given are those of the law and of parameters that are fixed; exit 1 where no bound is kept."""
    searched = asked("lwr_dyn.cli.tune.tune", SimpleNamespace(**FOUND | {"keeps_bound": code == 0}))
    judged = asked("lwr_dyn.cli.tune.evaluator", "evaluate")
    got, out, _ = lwr_dyn_command("tune", study, *words)
    assert (got, out.splitlines()[-1]) == (code, "tuned")
    (read, text, asked_for, evaluate, given), more = searched[0]
    aim, bound, size = options
    assert (read.name, text, evaluate) == ("moves", law, "evaluate")
    assert asked_for == tuple(SearchedGain(f"controller.{name}", low, up) for name, low, up in gains)
    usual = {"controller.omega_n": 80.0 if "80" in law else 50.0, "controller.xi": 1.0, "payload.known": 0.0}
    assert given == usual
    assert {name: more[name] for name in ("aim", "bound", "size")} == {
        "aim": gain_aim(aim, [0.95]), "bound": bound, "size": size,
    }  # fmt: skip
    assert judged[0][0][1:] == (law, 2 if "--jobs" in words else 1)


@pytest.mark.slow
def test_a_law_is_best_that_knows_its_whole_load(study, recorded):
    record = recorded("tune", study, *SMALL, "--gain", "payload.known=0.5:1", "--aim", "tip_q95:0.9")
    assert record["found"]["payload.known"] > 0.97
    assert record["given"] == {"payload.known": 0.0}
    assert record["check"]["ratio"]["high"] < 0.1
    assert record["check"]["verdict"] == "the found gains are better"


@pytest.mark.slow
def test_it_is_the_same_for_any_number_of_threads(tuned):
    words = ("--gain", "omega-n=20:90", "--gain", "xi=0.6:1.2")
    out = tuned(*words)
    assert out == tuned(*words, "--jobs", "2")
    assert "on 40 runs that the search has not seen, intervals of 95 %" in out
    assert "of 8 runs, the 99 % quantile is the worst" in out


@pytest.mark.slow
def test_a_bound_that_no_candidate_keeps_is_said(study, lwr_dyn_command):
    code, out, err = lwr_dyn_command("tune", study, *SMALL, "--gain", "omega-n=20:90", "--torque-share", "0.01")
    assert (code, err) == (1, "")
    assert "no candidate keeps the bound: the one that misses it by the least is shown" in out


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("--law", "pid"), "no controller of moves named 'pid'"),
        (("--gain", "omega=1:2"), "no gain of inverse-dynamics named 'omega' (did you mean omega_n?)"),
        (("--gain", "feedforward=0:1"), "no gain of inverse-dynamics named 'feedforward'"),
        (("--gain", "payload.mas=1:2"), "no parameter path named 'payload.mas' (did you mean payload.mass?)"),
        (("--gain", "payload.known=0:2"), "bounds of payload.known: 2"),
        (("--gain", "payload.known=-1:1"), "bounds of payload.known: -1"),
        (("--gain", "arm.mass=0.9:1.1"), "a path of one number"),
        (("--gain", "task.duration=1:2"), "a path of one number"),
        (("--gain", "omega-n=9:2"), "low < high"),
        (("--gain", "omega-n=5:9", "--gain", "omega-n=5:9"), "controller.omega_n twice"),
        (("--gain", "omega-n=-5:9"), "omega_n"),
        (("--aim", "tip_max"), "METRIC:SHARE"),
        (("--aim", "tip_q99:0.9"), "no metric named 'tip_q99'"),
        (("--torque-share", "0"), "above 0"),
        (("--check-runs", "2"), "check: 2; allowed: a whole number from 8"),
        (("--jobs", "0"), "'--jobs': 0 is not in the range x>=1"),
        (("--threads", "2"), "lwr-dyn: --threads is now --jobs"),
    ],
)
def test_bad_input_is_one_line(words, fault, study, refused):
    assert fault in refused("tune", study, *SMALL, *words)


def test_what_is_no_study_is_refused(refused, tmp_path):
    for target in ("lwr4plus", str(tmp_path / "none.toml")):
        refused("tune", target)
    assert not list(Path(tmp_path).iterdir())


@pytest.mark.slow
def test_the_torque_use_is_of_the_limits_of_each_run(tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text(STUDY + '[[parameter]]\npath = "limits.torque.all"\nvalues = [0.5, 1.0]\n', encoding="utf-8")
    study = read_study(path)
    evaluate = evaluator(study, "inverse-dynamics")
    values = {name: np.repeat(rows[:1], 2, axis=0) for name, rows in study.values(0, 1).items()}
    use = evaluate(values | {"limits.torque.all": np.array([0.5, 1.0])})["torque_use"]
    assert use[0] == pytest.approx(2.0 * use[1], rel=1e-3)
