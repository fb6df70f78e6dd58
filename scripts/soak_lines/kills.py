"""`kill -9` at random moments of commands that write: afterwards each file is the old one or the new one, never half.

Each command runs in a fork whose writes are slow: a pause stands after half of a file's bytes, and before and after
each rename. Every second kill waits for a write to begin; whether it fell inside is what the child said last.
"""

from __future__ import annotations

import contextlib
import os
import random
import re
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import lwr_dyn
from lwr_dyn.cli.main import main
from lwr_dyn.codegen.kernels import kernel

ROUNDS, SEED = int(os.environ.get("LWR_DYN_KILLS", "20")), 24
"""Kills of each job."""
PAUSE = 0.1
"""[s] At each of the slow places."""
OLD = b"what stood there before\n"
LEFT_OVER = re.compile(r"\..+\.([a-z0-9_]{8}(\.part)?|\d+\.part)|INCOMPLETE\.txt")
"""What a killed process may leave: files under temporary names, and a note in a folder of `reproduce`."""

Job = Callable[[Path, Path], Any]
"""Writes into a folder; the second path is a log to read."""


@dataclass(slots=True)
class Outcome:
    """What became of a job's kills: files by what they are afterwards."""

    kills: int = 0
    inside: int = 0
    old: int = 0
    new: int = 0
    absent: int = 0
    temporary: int = 0
    faults: list[str] = field(default_factory=list)

    def row(self, name: str) -> str:
        """A row of the table."""
        cells = (name, self.kills, self.inside, self.old, self.new, self.absent, self.temporary, len(self.faults))
        return f"| {' | '.join(map(str, cells))} |"


def _command(*words: str) -> None:
    with contextlib.suppress(SystemExit):
        main(list(words))


def _compile(folder: Path, _: Path) -> None:
    os.environ |= {"LWR_DYN_CACHE": str(folder), "XDG_CACHE_HOME": str(folder / "user")}
    lwr_dyn.batch_dynamics(lwr_dyn.load("lwr4plus")).gravity_vector(np.zeros((1, 7)))


def _sweep(folder: Path, log: Path) -> None:
    _command("sweep", str(log.with_name("study.toml")), "--out", str(folder / "sweep"), "--jobs", "1", "--no-report")


def _models(folder: Path, _: Path) -> None:
    from scripts.build_models import main as build_models

    build_models(["--folder", str(folder)])


HOLD = ("--task", "hold", "--from-deg", "0,0,0,0,0,0,0", "--duration", "0.05")
JOBS: dict[str, Job] = {
    "simulate": lambda folder, _: _command("simulate", "lwr4plus", *HOLD, "--out", str(folder / "run.npz")),
    "urdf": lambda folder, _: _command("urdf", "lwr4plus", "--out", str(folder / "x.urdf")),
    "reproduce": lambda folder, _: _command("reproduce", "lwr4", "--out", str(folder)),
    "identify": lambda folder, log: _command("identify", "friction", str(log), "--plot", str(folder / "map")),
    "kernel compile": _compile,
    "show": lambda folder, _: _command("show", "lwr4plus", "--html", str(folder / "x.html"), "--no-browser"),
    "build_models": _models,
    "sweep": _sweep,
}


STUDY = """robot = "lwr4plus"
reading = "physical"
controllers = ["inverse-dynamics"]
[task]
name = "hold"
from-deg = [0, 30, 0, -60, 0, 30, 0]
duration = 0.05
[sampling]
method = "random"
runs = 16
chunk = 2
[[parameter]]
path = "payload.mass"
low = 0
high = 1
"""


def _log(folder: Path) -> Path:
    """A log in which each joint moves at steady speeds; beside it a study of eight chunks."""
    from tests.identification.simulated import ideal_cruise

    arm = lwr_dyn.load("wam7")
    once = [ideal_cruise(arm.friction, np.full(7, v), arm) for v in (0.1, -0.1, 0.2, -0.2)]
    rows = np.vstack([np.hstack([log.q, log.tau]) for log in once])
    head = ",".join(["time", *(f"{x}{j}" for x in ("q", "tau") for j in range(1, 8))])
    path = folder / "log.csv"
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    np.savetxt(path, np.column_stack([np.arange(len(rows)) / 100, rows]), "%.9g", ",", header=head, comments="")
    return path


