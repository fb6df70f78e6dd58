"""A study in one process: whose runs `simulate` makes, what they are asked, and no run with files that have changed."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.law_forms import NoKernelFormError
from lwr_dyn.codegen.rollouts.substeps import Steps
from lwr_dyn.foundation.errors import DivergenceError, FileAccessError
from lwr_dyn.studies.sweep.running import workshop as module
from lwr_dyn.studies.sweep.running.chunk_file import decoded
from lwr_dyn.studies.sweep.running.cluster import WorkerVersionError
from lwr_dyn.studies.sweep.running.schedulers import Chunk, ChunkFault, outcome
from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.running.sweep_folder import versions
from lwr_dyn.studies.sweep.running.workshop import BY_SIMULATE, RunFaultError, SweepJob, SweepWorkshop, workshop_of
from lwr_dyn.studies.sweep.sweep_study import ChangedFileError, controller_of_study, refuse_changed
from lwr_dyn.studies.sweep.vocabulary import METRICS
from tests.studies.sweep.small import LAW, OWN, small_study

CHANGED = r"mine\.py: changed since the study was read; allowed: "
JOB = ("", ""), ("", BY_SIMULATE), versions()


@pytest.fixture
def study(tmp_path):
    return small_study(tmp_path, OWN, "mine.py", mine=LAW)


def change(tmp_path, *how):
    (tmp_path / "mine.py").write_text(LAW.replace(*(how or ("400.0", "100.0"))), encoding="utf-8")


def test_rows_of_a_law_in_python_are_its_runs_by_simulate(study):
    shop = SweepWorkshop(study)
    runs, digest = shop.runs("mine.py", 2, 5)
    run, values = shop.run("mine.py", 3), study.values(3, 4)
    assert (runs.label, digest, runs.run.tolist(), runs.flags.tolist()) == ("mine.py", "simulate", [2, 3, 4], [""] * 3)
    assert runs.simulated.all()
    assert runs.values.keys() == values.keys()
    assert {path: x[1].tolist() for path, x in runs.values.items()} == {p: x[0].tolist() for p, x in values.items()}
    tip = [lwr_dyn.forward_kinematics(shop.arm, q)[:, :3, 3] for q in (run.q, run.q_ref)]
    away = np.linalg.norm(tip[0] - tip[1], axis=1)
    assert set(runs.metrics) == {*METRICS, "tip_q95"}
    torque = np.abs(run.tau_applied).max(axis=0)
    for name, found in {"tip_max": away.max(), "tip_rms": np.sqrt((away**2).mean()), "peak_torque": torque}.items():
        np.testing.assert_allclose(runs.metrics[name][1], found, rtol=1e-12)
    assert (shop.is_slow(OWN), shop.is_slow("mine.py")) == (False, True)


def test_a_law_without_a_kernel_form_is_slow_and_is_tried_once(study, monkeypatch):
    tried = []

    def none(*given):
        tried.append(given)
        raise NoKernelFormError("controller", "it", "another")

    monkeypatch.setattr(module, "law_form", none)
    shop = SweepWorkshop(study)
    assert [shop.is_slow(text) for text in (OWN, OWN, "mine.py")] == [True] * 3
    assert tried == [(shop.controller(OWN), shop.arm)]


def test_a_law_in_a_file_is_made_for_each_row_where_its_options_or_its_payload_vary(tmp_path, monkeypatch):
    law = "def make(arm, dynamics, gain=1.0):\n    return lambda t, q, dq, q_ref, dq_ref, ddq_ref: gain * (q_ref - q)\n"
    study, made = small_study(tmp_path, "mine.py", mine=law), []
    load, known, com, noise = study.parameters
    gain = replace(com, path="controller.gain", columns=("controller.gain",), low=1.0, high=2.0)
    with_law = module.controller_of_run

    def note(study, text, values, i):
        made.append(i)
        return with_law(study, text, values, i)

    monkeypatch.setattr(module, "controller_of_run", note)
    for parameters, rows in (((gain,), [0, 1]), ((load, known), [0, 1]), ((load, noise), [])):
        runs, _ = SweepWorkshop(replace(study, parameters=parameters)).runs("mine.py", 0, 2)
        assert runs.metrics["tip_max"][0] != runs.metrics["tip_max"][1]
        assert made == rows
        made.clear()


def test_a_run_that_diverges_is_a_row_of_nan_with_a_flag(study, monkeypatch):
    run = module.SimulatedRows.run

    def second(rows, i):
        if i == 1:
            raise DivergenceError(0.1, "joint_1", "inf", "less")
        return run(rows, i)

    monkeypatch.setattr(module.SimulatedRows, "run", second)
    runs, _ = SweepWorkshop(study).runs("mine.py", 4, 7)
    assert runs.flags.tolist() == ["", "diverged", ""]
    lost = {name: np.isnan(column[1]).tolist() for name, column in runs.metrics.items()}
    assert lost == {name: [True] * 7 if name in METRICS and METRICS[name].per_joint else True for name in lost}
    assert np.isfinite(runs.metrics["tip_max"][[0, 2]]).all()


def test_what_a_law_does_wrong_is_named_with_its_run(study, tmp_path):
    change(tmp_path, "return B.", "return 1 / 0 * B.")
    with pytest.raises(RunFaultError, match=r"^run 7: .*mine\.py: line 5: ZeroDivisionError") as fault:
        SweepWorkshop(replace(study, places={})).runs("mine.py", 7, 9)
    assert fault.value.number == 7


@pytest.fixture
def asked(monkeypatch):
    """What rollouts are asked for; they answer with positions that substeps change by 1 / substeps."""
    calls = []

    def rollouts(arm, controller, references, **given):
        calls.append(given)
        q = np.full((given["runs"], 2, 7), 1.0 / given["substeps"])
        return SimpleNamespace(q=q, metrics={"tip_max": q[:, 0, 0]})

    monkeypatch.setattr(module, "rollouts", rollouts)
    return calls


def test_the_error_of_the_step_is_sought_over_the_first_runs_without_sensors(study, asked):
    loop = {**study.loop, "friction": "smooth", "rate": 50_000.0}
    shop = SweepWorkshop(replace(study, runs=100, loop=loop))
    assert shop.steps(OWN) == Steps(1, 0.5)
    assert shop.enough_steps(OWN) == Steps(64, 1 / 128)
    given = asked[0]
    assert [x[k] for x in (given, asked[1]) for k in ("substeps", "runs", "first_run", "record", "hand_over")] == [
        1, 64, 0, 3, False, 2, 64, 0, 3, False,
    ]  # fmt: skip
    assert given["encoder"] is None
    assert set(given["parameters"]) == {"payload", "model_payload", "inertia"}
    assert SweepWorkshop(replace(study, loop={**loop, "duration": 0.1})).steps(OWN) == Steps(1, 0.5)
    assert (asked[-1]["runs"], asked[-1]["record"]) == (24, 10)
    assert SweepWorkshop(study).steps(OWN) is None


def test_further_runs_have_the_values_that_are_asked_for(study, asked):
    shop = SweepWorkshop(study, threads=3)
    values = {path: x[:2] for path, x in study.values(5, 9).items()}
    assert shop.evaluate(OWN, values)["tip_max"].tolist() == [1.0, 1.0]
    shop.evaluate(OWN, values, hand_over=True)
    assert [(x["runs"], x["threads"], x["first_run"], x["hand_over"]) for x in asked] == [
        (2, 3, 0, False), (2, 3, 0, True),
    ]  # fmt: skip
    np.testing.assert_array_equal(asked[0]["parameters"]["payload"], values["payload.mass"])


def test_a_job_makes_the_file_of_a_chunk_and_refuses_another_kernel_and_other_versions(study, tmp_path):
    path = tmp_path / "chunk.parquet"
    path.write_bytes(SweepJob(study, ("a", "b"), ("", BY_SIMULATE), versions())(Chunk(1, 3, 6, 8)))
    assert decoded(path, "mine.py").run.tolist() == [6, 7]
    assert (
        module.encoded(decoded(path, "mine.py"), "b", {x.path: x.columns for x in study.parameters})
        == path.read_bytes()
    )
    for kernels, has, words in (
        (("", "0123456789"), versions(), "worker of the chunk has kernel simulate, here is 01234567; allowed"),
        (("", BY_SIMULATE), {"numpy": "0.1"}, "worker of the chunk has numpy .*, here is 0.1; allowed"),
    ):
        with pytest.raises(WorkerVersionError, match=words):
            SweepJob(study, ("", ""), kernels, has)(Chunk(1, 0, 0, 1))


def test_a_workshop_is_kept_for_its_study(study):
    shop = workshop_of(study)
    assert workshop_of(replace(study, keep=9)) is shop
    for change in ({"runs": 25}, {"seed": 6}, {"places": {}}):
        assert workshop_of(study).study.runs == 24
        assert workshop_of(replace(study, **change)) is not workshop_of(study)


def test_a_law_that_changes_before_its_workshop_is_refused(study, tmp_path):
    shop = SweepWorkshop(study)
    change(tmp_path)
    with pytest.raises(ChangedFileError, match=re.escape(str(tmp_path)) + "/" + CHANGED) as refused:
        SweepWorkshop(study)
    assert "\n" not in str(refused.value)
    for text in (OWN, "mine.py"):
        with pytest.raises(ChangedFileError):
            shop.runs(text, 0, 1)


def test_a_law_that_changes_between_two_chunks_is_a_fault_of_the_second(study, tmp_path):
    job = SweepJob(study, *JOB)
    assert isinstance(outcome(job, Chunk(1, 0, 0, 1)), bytes)
    change(tmp_path)
    done = outcome(job, Chunk(1, 1, 1, 2))
    assert isinstance(done, ChunkFault)
    assert re.search(CHANGED, done.why)


def test_a_law_that_changes_while_it_is_loaded_is_refused(study, tmp_path, monkeypatch):
    workshop = SweepWorkshop(study)

    def late(*given):
        change(tmp_path)
        return controller_of_study(*given)

    monkeypatch.setattr("lwr_dyn.studies.sweep.running.workshop.sweep_study.controller_of_study", late)
    with pytest.raises(ChangedFileError):
        workshop.controller("mine.py")


@pytest.mark.slow
def test_a_sweep_ends_in_one_line_when_a_law_changes_and_keeps_what_is_finished(study, tmp_path):
    def report(said):
        if isinstance(said, float):
            change(tmp_path)

    with pytest.raises(ChangedFileError, match=CHANGED):
        sweep(study, tmp_path / "out", threads=1, report=report)
    assert 0 < len(list((tmp_path / "out").rglob("*.parquet"))) < 12


def test_a_file_that_is_gone_is_one_line(study, tmp_path):
    (tmp_path / "mine.py").unlink()
    with pytest.raises(FileAccessError, match=r"mine\.py: no such file"):
        refuse_changed(study)
