"""Files of a sweep: the same bytes, never half, of one study only; and their arrays."""

import errno
import os
import re
from dataclasses import replace
from importlib.metadata import version

import numpy as np
import pytest

from lwr_dyn.codegen.kernels import machine_code
from lwr_dyn.codegen.kernels.machine_code import host_cpu
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.studies.sweep.running.chunk_file import chunk_digest, decoded, encoded
from lwr_dyn.studies.sweep.running.cluster import WorkerVersionError, refuse_other_versions
from lwr_dyn.studies.sweep.running.sweep_folder import (
    OtherSweepError,
    SweepFolder,
    SweepInUseError,
    SweepManifest,
    SweepResults,
    SweptController,
    folder_names,
    versions,
    write_whole,
)
from lwr_dyn.studies.sweep.summary import ControllerRuns

PID = SweptController("pid:omega-n=20", "pid-omega-n-20", "a" * 64, 4, 10)
OWN = SweptController("mine.py", "mine.py", "b" * 64, 2, 5, slow=True)
MANIFEST = SweepManifest("small", "c" * 64, (PID, OWN), {"numpy": "2.0", "pyarrow": "18.0"})
NAMES = {"arm.com": ("arm.com.1.x", "arm.com.1.y")}


def columns(first, stop):
    run = np.arange(first, stop)
    values = {
        "payload.mass": 0.1 * run,
        "arm.com": np.outer(run, [1e-3, 1e-4]),
        "reading": np.full(len(run), "computed"),
    }
    metrics = {"tip_rms": np.where(run == 3, np.nan, 1e-3 * run), "peak_torque": np.outer(run, np.arange(1.0, 4.0))}
    metrics["first_violation"] = np.full(len(run), np.inf)
    return ControllerRuns("pid", run, values, metrics, np.where(run == 3, "stop", ""), run == 3)


def same(found, wanted):
    assert list(found.values) == list(wanted.values)
    assert list(found.metrics) == list(wanted.metrics)
    for a, b in ((found.values, wanted.values), (found.metrics, wanted.metrics)):
        for name in b:
            np.testing.assert_array_equal(a[name], b[name])
    for name in ("run", "flags", "simulated"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))


def fill(folder, controller, numbers):
    for number in numbers:
        first, stop = controller.bounds(number)
        data = encoded(columns(first, stop), folder.manifest.chunk_digest(controller), NAMES)
        write_whole(folder.file(controller, number), data)


def test_a_chunk_is_read_as_it_was_written_and_repeats_to_the_bit(tmp_path):
    data = encoded(columns(0, 4), "digest", NAMES)
    assert data == encoded(columns(0, 4), "digest", NAMES)
    path = tmp_path / "chunk.parquet"
    path.write_bytes(data)
    same(decoded(path, "pid"), columns(0, 4))
    import pyarrow.parquet

    names = pyarrow.parquet.read_table(path).column_names
    assert names == [
        "run", "payload.mass", "arm.com.1.x", "arm.com.1.y", "reading", "tip_rms", "peak_torque[1]", "peak_torque[2]",
        "peak_torque[3]", "first_violation", "flag", "simulated",
    ]  # fmt: skip


