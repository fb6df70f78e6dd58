"""The cost of a sweep, stated ahead: the time of a run, the error of its step, memory, and these in words."""

import json
import re
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.codegen.rollouts import substeps
from lwr_dyn.codegen.rollouts.substeps import Steps
from lwr_dyn.foundation.document import Document
from lwr_dyn.studies.sweep.running import cost
from lwr_dyn.studies.sweep.running.chunk_file import encoded
from lwr_dyn.studies.sweep.running.cost import ControllerCost, duration, memory, size
from lwr_dyn.studies.sweep.running.schedulers import Chunk, outcome
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop
from tests.studies.sweep.small import LAW, OWN, small_study

STIFF = """
robot = "lwr4plus"
controllers = ["inverse-dynamics"]
[task]
name = "ist-clear"
[loop]
duration = 2.0
rate = 250
friction_width = 0.05
substeps = 2
[sampling]
method = "random"
runs = 4
[[parameter]]
path = "friction.coulomb"
low = 0.05
high = 0.06
"""
FEWER = ("inverse-dynamics", 4, 4, 1.0, 0.0, 1.0, 4, False)


@pytest.mark.slow
def test_the_error_of_the_step_of_smooth_friction_is_stated_ahead(tmp_path, lwr_dyn_command, monkeypatch):
    monkeypatch.setattr(substeps, "ENOUGH", 2e-8)  # this motion does not need fewer than 1e-6 rad
    (tmp_path / "stiff.toml").write_text(STIFF)
    words = ("sweep", str(tmp_path / "stiff.toml"), "--no-report", "--out")
    _, out, _ = lwr_dyn_command(*words, str(tmp_path / "out"))
    found = re.search(r"up to (\S+) rad off \(estimated\); loop.substeps = (\d+) leaves (\S+) rad", out)
    error, more, left = map(float, found.groups())
    assert error >= 2e-8 > left
    assert more in (4, 8)
    (tmp_path / "stiff.toml").write_text(STIFF.replace("substeps = 2", f"substeps = {more:.0f}"))
    _, out, err = lwr_dyn_command(*words, str(tmp_path / "other"), "--json")
    (row,) = json.loads(out)["cost"]["controllers"]
    assert row["step_error"] == pytest.approx(left, rel=0.6)
    assert "rad off" not in out + err


OFF = "smooth friction leaves positions up to 3e-06 rad off (estimated); "
ALIKE = f"{OFF}smaller steps change as much: the loop amplifies what is small"


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ((Steps(2, 3e-6), Steps(4, 2e-7)), f"{OFF}loop.substeps = 4 leaves 2e-07 rad"),
        ((Steps(2, 3e-6), Steps(2, 3e-6)), ALIKE), ((Steps(2, 3e-6),), ALIKE), ((Steps(2, 9e-7),), ""), ((), ""),
        ((Steps(2, np.nan),), "no run that a kernel follows shows the error of the step"),
    ],
)  # fmt: skip
def test_the_error_of_the_step_in_words(steps, words):
    assert ControllerCost(*FEWER, *steps).step_words == (f"inverse-dynamics: {words}" if words else "")


@pytest.mark.parametrize(
    ("a_run", "runs", "tried"), [(0.001, 1000, (2, 2, 8, 32, 128, 256)), (0.06, 1000, (2, 2, 8)), (0.001, 1, (1, 1))]
)
def test_the_cost_of_a_run_is_the_slope_of_the_time_over_runs(monkeypatch, a_run, runs, tried):
    """0.1 s aside; measured on more runs until that takes 0.3 s beside, or 256 of them."""
    counts = []

    def timed(workshop, controller, count):
        counts.append(count)
        return 0.1 + a_run * count, 1000 * count + 500, "digest"

    monkeypatch.setattr(cost, "_timed", timed)
    steps = SimpleNamespace(steps=lambda law: Steps(2, 1e-3), enough_steps=lambda law: Steps(8, 1e-8))
    found, kernel = cost.measured(steps, "pid", runs, 500)
    assert (tuple(counts), kernel) == (tried, "digest")
    seconds = pytest.approx(a_run if runs > 1 else 0.1 + a_run)
    aside, size = pytest.approx(0.1 if runs > 1 else 0.0, abs=1e-12), 1000 + 500 / tried[-1]
    assert [getattr(found, one.name) for one in fields(found)] == [
        "pid", runs, 500, seconds, aside, size, tried[-1], False, Steps(2, 1e-3), Steps(8, 1e-8),
    ]  # fmt: skip
    assert found.of(10) == pytest.approx(found.aside + 10 * found.seconds)
    for law in (Steps(2, 1e-9), None):
        again, _ = cost.measured(SimpleNamespace(steps=lambda law, is_=law: is_), "pid", 1, 500)
        assert (again.steps, again.better) == (law, None)


