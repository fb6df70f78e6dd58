"""Sweeps: the same bytes whatever computes them and however often they are killed; what fails is named."""

import errno
import json
import os
import random
import re
import signal
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.rollouts import rollouts
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError, OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.rollout_arguments import rollout_arguments
from lwr_dyn.studies.sweep.running import sweep as module
from lwr_dyn.studies.sweep.running import sweep_folder
from lwr_dyn.studies.sweep.running.chunk_file import encoded
from lwr_dyn.studies.sweep.running.cost import ControllerCost, SweepCost
from lwr_dyn.studies.sweep.running.schedulers import Chunk, outcome
from lwr_dyn.studies.sweep.running.sweep import SweepOutcome, plan, processors, sweep
from lwr_dyn.studies.sweep.running.sweep_folder import OtherSweepError, SweepManifest, SweptController, versions
from lwr_dyn.studies.sweep.study_template import study_template
from lwr_dyn.studies.sweep.summary import ControllerRuns
from lwr_dyn.studies.sweep.sweep_study import arm_of_study, controller_of_study, references_of_study
from tests.json_schemas import faults
from tests.studies.sweep.small import LAW, OWN, contents, small_study

PID = SweptController("pid", "pid", "k" * 64, 4, 10)
MINE = SweptController("mine.py", "mine.py", "simulate", 8, 10, slow=True)
OF_PID, OF_MINE = ControllerCost("pid", 10, 4, 1, 1, 0, 2, False), ControllerCost("mine.py", 10, 8, 2, 0, 0, 1, True)
COST = SweepCost((OF_PID, OF_MINE), 2, 1e6)


@pytest.fixture
def made_up(tmp_path, monkeypatch):
    """A study of a kernel and a law in Python with made-up runs; the clock goes on by 6 s with each look at it."""
    study = replace(small_study(tmp_path, "pid", "mine.py", mine=LAW), runs=10)
    manifest = SweepManifest(study.name, study.digest, (PID, MINE), versions())
    taken, looks = [], iter(range(0, 10**6, 6))

    def job(study, digests, kernels, versions):
        def made(chunk):
            if chunk.number in broken:
                raise LwrDynError("no")
            rows = np.arange(chunk.first, chunk.stop)
            flags = np.full(rows.size, "")
            runs = ControllerRuns("", rows, {}, {"tip_max": 1.0 * rows}, flags, flags != "")
            return encoded(runs, digests[chunk.controller])

        assert (kernels, versions) == ((PID.kernel, MINE.kernel), manifest.versions)
        return made

    def by(name):
        def in_turn(chunks, work, workers):
            for chunk in chunks:
                taken.append((name, workers, chunk))
                yield chunk, outcome(work, chunk)

        return in_turn

    broken = set()
    for name, stand_in in {
        "plan": lambda study, workers: (replace(COST, workers=workers), manifest), "SweepJob": job,
        "in_threads": by("threads"), "in_processes": by("processes"), "on_cluster": by("cluster"),
        "time": SimpleNamespace(monotonic=lambda: next(looks)),
    }.items():  # fmt: skip
        monkeypatch.setattr(module, name, stand_in)
    return SimpleNamespace(study=study, out=tmp_path / "out", taken=taken, broken=broken)


