"""Files that change after a study was read: no run is made with them."""

import re

import pytest

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.studies.sweep.running.schedulers import Chunk, ChunkFault, outcome
from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.running.sweep_folder import versions
from lwr_dyn.studies.sweep.running.workshop import BY_SIMULATE, SweepJob, SweepWorkshop
from lwr_dyn.studies.sweep.sweep_study import ChangedFileError, controller_of_study, refuse_changed
from tests.studies.sweep.small import LAW, OWN, small_study

CHANGED = r"mine\.py: changed since the study was read; allowed: "


@pytest.fixture
def study(tmp_path):
    return small_study(tmp_path, OWN, "mine.py", mine=LAW)


def change(tmp_path):
    (tmp_path / "mine.py").write_text(LAW.replace("400.0", "100.0"), encoding="utf-8")


def test_a_law_that_changes_before_its_workshop_is_refused(study, tmp_path):
    SweepWorkshop(study)
    change(tmp_path)
    with pytest.raises(ChangedFileError, match=re.escape(str(tmp_path)) + "/" + CHANGED) as refused:
        SweepWorkshop(study)
    assert "\n" not in str(refused.value)


def test_a_law_that_changes_between_two_chunks_is_a_fault_of_the_second(study, tmp_path):
    job = SweepJob(study, ("", ""), ("", BY_SIMULATE), versions())
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
