"""Files of a sweep: the same bytes, never half, of one study only; and their arrays."""

import errno
import json
import os
import platform
import re
from dataclasses import replace
from importlib.metadata import version

import numpy as np
import pyarrow.parquet
import pytest

from lwr_dyn.codegen.kernels import machine_code
from lwr_dyn.codegen.kernels.machine_code import host_cpu
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.studies.sweep.running.chunk_file import chunk_digest, chunk_stamp, decoded, encoded, joined
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
from tests.studies.sweep.small import contents

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


def opened(folder, manifest=MANIFEST, text="text"):
    return SweepFolder.opened(folder, manifest, text)


def refused(error, words, folder, manifest=MANIFEST):
    """The error of a folder that cannot be opened; nothing in it changes."""
    before = contents(folder)
    with pytest.raises(error, match=re.escape(words)) as fault, opened(folder, manifest):
        pass
    assert contents(folder) == before
    return fault.value


def test_a_chunk_is_read_as_it_was_written_and_repeats_to_the_bit(tmp_path):
    data = encoded(columns(0, 4), "digest", NAMES)
    assert data == encoded(columns(0, 4), "digest", NAMES)
    path = tmp_path / "chunk.parquet"
    path.write_bytes(data)
    same(decoded(path, "pid"), columns(0, 4))
    assert (decoded(path, "pid").label, chunk_stamp(path)) == ("pid", ("digest", 0, 4))
    assert pyarrow.parquet.read_table(path).column_names == [
        "run", "payload.mass", "arm.com.1.x", "arm.com.1.y", "reading", "tip_rms", "peak_torque[1]", "peak_torque[2]",
        "peak_torque[3]", "first_violation", "flag", "simulated",
    ]  # fmt: skip
    path.write_bytes(encoded(columns(4, 7), "other"))
    assert (chunk_stamp(path), chunk_digest(path, 3), chunk_digest(path, 4)) == (("other", 4, 3), "other", None)
    assert pyarrow.parquet.read_table(path).column_names[2:4] == ["arm.com[1]", "arm.com[2]"]
    same(joined([columns(0, 4), decoded(path, "pid")]), columns(0, 7))