def test_a_sweep_makes_what_is_missing_and_says_how_far_it_is(made_up):
    chunks = [Chunk(0, 0, 0, 4), Chunk(0, 1, 4, 8), Chunk(0, 2, 8, 10), Chunk(1, 0, 0, 8), Chunk(1, 1, 8, 10)]
    said = []
    made_up.broken |= {1}
    done = sweep(made_up.study, made_up.out, threads=2, report=said.append, state=said.append)
    ways = ["threads"] * 3 + ["processes"] * 2
    assert made_up.taken == [(way, 2, chunk) for way, chunk in zip(ways, chunks, strict=True)]
    failures = {"pid": {1: "runs 4 to 7: no"}, "mine.py": {1: "runs 8 to 9: no"}}
    assert done == SweepOutcome(
        made_up.out, COST, {"pid": 2, "mine.py": 1}, {"pid": 0, "mine.py": 0}, failures, 30, ()
    )  # fmt: skip
    assert not done.is_complete
    shares = [5 / 33, 10 / 33, 13 / 33, 29 / 33, 1.0]  # 1 s and 1 s a run, then 2 s a run
    left = ["34 s", "28 s", "28 s", "3 s", "0 s"]
    words = [f"chunk {k} of 5, {x} left" for k, x in enumerate(left, 1)]
    assert said == [
        "the first runs, for the cost",
        COST,
        "",
        *(x for pair in zip(shares, words, strict=True) for x in pair),
    ]
    made_up.broken.clear()
    made_up.taken.clear()
    copied = made_up.out / "pid" / "chunk-00000.parquet"
    (made_up.out / "pid" / "chunk-00001.parquet").write_bytes(copied.read_bytes())
    again = sweep(made_up.study, made_up.out)
    assert [chunk for _, _, chunk in made_up.taken] == [chunks[1], chunks[4]]
    assert (again.made, again.kept) == ({"pid": 1, "mine.py": 1}, {"pid": 2, "mine.py": 1})
    assert again.failures == {"pid": {}, "mine.py": {}}
    assert again.cost.workers == processors() == len(os.sched_getaffinity(0))
    assert again.refused == (
        f"{made_up.out}/pid/chunk-00001.parquet holds runs from 0, not 4: copied or renamed, not used",
    )
    assert again.is_complete
    assert sweep_folder.SweepResults.load(made_up.out).controllers["pid"].metrics["tip_max"].tolist() == list(range(10))


def test_a_cluster_takes_all_chunks_with_all_threads_of_its_workers(made_up, monkeypatch):
    @contextmanager
    def connected(address):
        yield SimpleNamespace(nthreads=lambda: {"a": 2, address: 3})

    monkeypatch.setattr(module, "connected", connected)
    done = sweep(made_up.study, made_up.out, scheduler="tcp://x:1")
    assert done.cost.workers == 5
    assert [way for way, _, _ in made_up.taken] == ["cluster"] * 5


def test_the_folder_of_a_sweep_that_does_not_begin_goes_if_it_was_made_for_it(made_up, monkeypatch):
    def refused(study, workers):
        raise OptionError("plan", 1, "none")

    monkeypatch.setattr(module, "plan", refused)
    for is_there in (False, True):
        if is_there:
            made_up.out.mkdir()
        with pytest.raises(OptionError, match="plan"):
            sweep(made_up.study, made_up.out)
        assert made_up.out.exists() == is_there


@pytest.mark.parametrize("threads", [0, 257])
def test_numbers_of_threads_outside_1_to_256_are_refused(threads, made_up):
    with pytest.raises(OptionError, match=f"^threads: {threads}; allowed: from 1 to 256$"):
        sweep(made_up.study, made_up.out, threads=threads)
    for most in (1, 256):
        assert sweep(made_up.study, made_up.out, threads=most).cost.workers == most


def test_other_sweeps_are_refused_before_anything_is_computed(made_up, monkeypatch):
    sweep(made_up.study, made_up.out)
    before = contents(made_up.out)
    monkeypatch.setattr(module, "plan", lambda *_: pytest.fail("first runs are made"))
    for change, what in (
        ({"seed": 6}, "study"), ({"seed": 6, "runs": 48}, "study"), ({"controllers": ("pid",)}, "study"),
        ({"runs": 9}, "number of runs: 10, here 9; allowed: as many or more, or another"),
    ):  # fmt: skip
        with pytest.raises(OtherSweepError, match=f"another {what}"):
            sweep(replace(made_up.study, **change), made_up.out)
    assert contents(made_up.out) == before