@pytest.mark.parametrize("change", [lambda b: b[:-9], lambda b: b[: len(b) // 2], lambda b: b"PAR1", lambda b: b""])
def test_a_damaged_chunk_is_no_chunk(change, tmp_path):
    path, data = tmp_path / "chunk.parquet", encoded(columns(0, 4), "digest")
    path.write_bytes(data)
    assert (chunk_digest(path, 4), chunk_digest(path, 5)) == ("digest", None)
    path.write_bytes(change(data))
    assert chunk_digest(path, 4) is None
    with pytest.raises(FileAccessError, match="damaged"):
        decoded(path, "pid")


def test_results_are_the_runs_in_their_order_and_say_what_is_missing(tmp_path):
    with SweepFolder.opened(tmp_path / "out", MANIFEST, "text") as folder:
        fill(folder, PID, (2, 0, 1))
        fill(folder, OWN, (2, 0))
        folder.write_failures({"mine.py": {1: "runs 2 to 3: no"}, PID.controller: {}})
    results = SweepResults.load(tmp_path / "out")
    same(results.controllers[PID.controller], columns(0, 10))
    assert results.controllers["mine.py"].run.tolist() == [0, 1, 4]
    assert results.missing == {PID.controller: (), "mine.py": (1,)}
    assert results.failures == {"mine.py": {1: "runs 2 to 3: no"}}
    assert not results.is_complete
    with SweepFolder.opened(tmp_path / "out", MANIFEST, "text") as folder:
        fill(folder, OWN, (1,))
        folder.write_failures({})
    assert SweepResults.load(tmp_path / "out").is_complete
    assert SweepResults.load(tmp_path / "out").failures == {}


def test_a_chunk_in_the_place_of_another_is_refused_with_a_line(tmp_path):
    with SweepFolder.opened(tmp_path, MANIFEST, "text") as folder:
        fill(folder, PID, (0, 1, 2))
        folder.file(PID, 1).write_bytes(folder.file(PID, 0).read_bytes())
        assert folder.kept(PID) == {0, 2}
        assert list(folder.misplaced(PID)) == [1]
    results = SweepResults.load(tmp_path)
    assert results.missing[PID.controller] == (1,)
    assert "chunk-00001.parquet holds runs from 0, not 4: copied" in results.failures[PID.controller][1]
    assert results.controllers[PID.controller].run.tolist() == [0, 1, 2, 3, 8, 9]
    with SweepFolder.opened(tmp_path, MANIFEST, "text") as folder:
        fill(folder, PID, (1,))
        assert folder.misplaced(PID) == {}


@pytest.mark.parametrize("runs", ["10000000000000000", "1e9", "10000001"])
def test_a_manifest_of_chunks_without_end_is_refused(tmp_path, runs):
    """Found by the fuzz: each of the chunks was looked for."""
    with SweepFolder.opened(tmp_path, MANIFEST, "text") as folder:
        fill(folder, PID, (0,))
    text = MANIFEST.text().replace('"runs": 10', f'"runs": {runs}')
    assert text != MANIFEST.text()
    (tmp_path / "manifest.json").write_text(text)
    with pytest.raises(FileAccessError, match="no manifest of a sweep"):
        SweepResults.load(tmp_path)


def test_what_a_killed_process_left_is_cleared_and_damaged_chunks_do_not_count(tmp_path):
    with SweepFolder.opened(tmp_path, MANIFEST, "text") as folder:
        fill(folder, PID, (0, 1, 2))
        folder.file(PID, 1).write_bytes(folder.file(PID, 1).read_bytes()[:-20])
        folder.file(PID, 2).write_bytes(encoded(columns(8, 10), "of another sweep"))
        left = [tmp_path / PID.folder / ".chunk-00001.parquet.77.part", tmp_path / ".manifest.json.77.part"]
        for path in left:
            path.write_bytes(b"half")
    with SweepFolder.opened(tmp_path, MANIFEST, "text") as folder:
        assert not any(path.exists() for path in left)
        assert folder.kept(PID) == {0}
        assert folder.kept(OWN) == set()


OTHERS = [
    (replace(MANIFEST, digest="d" * 64), "holds results of another study: small (cccccccc), here dddddddd"),
    (replace(MANIFEST, versions={"numpy": "2.1", "pyarrow": "18.0"}), "another version: numpy 2.0, here 2.1"),
    (
        replace(MANIFEST, versions={**MANIFEST.versions, "processor": "znver4 (01234567)"}),
        "another processor: none, here znver4 (01234567)",
    ),
    (
        replace(MANIFEST, controllers=(replace(PID, kernel="e" * 64), OWN)),
        "another kernel: pid:omega-n=20 (aaaaaaaa), here eeeeeeee",
    ),
]


def test_more_runs_of_a_sweep_take_the_folder_over_and_fewer_do_not(tmp_path):
    more = replace(MANIFEST, controllers=(replace(PID, runs=15), replace(OWN, runs=15)))
    with SweepFolder.opened(tmp_path, MANIFEST, "text") as folder:
        fill(folder, PID, (0, 1, 2))
    with SweepFolder.opened(tmp_path, more, "more") as folder:
        assert folder.kept(PID) == {0, 1, 2}
        assert folder.kept(more.controllers[0]) == {0, 1}
        assert folder.misplaced(more.controllers[0]) == {}
    assert (tmp_path / "study.toml").read_text() == "more"
    assert SweepManifest.read("x", (tmp_path / "manifest.json").read_text()) == more
    words = "another number of runs: 15, here 10; allowed: as many or more, or another folder"
    with pytest.raises(OtherSweepError, match=words), SweepFolder.opened(tmp_path, MANIFEST, "text"):
        pass


@pytest.mark.parametrize(("other", "words"), OTHERS)
def test_the_folder_of_another_sweep_is_refused(other, words, tmp_path):
    with SweepFolder.opened(tmp_path, MANIFEST, "text") as folder:
        fill(folder, PID, (0,))
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(OtherSweepError, match=re.escape(words)), SweepFolder.opened(tmp_path, other, "text"):
        pass
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


def test_a_folder_with_other_files_or_a_foreign_manifest_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FileAccessError, match=r"notes\.txt"), SweepFolder.opened(tmp_path, MANIFEST, "text"):
        pass
    for text in ("{", "[]", "{}", MANIFEST.text().replace("pid-omega-n-20", "../x"), '{"schema": 2}'):
        (tmp_path / "manifest.json").write_text(text)
        with pytest.raises(FileAccessError, match="no manifest"), SweepFolder.opened(tmp_path, MANIFEST, "text"):
            pass
    with pytest.raises(FileAccessError, match=r"no manifest\.json"):
        SweepResults.load(tmp_path / "nowhere")


def test_one_process_at_a_time_writes(tmp_path):
    with (
        SweepFolder.opened(tmp_path, MANIFEST, "text"),
        pytest.raises(SweepInUseError),
        SweepFolder.opened(tmp_path, MANIFEST, "text"),
    ):
        pass
    with SweepFolder.opened(tmp_path, MANIFEST, "text"):
        pass


@pytest.mark.parametrize("place", ["fsync", "replace"])
def test_a_full_disk_is_one_line_and_leaves_what_was_there(place, tmp_path, monkeypatch):
    path = tmp_path / "chunk.parquet"
    write_whole(path, b"old")

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, place, full)
    with pytest.raises(FileAccessError, match="no space left on device; allowed: more room: all finished chunks"):
        write_whole(path, b"new")
    assert [x.name for x in tmp_path.iterdir()] == ["chunk.parquet"]
    assert path.read_bytes() == b"old"


def test_folders_of_controllers_are_plain_and_no_two_alike():
    names = folder_names(["pid", "PID", "../pid", "a/b.py", "a-b.py", "", "é"])
    assert len({name.lower() for name in names}) == len(names)
    assert all(re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9._-]*", name) for name in names)


def test_a_manifest_is_read_as_it_was_written():
    assert SweepManifest.read("x", MANIFEST.text()) == MANIFEST
    assert MANIFEST.chunk_digest(PID) != MANIFEST.chunk_digest(OWN)
    assert replace(MANIFEST, versions={"numpy": "3"}).chunk_digest(PID) != MANIFEST.chunk_digest(PID)


def test_versions_name_the_processor_and_what_makes_the_polynomials(monkeypatch):
    here = versions()
    assert (here["mpmath"], versions()) == (version("mpmath"), here)
    name, features = host_cpu()[1:]
    assert here["processor"].startswith(f"{name} (")
    monkeypatch.setattr(machine_code, "host_cpu", lambda: ("x", name, features + ",+more"))
    assert versions()["processor"] != here["processor"]
    with pytest.raises(WorkerVersionError, match=f"has processor {name} "):
        refuse_other_versions({"a worker": versions()}, here)
