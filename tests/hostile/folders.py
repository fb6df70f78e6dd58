"""Generators of bags, machine data, xacro files with expressions and folders of sweeps, for `readers.py`."""

from __future__ import annotations

import functools
import random
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

import lwr_dyn
from tests.hostile.changes import changed, flipped
from tests.hostile.recordings import written

GOOD = Path(__file__).with_name("good")


def machine_data(folder: Path, rng: random.Random) -> None:
    """A KUKA robot's machine data, and where its flange is."""
    text = (GOOD / "machine.dat").read_text(encoding="utf-8")
    path = written(folder, "$machine.dat", changed(text, rng, "nnnnnnnnvrrwdsx").encode("latin-1", "replace"))
    arm = lwr_dyn.load(path)
    lwr_dyn.forward_kinematics(arm, np.zeros(arm.n))


EXPRESSIONS = (
    "1 + 2 * 3", "'a' + str(2)", "[1, 2, 3][1]", "max(1, 2)", "sizes[0] * pi", "'%.3f' % 2.5", "radians(90)",
    "len(sizes)",
    "limits['lower']", "python.sorted(sizes)[-1]", "prefix.upper()", "'x' in prefix", "1 if True else 0", "2**8 // 3",
    "list(python.range(5))", "python.dict(a=1)", "xacro.tokenize('a b')", "prefix * 3", "'-'.join(['a', 'b'])", "not 1",
    "().__class__", "(lambda: 1)()", "[x for x in sizes]", "9**9**9", "'{0.__class__}'.format(1)", "sizes.append(1)",
)  # fmt: skip


def xacro(folder: Path, rng: random.Random) -> None:
    """A file of macros, its text changed or another expression in it."""
    text = (GOOD / rng.choice(("macro.urdf.xacro", "arm.urdf.xacro", "arm.urdf.xacro"))).read_text(encoding="utf-8")
    if rng.random() < 0.35:
        places = [k for k in range(len(text)) if text.startswith("${", k)]
        start = rng.choice(places)
        new = changed(rng.choice(EXPRESSIONS), rng, "nvwds") if rng.random() < 0.5 else rng.choice(EXPRESSIONS)
        new = new.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
        text = text[: start + 2] + new + text[text.index("}", start) :]
    else:
        text = changed(text, rng)
    lwr_dyn.load(written(folder, "x.urdf.xacro", text))


@functools.cache
def _bags() -> Mapping[str, Mapping[str, bytes]]:
    from tests.identification.bags import write_bag

    t = np.arange(0, 300, 5) * 1e-3
    q, tau = np.sin(np.outer(t, (1, 2))), np.cos(np.outer(t, (1, 2)))
    out = {}
    for storage in ("sqlite3", "mcap"):
        with tempfile.TemporaryDirectory() as place:
            fields = {"position": q, "velocity": tau * (1, 2), "effort": 3.0 * tau}
            topic = ("/joint_states", ("a", "b"), t, fields)
            bag = write_bag(Path(place) / "bag", [topic], storage)
            out[storage] = {path.name: path.read_bytes() for path in bag.iterdir()}
    return out


def bag(folder: Path, rng: random.Random) -> None:
    """A ROS 2 bag: its metadata as text, or bytes of its storage."""
    from lwr_dyn.identification.logs.joint_log import read_log
    from lwr_dyn.identification.logs.log_columns import ColumnMap

    files, where = dict(_bags()[rng.choice(("sqlite3", "mcap"))]), folder / "bag"
    name = rng.choice(sorted(files))
    if name.endswith(".yaml"):
        files[name] = changed(files[name].decode(), rng).encode("utf-8", "replace")
    elif rng.random() < 0.8:
        files[name] = flipped(files[name], rng)
    shutil.rmtree(where, ignore_errors=True)
    where.mkdir()
    for each, data in files.items():
        (where / each).write_bytes(data)
    read_log(where, columns=ColumnMap({}, joints=("a", "b")))


@functools.cache
def _sweep() -> tuple[str, bytes]:
    """The manifest of a sweep, and a chunk of it."""
    from lwr_dyn.studies.sweep.running.chunk_file import encoded
    from lwr_dyn.studies.sweep.running.sweep_folder import SweepManifest, SweptController
    from lwr_dyn.studies.sweep.summary import ControllerRuns

    run = np.arange(4)
    values, metrics = {"payload.mass": 0.1 * run, "arm.com": np.outer(run, [1.0, 2.0])}, {"tip_rms": 1e-3 * run}
    runs = ControllerRuns("pid", run, values, metrics, np.full(4, ""), run == 3)
    one = SweptController("pid", "pid", "a" * 64, 4, 4)
    manifest = SweepManifest("small", "c" * 64, (one,), {"numpy": "2.0"})
    return manifest.text(), encoded(runs, manifest.chunk_digest(one))


def sweep_folder(folder: Path, rng: random.Random) -> None:
    """A folder of a sweep: its manifest, its failures or its chunk changed."""
    from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults

    text, chunk = _sweep()
    failures, kind = '{"pid": {"0": "runs 0 to 3: no memory"}}', rng.randrange(3)
    place = folder / "sweep"
    shutil.rmtree(place, ignore_errors=True)
    (place / "pid").mkdir(parents=True)
    written(place, "manifest.json", changed(text, rng) if kind == 0 else text)
    written(place, "failures.json", changed(failures, rng) if kind == 1 else failures)
    (place / "pid" / "chunk-00000.parquet").write_bytes(flipped(chunk, rng) if kind == 2 else chunk)
    SweepResults.load(place)