@pytest.mark.parametrize(("chunk", "of_simulate", "of_kernel"), [(96, 3, 70), (2, 1, 2)])
def test_a_plan_has_a_chunk_of_simulate_32_times_smaller(chunk, of_simulate, of_kernel, tmp_path, monkeypatch):
    study = replace(small_study(tmp_path, "mine.py", OWN, mine=LAW), runs=70, chunk=chunk)
    shop = SimpleNamespace(is_slow=lambda text: text == "mine.py")

    def measured(*given):
        assert given[0] is shop
        return ControllerCost(*given[1:], 1e-3, 0.2, 100.0, 8, False), "k" * 64

    monkeypatch.setattr(module, "workshop_of", lambda of: shop)
    monkeypatch.setattr(module, "first_runs", lambda of, numbers: {i: (0.5, 300.0) for i in numbers})
    monkeypatch.setattr(module, "measured", measured)
    monkeypatch.setattr(module, "memory", lambda costs, workers: 1e6 * workers * len(costs))
    cost, manifest = plan(study, 3)
    slow = ControllerCost("mine.py", 70, of_simulate, 0.5, 0.0, 300.0, 1, True)
    assert cost == SweepCost((slow, ControllerCost(OWN, 70, of_kernel, 1e-3, 0.2, 100.0, 8, False)), 3, 6e6)
    mine = SweptController("mine.py", "mine.py", "simulate", of_simulate, 70, slow=True)
    own = SweptController(OWN, "inverse-dynamics-omega-n-20", "k" * 64, chunk, 70)
    assert manifest == SweepManifest("small", study.digest, (mine, own), versions())


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
    found = sweep_folder.SweepResults.load(folder).controllers[OWN]
    values = study.values(0, study.runs)
    whole = rollouts(
        arm_of_study(study), controller_of_study(study, OWN), references_of_study(study),
        **rollout_arguments(study, OWN, values),
    )  # fmt: skip
    assert found.run.tolist() == list(range(24))
    for kind, wanted in ((found.metrics, whole.metrics), (found.values, values)):
        assert kind.keys() == wanted.keys()
        for name, column in wanted.items():
            np.testing.assert_array_equal(kind[name], column, name)
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


def times(folder, chunks="chunk*"):
    """When the chunks in a folder were written."""
    return {p: p.stat().st_mtime_ns for p in folder.rglob(f"{chunks}.parquet")}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_a_sweep_that_was_killed_goes_on_to_the_same_bytes(seed, undisturbed, tmp_path):
    study, folder = undisturbed
    killed(study, tmp_path / "out", random.Random(seed).randrange(2, 9))
    before = times(tmp_path / "out")
    assert 0 < len(before) < 12
    done = sweep(study, tmp_path / "out", threads=1)
    assert (done.kept[OWN], done.made[OWN]) == (len(before), 12 - len(before))
    assert before.items() <= times(tmp_path / "out").items()
    assert contents(tmp_path / "out") == contents(folder)


@pytest.mark.slow
def test_a_finished_sweep_is_extended_to_the_bytes_of_one_of_all_runs(undisturbed, tmp_path):
    study, folder = undisturbed
    few = replace(study, runs=5, text="# of five runs")
    assert sweep(few, tmp_path / "out", threads=1).made == {OWN: 3}
    first = sweep_folder.SweepResults.load(tmp_path / "out").controllers[OWN]
    full = times(tmp_path / "out", "chunk-0000[01]")
    done = sweep(study, tmp_path / "out", threads=2)
    assert (done.kept, done.made, done.refused) == ({OWN: 2}, {OWN: 10}, ())  # the third had one run of two
    assert times(tmp_path / "out", "chunk-0000[01]") == full
    assert contents(tmp_path / "out") == contents(folder)
    whole = sweep_folder.SweepResults.load(tmp_path / "out").controllers[OWN]
    for name, column in first.metrics.items():
        np.testing.assert_array_equal(whole.metrics[name][:5], column)


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
    assert (code, err.count("\n"), "another number of runs: 9, here 8; allowed: as many or more" in err) == (2, 1, True)


@pytest.mark.slow
def test_a_sweep_as_the_template_draws_it_is_extended_to_the_bytes_of_one_of_all_runs(undisturbed, tmp_path):
    (tmp_path / "new.toml").write_text(study_template("new.toml", "new"))
    study = replace(undisturbed[0], method=read_study(tmp_path / "new.toml").method, runs=7)
    for runs in (3, 4, 7):
        sweep(replace(study, runs=runs), tmp_path / "out", threads=1)
    sweep(study, tmp_path / "once", threads=1)
    assert contents(tmp_path / "out") == contents(tmp_path / "once")