@pytest.mark.parametrize("change", [lambda b: b[:-9], lambda b: b[: len(b) // 2], lambda b: b"PAR1", lambda b: b""])
def test_a_damaged_chunk_is_no_chunk(change, tmp_path):
    path = tmp_path / "chunk.parquet"
    path.write_bytes(change(encoded(columns(0, 4), "digest")))
    assert (chunk_digest(path, 4), chunk_stamp(path)) == (None, None)
    with pytest.raises(FileAccessError, match="damaged, or no chunk of a sweep"):
        decoded(path, "pid")


def test_results_are_the_runs_in_their_order_and_say_what_is_missing(tmp_path):
    with opened(tmp_path) as folder:
        fill(folder, PID, (2, 0, 1))
        fill(folder, OWN, (2, 0))
        folder.write_failures({"mine.py": {11: "later", 1: "runs 2 to 3: no"}, PID.controller: {}})
    assert (tmp_path / "failures.json").read_text() == (
        '{\n "mine.py": {\n  "1": "runs 2 to 3: no",\n  "11": "later"\n }\n}\n'
    )  # fmt: skip
    results = SweepResults.load(tmp_path)
    same(results.controllers[PID.controller], columns(0, 10))
    assert results.controllers["mine.py"].run.tolist() == [0, 1, 4]
    assert results.missing == {PID.controller: (), "mine.py": (1,)}
    assert results.failures == {"mine.py": {1: "runs 2 to 3: no", 11: "later"}}
    assert not results.is_complete
    with opened(tmp_path) as folder:
        fill(folder, OWN, (1,))
        folder.write_failures({"mine.py": {}})
    assert SweepResults.load(tmp_path).is_complete
    assert SweepResults.load(tmp_path).failures == {}
    (tmp_path / "failures.json").write_text("[]")
    with pytest.raises(FileAccessError, match=r"failures\.json: not what a sweep writes"):
        SweepResults.load(tmp_path)


def test_a_chunk_in_the_place_of_another_is_refused_with_a_line(tmp_path):
    with opened(tmp_path) as folder:
        fill(folder, PID, (0, 1, 2))
        data = folder.file(PID, 0).read_bytes()
        for name in ("00001", "00003", "x1", "\u0661", "0" * 61):  # past the last one, and no numbers
            (tmp_path / PID.folder / f"chunk-{name}.parquet").write_bytes(data)
        words = f"{folder.file(PID, 1)} holds runs from 0, not 4: copied or renamed, not used"
        assert (folder.kept(PID), folder.misplaced(PID)) == ({0, 2}, {1: words})
        folder.write_failures({PID.controller: {2: "no"}})
    results = SweepResults.load(tmp_path)
    assert results.missing[PID.controller] == (1,)
    assert results.failures[PID.controller] == {1: words, 2: "no"}
    assert results.controllers[PID.controller].run.tolist() == [0, 1, 2, 3, 8, 9]
    with opened(tmp_path) as folder:
        fill(folder, PID, (1,))
        assert folder.misplaced(PID) == {}


def test_what_a_killed_process_left_is_cleared_and_damaged_chunks_do_not_count(tmp_path):
    with opened(tmp_path) as folder:
        fill(folder, PID, (0, 1, 2))
        folder.file(PID, 1).write_bytes(folder.file(PID, 1).read_bytes()[:-20])
        folder.file(PID, 2).write_bytes(encoded(columns(8, 10), "of another sweep"))
        left = [tmp_path / PID.folder / ".chunk-00001.parquet.77.part", tmp_path / ".manifest.json.77.part"]
        for path in left:
            path.write_bytes(b"half")
    with opened(tmp_path) as folder:
        assert not any(path.exists() for path in left)
        assert (folder.kept(PID), folder.kept(OWN), folder.misplaced(PID)) == ({0}, set(), {})


def test_more_runs_of_a_sweep_take_the_folder_over_and_fewer_do_not(tmp_path):
    more = replace(MANIFEST, controllers=(replace(PID, runs=15), replace(OWN, runs=15)))
    with opened(tmp_path) as folder:
        fill(folder, PID, (0, 1, 2))
    with opened(tmp_path, MANIFEST, "of the same runs"):
        assert (tmp_path / "study.toml").read_text() == "text"
    with opened(tmp_path, more, "more") as folder:
        assert folder.kept(PID) == {0, 1, 2}
        assert (folder.kept(more.controllers[0]), folder.misplaced(more.controllers[0])) == ({0, 1}, {})
    assert (tmp_path / "study.toml").read_text() == "more"
    assert SweepManifest.read("x", (tmp_path / "manifest.json").read_text()) == more
    words = "another number of runs: 15, here 10; allowed: as many or more, or another folder"
    refused(OtherSweepError, words, tmp_path)


@pytest.mark.parametrize(
    ("change", "what", "found", "here"),
    [
        ({"digest": "d" * 64}, "study", "small (cccccccc)", "dddddddd"),
        ({"versions": {"numpy": "2.1", "pyarrow": "18.0"}}, "version", "numpy 2.0", "2.1"),
        ({"versions": {**MANIFEST.versions, "processor": "znver4"}}, "processor", "none", "znver4"),
        ({"controllers": (replace(PID, kernel="e" * 64), OWN)}, "kernel", "pid:omega-n=20 (aaaaaaaa)", "eeeeeeee"),
        ({"controllers": (PID, replace(OWN, controller="x"))}, "controller", "mine.py (bbbbbbbb)", "bbbbbbbb"),
        ({"controllers": (PID,)}, "study", "2 controllers", "1"),
    ],
)
def test_the_folder_of_another_sweep_is_refused(change, what, found, here, tmp_path):
    with opened(tmp_path) as folder:
        fill(folder, PID, (0,))
    words = (
        f"{tmp_path}: holds results of another {what}: {found}, here {here}; allowed: that {what}, or another folder"
    )
    fault = refused(OtherSweepError, words, tmp_path, replace(MANIFEST, **change))
    assert (fault.folder, fault.what, fault.found, fault.here) == (str(tmp_path), what, found, here)


def test_a_folder_with_other_files_or_a_foreign_manifest_is_refused(tmp_path):
    (tmp_path / "study.toml").write_text("of a sweep that did not begin")
    with opened(tmp_path / "new"):
        pass
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [
        "manifest.json", "mine.py", "pid-omega-n-20", "study.toml",
    ]  # fmt: skip
    refused(FileAccessError, "holds new and no sweep", tmp_path)
    plain = json.loads(MANIFEST.text())
    first = plain["controllers"][0]
    wrong = [{"folder": "../x"}, {"runs": 10**16}, {"runs": 1e9}, {"runs": 10_000_001}, {"runs": 0}, {"chunk": 0}]
    for text in ("{", "[]", "{}", json.dumps(plain | {"schema": 2})):
        (tmp_path / "manifest.json").write_text(text)
        refused(FileAccessError, "no manifest of a sweep", tmp_path)
    for change in wrong:  # of the most runs the fuzz found: each of the chunks was looked for
        (tmp_path / "manifest.json").write_text(json.dumps(plain | {"controllers": [first | change]}))
        with pytest.raises(FileAccessError, match="no manifest of a sweep"):
            SweepResults.load(tmp_path)
    most = SweepManifest.read("x", json.dumps(plain | {"controllers": [first | {"runs": 10_000_000, "chunk": 1}]}))
    assert (most.runs, most.controllers[0].size) == (10_000_000, 1)
    with pytest.raises(FileAccessError, match=r"nowhere: no manifest\.json"):
        SweepResults.load(tmp_path / "nowhere")


def test_one_process_at_a_time_writes(tmp_path):
    with opened(tmp_path):
        assert refused(SweepInUseError, f"{tmp_path}: another process sweeps into it", tmp_path).folder == str(tmp_path)
    with opened(tmp_path):
        pass


@pytest.mark.parametrize(
    ("place", "code", "allowed"),
    [("fsync", errno.ENOSPC, "more room: all"), ("replace", errno.EDQUOT, "more room: all"),
     ("replace", errno.EACCES, "a writable file")],
)  # fmt: skip
def test_a_file_that_cannot_be_written_is_one_line_and_leaves_what_was_there(
    place, code, allowed, tmp_path, monkeypatch
):
    path = tmp_path / "chunk.parquet"
    write_whole(path, b"old")

    def full(*_):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, place, full)
    with pytest.raises(FileAccessError, match=f"(?i){re.escape(os.strerror(code))}; allowed: {allowed}"):
        write_whole(path, b"new")
    assert contents(tmp_path) == {"chunk.parquet": b"old"}


def test_folders_of_controllers_are_plain_and_no_two_alike():
    names = folder_names(["pid", "PID", "../pid", "a/b.py", "a-b.py", "", "\u00e9", "x" * 70, f"{'y' * 59}-z"])
    assert names == [
        "pid", "PID-2", "pid-3", "a-b.py", "a-b.py-2", "controller", "controller-2", "x" * 60, f"{'y' * 58}-z",
    ]  # fmt: skip


def test_a_manifest_is_read_as_it_was_written():
    assert MANIFEST.text() == json.dumps(json.loads(MANIFEST.text()), indent=1) + "\n"
    assert json.loads(MANIFEST.text()) == {
        "schema": 1, "study": "small", "digest": "c" * 64, "versions": {"numpy": "2.0", "pyarrow": "18.0"},
        "controllers": [
            {"controller": "pid:omega-n=20", "folder": "pid-omega-n-20", "kernel": "a" * 64, "chunk": 4, "chunks": 3,
             "runs": 10, "by": "kernel"},
            {"controller": "mine.py", "folder": "mine.py", "kernel": "b" * 64, "chunk": 2, "chunks": 3, "runs": 5,
             "by": "simulate"},
        ],
    }  # fmt: skip
    assert SweepManifest.read("x", MANIFEST.text()) == MANIFEST
    assert [PID.bounds(k) for k in range(PID.count)] == [(0, 4), (4, 8), (8, 10)]
    other = replace(MANIFEST, versions={"numpy": "3"}), replace(MANIFEST, digest="d")
    digests = {one.chunk_digest(PID) for one in (MANIFEST, *other)} | {MANIFEST.chunk_digest(OWN)}
    changed = [replace(PID, **change) for change in ({"controller": "x"}, {"kernel": "x"}, {"size": 5})]
    assert len(digests | {MANIFEST.chunk_digest(one) for one in changed}) == 7
    assert MANIFEST.chunk_digest(replace(PID, runs=11)) == MANIFEST.chunk_digest(PID)
    assert replace(MANIFEST, controllers=()).runs == 0


def test_versions_name_the_processor_and_what_makes_the_polynomials(monkeypatch):
    here = versions()
    assert (here["mpmath"], here["python"], versions()) == (version("mpmath"), platform.python_version(), here)
    name, features = host_cpu()[1:]
    assert re.fullmatch(re.escape(name) + r" \([0-9a-f]{8}\)", here["processor"])
    monkeypatch.setattr(machine_code, "host_cpu", lambda: ("x", name, features + ",+more"))
    assert versions()["processor"] != here["processor"]
    with pytest.raises(WorkerVersionError, match=f"has processor {name} "):
        refuse_other_versions({"a worker": versions()}, here)