class SlowStream:
    """A file that takes its time in the middle of its bytes."""

    def __init__(self, stream: Any) -> None:
        self.stream = stream

    def __enter__(self) -> SlowStream:
        return self

    def __exit__(self, *_: object) -> None:
        self.stream.close()

    def flush(self) -> None:
        """Hand on what is written."""
        self.stream.flush()

    def fileno(self) -> int:
        """The number of the file."""
        return int(self.stream.fileno())

    def write(self, data: bytes) -> None:
        """Half of it, a pause, the other half."""
        self.stream.write(data[: len(data) // 2])
        self.stream.flush()
        time.sleep(PAUSE)
        self.stream.write(data[len(data) // 2 :])


def _slow_writes(said: int) -> None:
    """In a child: pauses inside writes and about renames; says "(" when a file is begun and ")" when it is renamed."""
    from lwr_dyn.studies.sweep.running import sweep_folder

    fdopen, replace = os.fdopen, os.replace

    def opened(handle: int, mode: str = "r", *more: Any, **options: Any) -> Any:
        if mode != "wb":
            return fdopen(handle, mode, *more, **options)
        os.write(said, b"(")
        return SlowStream(fdopen(handle, mode))

    def renamed(old: Any, new: Any, **options: Any) -> None:
        time.sleep(PAUSE)
        replace(old, new, **options)
        time.sleep(PAUSE)
        os.write(said, b")")

    def begun(path: Any, mode: str) -> SlowStream:
        os.write(said, b"(")
        return SlowStream(open(path, mode))

    os.fdopen, os.replace = opened, renamed
    sweep_folder.open = begun  # type: ignore[attr-defined] # which forces its files to the disk by itself


def started(job: Job, folder: Path, log: Path, slow: bool = True) -> tuple[int, int]:
    """The job in a fork: its process number, and where it says what it writes."""
    listen, said = os.pipe()
    child = os.fork()
    if child:
        os.close(said)
        return child, listen
    try:
        silent = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(silent, number)
        os.chdir(folder)
        if slow:
            _slow_writes(said)
        job(folder, log)
    finally:
        os._exit(0)


def contents(folder: Path) -> dict[str, bytes]:
    """Relative path -> bytes of every file."""
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def whole_kernel(folder: Path, name: str) -> bool:
    """Whether a kernel is read; what is signed with another key is built again."""
    os.environ |= {"LWR_DYN_CACHE": str(folder), "XDG_CACHE_HOME": str(folder / "user")}
    return kernel.read_cache(Path(name).stem) is not None


def judged(folder: Path, reference: dict[str, bytes], before: dict[str, bytes], outcome: Outcome, number: int) -> None:
    """Count the files of a folder after a kill."""
    found = contents(folder)
    outcome.absent += len(set(reference) - set(found))
    for name, data in found.items():
        if name in before and data == before[name]:
            outcome.old += 1
        elif (name in reference and (data == reference[name] or name.endswith("key"))) or (
            name.endswith(".kernel") and whole_kernel(folder, name)
        ):
            outcome.new += 1
        elif LEFT_OVER.fullmatch(Path(name).name):
            outcome.temporary += 1
        else:
            outcome.faults.append(f"kill {number}: {name}, {len(data)} bytes")


def killed(job: Job, log: Path, rounds: int, rng: random.Random) -> Outcome:
    """A job killed again and again; every second time over old files."""
    with tempfile.TemporaryDirectory() as place:
        start = time.perf_counter()
        os.waitpid(started(job, Path(place), log)[0], 0)
        duration, reference = time.perf_counter() - start, contents(Path(place))
    outcome = Outcome()
    if not reference:
        outcome.faults.append("the job writes nothing")
    for number in range(rounds):
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            before = {name: OLD for name in reference} if number % 4 >= 2 else {}
            for name, data in before.items():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(data)
            child, listen = started(job, folder, log)
            said = os.read(listen, 1) if number % 2 else b""
            time.sleep(rng.uniform(0.0, 3 * PAUSE if number % 2 else duration))
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            said += os.read(listen, 10_000)
            os.close(listen)
            outcome.kills += 1
            outcome.inside += said.count(b"(") > said.count(b")")
            judged(folder, reference, before, outcome, number)
    return outcome


def kills() -> tuple[str, bool, str]:
    """`kill -9` of each of `JOBS`: files are old or new, never half."""
    rng, outcomes = random.Random(SEED), {}
    with tempfile.TemporaryDirectory() as place:
        log = _log(Path(place))
        for name in os.environ.get("LWR_DYN_KILLED", ",".join(JOBS)).split(","):
            job = JOBS[name]
            outcomes[name] = killed(job, log, ROUNDS, rng)
            print(outcomes[name].row(name), *outcomes[name].faults, sep="\n  ", file=sys.stderr, flush=True)
    head = ("command", "kills", "inside a write", "old files", "new files", "absent", "temporary", "half")
    rows = [f"| {' | '.join(head)} |", "|---" * len(head) + "|", *(x.row(name) for name, x in outcomes.items())]
    faults = sum(len(x.faults) for x in outcomes.values())
    inside = sum(x.inside for x in outcomes.values())
    count = sum(x.kills for x in outcomes.values())
    words = f"{count} kills, {inside} of them inside a write; files that are half: {faults}"
    return words, faults == 0, "\n".join(rows)
