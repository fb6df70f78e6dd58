"""Sweeps: the same bytes whatever computes them and however often they are killed; what fails is named."""

import errno
import json
import os
import random
import re
import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.rollouts import rollouts
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.rollout_arguments import rollout_arguments
from lwr_dyn.studies.sweep.running import sweep_folder
from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.running.sweep_folder import OtherSweepError, SweepResults
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop
from lwr_dyn.studies.sweep.study_template import study_template
from lwr_dyn.studies.sweep.sweep_study import arm_of_study, controller_of_study, references_of_study
from tests.json_schemas import faults
from tests.studies.sweep.small import LAW, OWN, contents, small_study


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A study and the folder of its sweep."""
    folder = tmp_path_factory.mktemp("sweep")
    study = small_study(folder)
    done = sweep(study, folder / "out", threads=1)
    assert (done.made, done.kept, done.is_complete) == ({OWN: 12}, {OWN: 0}, True)
    return study, folder / "out"


@pytest.mark.slow
def test_the_files_hold_what_rollouts_of_all_runs_give(undisturbed):
    study, folder = undisturbed
    found = SweepResults.load(folder).controllers[OWN]
    values = study.values(0, study.runs)
    whole = rollouts(
        arm_of_study(study), controller_of_study(study, OWN), references_of_study(study),
        **rollout_arguments(study, OWN, values),
    )  # fmt: skip
    assert found.run.tolist() == list(range(24))
    for name, column in whole.metrics.items():
        np.testing.assert_array_equal(found.metrics[name], column, name)
    for path, column in values.items():
        np.testing.assert_array_equal(found.values[path], column, path)
    assert (folder / "study.toml").read_text() == study.text
    assert len(np.unique(found.metrics["tip_rms"])) == 24


@pytest.mark.slow
def test_threads_and_the_order_of_chunks_change_no_byte(undisturbed, tmp_path):
    study, folder = undisturbed
    sweep(study, tmp_path / "out", threads=3)
    assert contents(tmp_path / "out") == contents(folder)


def killed(study, folder, wait, threads=2):
    """The sweep in a fork, killed after that many files of chunks."""
    child = os.fork()
    if not child:
        try:
            os.dup2(os.open(os.devnull, os.O_RDWR), 2)
            sweep(study, folder, threads=threads)
        finally:
            os._exit(0)
    while len(list(folder.rglob("*.parquet"))) < wait and os.waitpid(child, os.WNOHANG) == (0, 0):
        time.sleep(0.001)
    time.sleep(random.Random(wait).uniform(0.0, 0.02))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_a_sweep_that_was_killed_goes_on_to_the_same_bytes(seed, undisturbed, tmp_path):
    study, folder = undisturbed
    killed(study, tmp_path / "out", random.Random(seed).randrange(2, 9))
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "out").rglob("chunk*.parquet")}
    assert 0 < len(before) < 12
    done = sweep(study, tmp_path / "out", threads=1)
    assert (done.kept[OWN], done.made[OWN]) == (len(before), 12 - len(before))
    assert {p: p.stat().st_mtime_ns for p in before} == before
    assert contents(tmp_path / "out") == contents(folder)


@pytest.mark.slow
def test_a_finished_sweep_is_extended_to_the_bytes_of_one_of_all_runs(undisturbed, tmp_path):
    study, folder = undisturbed
    few = replace(study, runs=5, text="# of five runs")
    assert sweep(few, tmp_path / "out", threads=1).made == {OWN: 3}
    first = SweepResults.load(tmp_path / "out").controllers[OWN]
    full = {p: p.stat().st_mtime_ns for p in (tmp_path / "out").rglob("chunk-0000[01].parquet")}
    done = sweep(study, tmp_path / "out", threads=2)
    assert (done.kept, done.made, done.refused) == ({OWN: 2}, {OWN: 10}, ())  # the third had one run of two
    assert {p: p.stat().st_mtime_ns for p in full} == full
    assert contents(tmp_path / "out") == contents(folder)
    for name, column in first.metrics.items():
        np.testing.assert_array_equal(SweepResults.load(tmp_path / "out").controllers[OWN].metrics[name][:5], column)


@pytest.mark.slow
def test_the_command_extends_a_sweep_with_the_worst_of_all_its_runs(tmp_path, lwr_dyn_command):
    small_study(tmp_path)
    line = ("sweep", str(tmp_path / "small.toml"), "--jobs", "1", "--out")
    lwr_dyn_command(*line, str(tmp_path / "out"), "--runs", "4")
    before = {path.name for path in (tmp_path / "out" / "worst").iterdir()}
    for out in ("out", "once"):
        code, said, err = lwr_dyn_command(*line, str(tmp_path / out), "--runs", "9", "--json")
        assert (code, json.loads(said)["runs"]) == (0, 9), err
    found, wanted = contents(tmp_path / "out"), contents(tmp_path / "once")
    assert found.keys() == wanted.keys()
    assert {name for name in found if found[name] != wanted[name] and not name.endswith(".npz")} == set()
    assert before - {Path(name).name for name in wanted}  # a run of the few that is none of the worst of all
    code, _, err = lwr_dyn_command(*line, str(tmp_path / "out"), "--runs", "8")
    assert (code, err.count("\n")) == (2, 1)
    assert "another number of runs: 9, here 8; allowed: as many or more, or another folder" in err


@pytest.mark.slow
def test_a_sweep_as_the_template_draws_it_is_extended_to_the_bytes_of_one_of_all_runs(undisturbed, tmp_path):
    (tmp_path / "new.toml").write_text(study_template("new.toml", "new"))
    study = replace(undisturbed[0], method=read_study(tmp_path / "new.toml").method, runs=7)
    few = replace(study, runs=3)
    sweep(few, tmp_path / "out", threads=1)
    for runs in (4, 7):
        sweep(replace(study, runs=runs), tmp_path / "out", threads=1)
    sweep(study, tmp_path / "once", threads=1)
    assert contents(tmp_path / "out") == contents(tmp_path / "once")
    with pytest.raises(OtherSweepError, match="another study"):
        sweep(replace(study, seed=6), tmp_path / "out")


@pytest.mark.slow
def test_a_full_disk_ends_in_one_line_and_what_is_finished_stays(undisturbed, tmp_path, monkeypatch):
    study, folder = undisturbed
    left = 7
    fsync = os.fsync

    def full(handle):
        nonlocal left
        left -= 1
        if left < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(handle)

    monkeypatch.setattr(sweep_folder.os, "fsync", full)
    with pytest.raises(
        FileAccessError, match="no space left on device; allowed: more room: all finished chunks are kept"
    ):
        sweep(study, tmp_path / "out", threads=2)
    monkeypatch.undo()
    before = contents(tmp_path / "out")
    assert 0 < len(before) < len(contents(folder))
    assert before.items() <= contents(folder).items()
    sweep(study, tmp_path / "out", threads=2)
    assert contents(tmp_path / "out") == contents(folder)


@pytest.mark.slow
def test_the_folder_of_another_study_is_refused_before_anything_is_computed(undisturbed, monkeypatch):
    study, folder = undisturbed
    before = contents(folder)
    monkeypatch.setattr(SweepWorkshop, "runs", lambda *_: pytest.fail("runs are made"))
    others = [({"seed": 6}, "study"), ({"seed": 6, "runs": 48}, "study"), ({"controllers": ("pid",)}, "study")]
    for change, what in (*others, ({"runs": 12}, "number of runs: 24, here 12; allowed: as many or more, or another")):
        with pytest.raises(OtherSweepError, match=f"another {what}"):
            sweep(replace(study, **change), folder)
    for threads in (0, 10**6):
        with pytest.raises(OptionError, match="threads"):
            sweep(study, folder, threads=threads)
    assert contents(folder) == before


@pytest.mark.slow
def test_a_law_in_a_file_is_swept_by_processes_and_agrees_with_the_kernel(undisturbed, tmp_path):
    study = replace(small_study(tmp_path, "mine.py", mine=LAW), runs=3, chunk=64)
    costs = []
    done = sweep(study, tmp_path / "out", threads=1, state=costs.append)
    assert (done.made, done.failures) == ({"mine.py": 2}, {"mine.py": {}})
    found = SweepResults.load(tmp_path / "out").controllers["mine.py"]
    kernel = SweepResults.load(undisturbed[1]).controllers[OWN]
    assert found.simulated.all()
    for path, column in found.values.items():
        np.testing.assert_array_equal(column, kernel.values[path][:3])
    for name, column in found.metrics.items():
        np.testing.assert_allclose(column, kernel.metrics[name][:3], rtol=1e-9, atol=1e-11, err_msg=name)
    assert "simulate, in processes" in costs[0].table().text()
    assert costs[0].controllers[0].measured == 1


FAULTY = LAW.replace(
    "    def controller", "    load = sum(b.mass for b in arm.chain.bodies) - TOTAL\n    def controller"
).replace("        return", "        if 1.2 < load < 1.5: 1 / 0\n        return")
"""Of the first four runs it fails in number 2 alone, whose known load is 1.3 kg."""


@pytest.mark.slow
def test_a_chunk_whose_controller_fails_is_named_and_the_rest_is_made(tmp_path, lwr_dyn_command):
    total = sum(body.mass for body in lwr_dyn.load("lwr4plus", "physical").chain.bodies)
    small_study(tmp_path, OWN, "mine.py", mine=FAULTY.replace("TOTAL", repr(total)))
    line = ("sweep", str(tmp_path / "small.toml"), "--out", str(tmp_path / "out"), "--runs", "4", "--jobs", "1")
    code, out, err = lwr_dyn_command(*line)
    said = f"runs the Python file {tmp_path / 'mine.py'}, which the study names\n"
    assert (code, err) == (1, said)
    assert re.search(r"about \d+ s on 1 worker", out)
    assert "made 5 chunks" in out
    why = f"runs 2 to 2: run 2: {tmp_path}/mine.py: line 6: ZeroDivisionError: division by zero; allowed: a controller"
    assert f"FAILED: mine.py, chunk 2, {why}" in out
    results = SweepResults.load(tmp_path / "out")
    assert results.missing == {OWN: (), "mine.py": (2,)}
    assert results.failures["mine.py"][2].startswith(why)
    assert results.controllers["mine.py"].run.tolist() == [0, 1, 3]
    first = out
    code, out, err = lwr_dyn_command(*line, "--json")
    record = json.loads(out)
    assert (code, faults("sweep", record), record["complete"]) == (1, [], False)
    assert [(each["made"], each["kept"]) for each in record["controllers"]] == [(0, 2), (0, 3)]
    assert [each["chunk"] for each in record["controllers"][1]["failures"]] == [2]
    assert err.removeprefix(said).startswith("Cost\n")
    assert record["summary"]["controllers"]["mine.py"]["runs"] == 3
    for path in (record["report"], *record["worst"]):
        assert f"wrote {path}\n" in first
        assert Path(path).is_file()
    assert len(record["worst"]) == 6
    assert Run.load(record["worst"][-1]).meta["controller"]["name"] == "mine.py"


BAD = [
    (("--runs", "0"), "runs: 0; allowed: a whole number from 1"),
    (("--jobs", "0"), "'--jobs': 0 is not in the range x>=1"),
    (("--jobs", "999"), "threads: 999; allowed: from 1 to"),
    (("--scheduler", "nonsense"), "--scheduler nonsense: missing port"),
    (("--scheduler", ""), "--scheduler : missing port"),
    (("--out", "/dev/null/x"), "/dev/null/x: not a directory"),
    (("--out", "HERE"), "holds small.toml and no sweep"),
]


@pytest.mark.parametrize(("words", "fault"), BAD)
def test_bad_input_is_one_line(words, fault, tmp_path, lwr_dyn_command):
    small_study(tmp_path)
    given = [word.replace("HERE", str(tmp_path)) for word in words]
    code, _, err = lwr_dyn_command("sweep", str(tmp_path / "small.toml"), "--out", str(tmp_path / "out"), *given)
    assert (code, err.count("\n")) == (2, 1)
    assert fault in err
    assert not list(tmp_path.rglob("*.parquet"))
    assert not (tmp_path / "out").exists()


def test_a_law_in_a_file_runs_where_only_its_own_options_vary(tmp_path):
    text = """
        robot = "lwr4plus"
        controllers = ["mine.py"]
        [task]
        name = "hold"
        from-deg = [0, 30, 0, -60, 0, 30, 0]
        duration = 0.01
        [sampling]
        runs = 2
        [[parameter]]
        path = "controller.gain"
        low = 1
        high = 2
        """
    law = "def make(arm, dynamics, gain=1.0):\n    return lambda t, q, dq, q_ref, dq_ref, ddq_ref: gain * (q_ref - q)\n"
    (tmp_path / "mine.py").write_text(law, encoding="utf-8")
    (tmp_path / "law.toml").write_text(text, encoding="utf-8")
    runs, _ = SweepWorkshop(read_study(tmp_path / "law.toml")).runs("mine.py", 0, 2)
    assert runs.metrics["tip_max"][0] != runs.metrics["tip_max"][1]


@pytest.mark.slow
def test_a_law_whose_first_run_kills_its_process_is_named_and_the_sweep_ends_in_one_line(tmp_path, lwr_dyn_command):
    killer = LAW.replace("        return B", "        __import__('os')._exit(3)\n        return B")
    small_study(tmp_path, "mine.py", mine=killer)
    code, _, err = lwr_dyn_command("sweep", str(tmp_path / "small.toml"), "--out", str(tmp_path / "out"))
    assert err.startswith("runs the Python file ")
    assert (code, err.count("\n")) == (2, 2)
    assert "first run of mine.py: its process died 3 times (exit code 3)" in err
    assert not (tmp_path / "out").exists()
