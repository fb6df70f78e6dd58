"""A sweep: every chunk of a study that its folder lacks is made and written; a killed one goes on from there, and a
finished one when the study has more runs.
"""

import os
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import make_folder
from lwr_dyn.foundation.progress import Report
from lwr_dyn.studies.sweep.running import sweep_folder
from lwr_dyn.studies.sweep.running.chunk_file import pyarrow
from lwr_dyn.studies.sweep.running.cluster import connected, on_cluster
from lwr_dyn.studies.sweep.running.cost import ControllerCost, SweepCost, duration, first_runs, measured, memory
from lwr_dyn.studies.sweep.running.schedulers import Chunk, ChunkFault, Done, in_processes, in_threads
from lwr_dyn.studies.sweep.running.workshop import BY_SIMULATE, SweepJob, workshop_of
from lwr_dyn.studies.sweep.sweep_study import SweepStudy, refuse_changed

MOST_THREADS = 256
SLOW_SHARE = 32
"""A chunk of `simulate` has so many times fewer runs, so that a kill costs little."""


@dataclass(frozen=True, slots=True)
class SweepOutcome:
    """What a sweep did: chunks by controller that were made now, that were there, and why others are missing."""

    folder: Path
    cost: SweepCost
    made: Mapping[str, int] = field(default_factory=dict)
    kept: Mapping[str, int] = field(default_factory=dict)
    failures: Mapping[str, Mapping[int, str]] = field(default_factory=dict)
    seconds: float = 0.0
    refused: tuple[str, ...] = ()
    """Chunks that stood in the place of others, and were made again."""

    @property
    def is_complete(self) -> bool:
        """Whether all chunks are there."""
        return not any(self.failures.values())


def sweep(
    study: SweepStudy,
    folder: str | Path,
    *,
    scheduler: str | None = None,
    threads: int | None = None,
    report: Report = lambda _: None,
    state: Callable[[SweepCost], None] = lambda _: None,
) -> SweepOutcome:
    """Make every chunk of a study that its folder lacks.

    Parameters
    ----------
    folder : str or Path
        Made if missing; of an earlier sweep of the same study with the same kernels and versions, and with as many runs
        or fewer. A last chunk that was not full is then made again, full; the bytes are those of one sweep of all runs.
    scheduler : str, optional
        Address of a Dask scheduler, such as "tcp://10.0.0.5:8786"; this process without.
    threads : int, optional
        Threads of this process, and processes for controllers without a kernel; all processors if not given.
    report : callable
        Called with the share that is done, and with words.
    state : callable
        Called with the cost once it is known, before the runs.

    Raises
    ------
    OptionError
        A number of threads outside 1 to `MOST_THREADS`.
    FileAccessError, OtherSweepError, SweepInUseError
        As `SweepFolder.opened`; a disk that is full.
    SchedulerError, WorkerVersionError, MissingPackageError
        As `connected`; without pyarrow.
    ChangedFileError
        A file of the study that changes before its runs are made; all finished chunks are kept.
    LwrDynError
        What makes the first runs of the study impossible.
    """
    pyarrow()
    if threads is not None and not 1 <= threads <= MOST_THREADS:
        raise OptionError("threads", threads, f"from 1 to {MOST_THREADS}")
    workers = threads or processors()
    with _made(folder, study), connected(scheduler) if scheduler is not None else nullcontext() as client:
        if client is not None:
            workers = sum(client.nthreads().values())
        report("the first runs, for the cost")
        cost, manifest = plan(study, workers)
        state(cost)
        with sweep_folder.SweepFolder.opened(folder, manifest, study.text) as opened:
            return _filled(study, opened, cost, client, report)


def processors() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _made(folder: str | Path, study: SweepStudy) -> Iterator[None]:
    """The folder, refused before a kernel is compiled if it holds another study, other versions or other files.

    One that was made now and is still empty after a fault is deleted.
    """
    is_new = not Path(folder).exists()
    path = make_folder(folder)
    try:
        found = sweep_folder.manifest_in(path)
        if found is not None:
            here = tuple(replace(one, runs=study.runs) for one in found.controllers)
            found.refuse_other(
                str(path), sweep_folder.SweepManifest(study.name, study.digest, here, sweep_folder.versions())
            )
        yield
    except BaseException:
        if is_new:
            with suppress(OSError):  # it holds results
                path.rmdir()
        raise