@pytest.mark.slow
def test_a_full_disk_ends_in_one_line_and_what_is_finished_stays(undisturbed, tmp_path, monkeypatch):
    study, folder = undisturbed
    left, fsync = iter(range(7)), os.fsync

    def full(handle):
        if next(left, None) is None:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(handle)

    monkeypatch.setattr(sweep_folder.os, "fsync", full)
    with pytest.raises(FileAccessError, match="no space left on device; allowed: more room: all"):
        sweep(study, tmp_path / "out", threads=2)
    monkeypatch.undo()
    before = contents(tmp_path / "out")
    assert 0 < len(before) < len(contents(folder))
    assert before.items() <= contents(folder).items()
    sweep(study, tmp_path / "out", threads=2)
    assert contents(tmp_path / "out") == contents(folder)


@pytest.mark.slow
def test_a_law_in_a_file_is_swept_by_processes_and_agrees_with_the_kernel(undisturbed, tmp_path):
    study = replace(small_study(tmp_path, "mine.py", mine=LAW), runs=3, chunk=64)
    costs = []
    done = sweep(study, tmp_path / "out", threads=1, state=costs.append)
    assert (done.made, done.failures) == ({"mine.py": 2}, {"mine.py": {}})
    found = sweep_folder.SweepResults.load(tmp_path / "out").controllers["mine.py"]
    kernel = sweep_folder.SweepResults.load(undisturbed[1]).controllers[OWN]
    assert found.simulated.all()
    for path, column in found.values.items():
        np.testing.assert_array_equal(column, kernel.values[path][:3])
    for name, column in found.metrics.items():
        np.testing.assert_allclose(column, kernel.metrics[name][:3], rtol=1e-9, atol=1e-11, err_msg=name)
    assert (costs[0].controllers[0].measured, costs[0].controllers[0].slow) == (1, True)


FAULTY = LAW.replace(
    "    def controller", "    load = sum(b.mass for b in arm.chain.bodies) - TOTAL\n    def controller"
).replace("        return", "        if 1.2 < load < 1.5: 1 / 0\n        return")
"""Of the first four runs it fails in number 2 alone, whose known load is 1.3 kg."""


@pytest.mark.slow
def test_a_chunk_whose_controller_fails_is_named_and_the_rest_is_made(tmp_path, lwr_dyn_command):
    total = sum(body.mass for body in lwr_dyn.load("lwr4plus", "physical").chain.bodies)
    small_study(tmp_path, OWN, "mine.py", mine=FAULTY.replace("TOTAL", repr(total)))
    line = ("sweep", str(tmp_path / "small.toml"), "--out", str(tmp_path / "out"), "--runs", "4", "--jobs", "1")
    code, first, err = lwr_dyn_command(*line)
    said = f"runs the Python file {tmp_path / 'mine.py'}, which the study names\n"
    assert (code, err) == (1, said)
    assert re.search(r"about \d+ s on 1 worker", first)
    why = f"runs 2 to 2: run 2: {tmp_path}/mine.py: line 6: ZeroDivisionError: division by zero; allowed: a controller"
    for words in ("made 5 chunks", f"FAILED: mine.py, chunk 2, {why}"):
        assert words in first
    results = sweep_folder.SweepResults.load(tmp_path / "out")
    assert results.missing == {OWN: (), "mine.py": (2,)}
    assert results.failures["mine.py"][2].startswith(why)
    assert results.controllers["mine.py"].run.tolist() == [0, 1, 3]
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


@pytest.mark.slow
def test_a_law_whose_first_run_kills_its_process_is_named_and_the_sweep_ends_in_one_line(tmp_path, lwr_dyn_command):
    killer = LAW.replace("        return B", "        __import__('os')._exit(3)\n        return B")
    small_study(tmp_path, "mine.py", mine=killer)
    code, _, err = lwr_dyn_command("sweep", str(tmp_path / "small.toml"), "--out", str(tmp_path / "out"))
    assert err.startswith("runs the Python file ")
    assert (code, err.count("\n")) == (2, 2)
    assert "first run of mine.py: its process died 3 times (exit code 3)" in err
    assert not (tmp_path / "out").exists()