def test_the_cost_of_a_sweep_is_that_of_its_controllers():
    pid = ControllerCost("pid", 1001, 500, 2e-3, 0.5, 8e5, 64, False, Steps(2, 3e-6), Steps(4, 2e-7))
    own = ControllerCost("own", 10, 5, 3.0, 1.0, 900.0, 1, True, Steps(1, np.nan))
    both = cost.SweepCost((pid, own), 4, 2.5e9)
    assert (pid.processor, own.processor) == (pytest.approx(3 * 0.5 + 1001 * 2e-3), pytest.approx(2 * 1.0 + 10 * 3.0))
    assert (both.runs, both.processor) == (1011, pytest.approx(35.502))
    assert both.seconds == pytest.approx(35.502 / 4)
    assert both.words == "about 9 s on 4 workers (36 s of processor time), 2.5 GB of memory, 801 MB of files"
    assert replace(both, workers=1).words.startswith("about 36 s on 1 worker (")
    document = Document("", "", [both.section()])
    assert "controller" not in document.text()
    record = document.record()["cost"]
    assert record["disk_bytes"] == pytest.approx(1001 * 8e5 + 9000.0)
    first, second = record.pop("controllers")
    assert record == {"runs": 1011, "processor_s": both.processor, "seconds": both.seconds, "workers": 4,
                      "memory_bytes": 2.5e9, "disk_bytes": both.disk}  # fmt: skip
    assert list(first.values()) == ["pid", 1001, pytest.approx(1e3 * 3.502 / 1001), "kernel", 64, 3e-6]
    assert list(second.values()) == ["own", 10, pytest.approx(3200.0), "simulate, in processes", 1, None]
    assert first.keys() == {"controller", "runs", "run_ms", "by", "measured", "step_error"}
    assert all(head in both.table().text() for head in ("a run [ms]", "measured on [runs]", "step error [rad]"))
    assert "step error" not in replace(both, controllers=(replace(pid, steps=None),)).table().text()


def test_memory_is_that_of_the_processes_and_of_chunks_or_all_results(monkeypatch):
    monkeypatch.setattr(cost.resource, "getrusage", lambda who: SimpleNamespace(ru_maxrss=1000))
    monkeypatch.setattr(cost.sys, "platform", "linux")
    few = ControllerCost("pid", 1000, 500, 2e-3, 0.0, 800.0, 64, False)
    slow = ControllerCost("own", 100, 50, 3.0, 0.0, 10_000.0, 1, True)
    peak = 1024 * 1000
    assert memory([few], 4) == pytest.approx(peak + 4 * 6 * 500 * 800)
    assert memory([replace(few, runs=10**7)], 4) == pytest.approx(peak + 1.6 * 10**7 * 800)
    assert memory([few, slow], 3) == pytest.approx(4 * peak + 3 * 6 * 50 * 10_000)
    monkeypatch.setattr(cost.sys, "platform", "darwin")
    assert memory([few], 4) == pytest.approx(1000 + 4 * 6 * 500 * 800)


def test_first_runs_say_their_time_and_size_or_what_is_wrong(tmp_path, monkeypatch):
    study, given = small_study(tmp_path, OWN, "mine.py", mine=LAW), []

    def in_turn(chunks, work, processes):
        for chunk in chunks:
            given.append((chunk, processes))
            yield chunk, outcome(work, chunk)

    monkeypatch.setattr(cost, "in_processes", in_turn)
    found = cost.first_runs(study, [1])
    assert given == [(Chunk(1, 0, 0, 1), 1)]
    seconds, count = found.pop(1)
    assert (found, count) == ({}, len(encoded(SweepWorkshop(study).runs("mine.py", 0, 1)[0], "")))
    assert 0.0 < seconds < 60.0
    (tmp_path / "mine.py").write_text(LAW.replace("return B", "return 1 / 0"))
    with pytest.raises(cost.FirstRunError, match=r"^first run of mine\.py: .*changed since") as fault:
        cost.first_runs(study, [1])
    assert fault.value.controller == "mine.py"


def test_times_and_sizes_in_words():
    times = {0.0: "1 s", 89: "89 s", 90: "2 min", 5300: "88 min", 5400: "1 h 30 min", 7260: "2 h 1 min"}
    assert {x: duration(x) for x in times} == times
    sizes = {1.0: "1 MB", 2.4e6: "2 MB", 9.98e8: "998 MB", 1e9: "1.0 GB", 2.5e9: "2.5 GB"}
    assert {x: size(x) for x in sizes} == sizes