def plan(study: SweepStudy, workers: int) -> tuple[SweepCost, sweep_folder.SweepManifest]:
    """Cost and manifest of a study, from first runs of each controller; raises what these raise."""
    workshop = workshop_of(study)
    costs, controllers, names = [], [], sweep_folder.folder_names(study.controllers)
    spent = first_runs(study, [i for i, text in enumerate(study.controllers) if workshop.is_slow(text)])
    for i, text in enumerate(study.controllers):
        slow, kernel = i in spent, BY_SIMULATE
        size = max(1, study.chunk // SLOW_SHARE) if slow else study.chunk
        held = min(size, study.runs)
        if slow:
            costs.append(ControllerCost(text, study.runs, held, spent[i][0], 0.0, spent[i][1], 1, slow))
        else:
            cost, kernel = measured(workshop, text, study.runs, held)
            costs.append(cost)
        controllers.append(sweep_folder.SweptController(text, names[i], kernel, size, study.runs, slow))
    manifest = sweep_folder.SweepManifest(study.name, study.digest, tuple(controllers), sweep_folder.versions())
    return SweepCost(tuple(costs), workers, memory(costs, workers)), manifest


def _filled(
    study: SweepStudy, folder: sweep_folder.SweepFolder, cost: SweepCost, client: Any, report: Report
) -> SweepOutcome:
    """Make the chunks that are missing."""
    manifest = folder.manifest
    digests = tuple(manifest.chunk_digest(one) for one in manifest.controllers)
    job = SweepJob(study, digests, tuple(one.kernel for one in manifest.controllers), manifest.versions)
    kept = {one.controller: folder.kept(one) for one in manifest.controllers}
    refused = tuple(why for one in manifest.controllers for why in folder.misplaced(one).values())
    left = [
        Chunk(i, number, *one.bounds(number))
        for i, one in enumerate(manifest.controllers)
        for number in range(one.count)
        if number not in kept[one.controller]
    ]
    made = dict.fromkeys(study.controllers, 0)
    failures: dict[str, dict[int, str]] = {text: {} for text in study.controllers}
    clock = _Clock(cost, left, report)
    with closing(_done(left, job, manifest, cost.workers, client)) as results:
        for chunk, result in results:
            text = study.controllers[chunk.controller]
            if isinstance(result, ChunkFault):
                refuse_changed(study)
                failures[text][chunk.number] = f"runs {chunk.first} to {chunk.stop - 1}: {result.why}"
            else:
                sweep_folder.write_whole(folder.file(manifest.controllers[chunk.controller], chunk.number), result)
                made[text] += 1
            clock.tick(chunk)
    folder.write_failures(failures)
    counts = {text: len(numbers) for text, numbers in kept.items()}
    return SweepOutcome(folder.path, cost, made, counts, failures, clock.elapsed, refused)


def _done(
    left: Sequence[Chunk], job: SweepJob, manifest: sweep_folder.SweepManifest, workers: int, client: Any
) -> Generator[Done, None, None]:
    """The chunks by the cluster; else by threads for kernels, then by processes for the rest."""
    if client is not None:
        yield from on_cluster(left, job, client)
    else:
        is_slow = [one.slow for one in manifest.controllers]
        yield from in_threads([chunk for chunk in left if not is_slow[chunk.controller]], job, workers)
        yield from in_processes([chunk for chunk in left if is_slow[chunk.controller]], job, workers)


class _Clock:
    """Says how much is done and how long the rest will take, from what the chunks so far took."""

    def __init__(self, cost: SweepCost, left: Sequence[Chunk], report: Report) -> None:
        self.costs = cost.controllers
        self.total = sum(map(self._work, left)) or 1.0
        self.count, self.report = len(left), report
        self.done, self.chunks, self.begin = 0.0, 0, time.monotonic()
        report("")

    def _work(self, chunk: Chunk) -> float:
        return self.costs[chunk.controller].of(chunk.runs)

    @property
    def elapsed(self) -> float:
        """[s] Since the beginning."""
        return time.monotonic() - self.begin

    def tick(self, chunk: Chunk) -> None:
        """A chunk more is done."""
        self.done, self.chunks = self.done + self._work(chunk), self.chunks + 1
        share = min(1.0, self.done / self.total)
        left = duration(self.elapsed * (1 - share) / share) if share < 1 else "0 s"
        self.report(share)
        self.report(f"chunk {self.chunks} of {self.count}, {left} left")
