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

from lwr_dyn.sweeps.study_file import SweepStudy
from lwr_dyn.sweeps.sweep import sweep
from tests.sweeps.small import contents, small_study

ROUNDS, SEED = int(os.environ.get("LWR_DYN_KILLS", "20")), 27
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

    def row(self, name: str, chunks: int) -> str:
        """A row of the table."""
        middle = sum(0 < k < chunks for k in self.kept)
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
    """The sweep in a fork, with slow renames; its process number."""
    child = os.fork()
    if child:
        return child
    try:
        silent = os.open(os.devnull, os.O_RDWR)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        rename = os.replace

        def slow(*names: object, **options: object) -> None:
            time.sleep(PAUSE)
            rename(*names, **options)  # type: ignore[arg-type,call-overload]
            time.sleep(PAUSE)

        os.replace = slow  # type: ignore[assignment]
        sweep(study, folder, scheduler=scheduler, threads=2)
    finally:
        os._exit(0)


def seconds(study: SweepStudy, folder: Path, scheduler: str | None) -> float:
    """What an undisturbed sweep takes."""
    start = time.monotonic()
    os.waitpid(forked(study, folder, scheduler), 0)
    return time.monotonic() - start


def killed(study: SweepStudy, place: Path, wanted: dict[str, bytes], cluster: subprocess.Popen[str] | None) -> Kills:
    """The sweep killed once a round, in folders of their own, and gone on with."""
    rng, found = random.Random(SEED), Kills()
    scheduler = None if cluster is None or cluster.stdout is None else cluster.stdout.readline().strip()
    whole = seconds(study, place / "whole", scheduler)
    if contents(place / "whole") != wanted:
        found.faults.append("undisturbed")
    for number in range(ROUNDS):
        folder = place / str(number)
        child = forked(study, folder, scheduler)
        moments = sorted((rng.uniform(0.0, whole), rng.uniform(0.0, whole)))
        for moment, before in zip(moments, (0.0, moments[0]), strict=True):
            time.sleep(moment - before)
            if cluster is not None and moment == moments[0]:
                found.workers += worker_killed(cluster, rng)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        found.kills += 1
        found.inside += bool(list(folder.rglob(".*.part")))
        if cluster is not None:
            found.workers += worker_killed(cluster, rng)
        found.kept.append(len(list(folder.rglob("*.parquet"))))
        seconds(study, folder, scheduler)
        if contents(folder) != wanted:
            found.faults.append(f"round {number}")
        print(number, found, file=sys.stderr, flush=True)
    return found


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
    """`kill -9` of sweeps at random moments, here and on a Dask cluster of three processes, workers too: same bytes."""
    rows = {}
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        study = replace(small_study(place), runs=120)
        sweep(study, place / "undisturbed", threads=1)
        wanted = contents(place / "undisturbed")
        rows["threads"] = killed(study, place / "threads", wanted, None)
        with local_cluster() as cluster:
            rows["Dask"] = killed(study, place / "dask", wanted, cluster)
    heads = (
        "sweep by",
        "kills",
        "workers killed",
        "with chunks made and missing",
        "left a temporary file",
        "other bytes",
    )
    table = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|", *(x.row(k, 60) for k, x in rows.items())]
    count, faults = sum(x.kills for x in rows.values()), sum(len(x.faults) for x in rows.values())
    workers = sum(x.workers for x in rows.values())
    return f"{count} kills, {workers} workers; other bytes after going on: {faults}", faults == 0, "\n".join(table)
