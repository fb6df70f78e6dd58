"""`kill -9` of sweeps at random moments, here and on a Dask cluster whose workers are killed too: the same bytes."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from tests.studies.sweep.small import contents, small_study

ROUNDS, SEED = int(os.environ.get("LWR_DYN_KILLS", "20")), 27
CHUNKS = 24
ENDED = os.WEXITED | os.WNOHANG | os.WNOWAIT
HEADS = ("sweep by", "kills", "workers killed", "with some chunks there", "left a temporary file", "other bytes")
PAUSE = 0.01
"""[s] Before and after each rename, so that kills fall into writes too."""
CLUSTER = """
import sys
import dask
from distributed import LocalCluster
if __name__ == "__main__":
    dask.config.set({"distributed.comm.timeouts.connect": "2s"})
    with LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        print(cluster.scheduler_address, flush=True)
        for _ in sys.stdin:
            print(*(nanny.pid for nanny in cluster.workers.values() if nanny.pid), flush=True)
"""


@dataclass(slots=True)
class Kills:
    """What became of the sweeps that were killed."""

    kills: int = 0
    workers: int = 0
    kept: list[int] = field(default_factory=list)
    """Chunks that were there after each kill."""
    inside: int = 0
    """Kills that left a file under a temporary name."""
    faults: list[str] = field(default_factory=list)

    def judge(self, name: str, same: bool, said: str) -> None:
        """Keep what is wrong with the bytes of a sweep, or what the sweep said when it ended early."""
        if said or not same:
            self.faults.append(f"{name}: {said.strip() or 'other bytes'}")

    def row(self, name: str) -> str:
        """A row of the table."""
        middle = sum(0 < k < CHUNKS for k in self.kept)
        cells = (name, self.kills, self.workers, middle, self.inside, len(self.faults))
        return f"| {' | '.join(map(str, cells))} |"


@contextmanager
def local_cluster() -> Iterator[subprocess.Popen[str]]:
    """A Dask cluster of three processes, in a process of its own; its first line is the scheduler's address."""
    with tempfile.TemporaryDirectory() as place:
        script = Path(place) / "cluster.py"
        script.write_text(CLUSTER, encoding="utf-8")
        started = subprocess.Popen(
            [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            yield started
        finally:
            started.terminate()
            started.wait()


def forked(study: SweepStudy, folder: Path, scheduler: str | None) -> int:
    """The sweep in a fork, with slow renames; its process number. What it says is in a file beside the folder."""
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        said = os.open(f"{folder}.said", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(said, 1)
        os.dup2(said, 2)
        rename = os.replace

        def slow(*names: object, **options: object) -> None:
            time.sleep(PAUSE)
            rename(*names, **options)  # type: ignore[arg-type,call-overload]
            time.sleep(PAUSE)

        os.replace = slow  # type: ignore[assignment]
        sweep(study, folder, scheduler=scheduler, threads=2)
        code = 0
    except Exception as fault:
        print(f"{type(fault).__name__}: {fault}", file=sys.stderr, flush=True)
    finally:
        os._exit(code)


def finished(study: SweepStudy, folder: Path, scheduler: str | None) -> tuple[float, str]:
    """How long a sweep takes to its end, and what it says against it."""
    start = time.monotonic()
    _, status = os.waitpid(forked(study, folder, scheduler), 0)
    said = Path(f"{folder}.said").read_text(encoding="utf-8") if status else ""
    return time.monotonic() - start, said


def killed(study: SweepStudy, place: Path, cluster: subprocess.Popen[str] | None = None) -> Kills:
    """The sweep killed once a round, in folders of their own, and gone on with.

    Every fourth round waits for a random part of the time that a whole sweep takes, which may be after its end; the
    others wait for a random number of chunks. On a cluster a worker is killed before.
    """
    rng, found = random.Random(SEED), Kills()
    sweep(study, place / "here", threads=1)
    wanted = contents(place / "here")
    scheduler = None if cluster is None or cluster.stdout is None else cluster.stdout.readline().strip()
    whole, said = finished(study, place / "whole", scheduler)
    found.judge("undisturbed", contents(place / "whole") == wanted, said)
    for number in range(ROUNDS):
        folder = place / str(number)
        child = forked(study, folder, scheduler)
        chunks, moments = sorted(rng.sample(range(1, CHUNKS), 2)), sorted((rng.random(), rng.random()))
        for k, moment in zip(chunks, (moments[0], moments[1] - moments[0]), strict=True):
            time.sleep(whole * moment) if number % 4 == 0 else wait_for(k, child, folder)
            if cluster is not None and k == chunks[0]:
                found.workers += worker_killed(cluster, rng)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        found.kills += 1
        found.inside += bool(list(folder.rglob(".*.part")))
        found.kept.append(len(list(folder.rglob("*.parquet"))))
        _, said = finished(study, folder, scheduler)
        found.judge(f"round {number}", contents(folder) == wanted, said)
        print(time.strftime("%X"), number, found, file=sys.stderr, flush=True)
    return found


def wait_for(chunks: int, child: int, folder: Path) -> None:
    """Wait until so many chunks are there, or the sweep has ended."""
    while len(list(folder.rglob("*.parquet"))) < chunks and os.waitid(os.P_PID, child, ENDED) is None:
        time.sleep(0.001)


def worker_killed(cluster: subprocess.Popen[str], rng: random.Random) -> bool:
    """Kill one of the workers; its nanny starts another."""
    assert cluster.stdin is not None
    assert cluster.stdout is not None
    cluster.stdin.write("pids\n")
    cluster.stdin.flush()
    pids = cluster.stdout.readline().split()
    if not pids:
        return False
    try:
        os.kill(int(rng.choice(pids)), signal.SIGKILL)
    except ProcessLookupError:  # it has just been killed
        return False
    return True


def sweep_kills() -> tuple[str, bool, str]:
    """`kill -9` of a sweep in threads at random moments: after going on, the same bytes as of an undisturbed one."""
    with tempfile.TemporaryDirectory() as place:
        return result("threads", killed(long_study(Path(place)), Path(place)))


def cluster_kills() -> tuple[str, bool, str]:
    """`kill -9` of a sweep on a Dask cluster of three processes, and of its workers, at random moments: same bytes."""
    import distributed  # noqa: F401 # before the forks, once

    with tempfile.TemporaryDirectory() as place, local_cluster() as cluster:
        return result("Dask", killed(long_study(Path(place)), Path(place), cluster))


def long_study(place: Path) -> SweepStudy:
    """A study of so many chunks."""
    study = small_study(place)
    return replace(study, runs=CHUNKS * study.chunk)


def result(name: str, found: Kills) -> tuple[str, bool, str]:
    """A line of the soak, with its table."""
    words = f"{found.kills} kills, {found.workers} of workers; other bytes after going on: {len(found.faults)}"
    table = [f"| {' | '.join(HEADS)} |", "|---" * len(HEADS) + "|", found.row(name)]
    return words, not found.faults, "\n".join(table)
