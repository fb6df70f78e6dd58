"""A sweep: every chunk of a study that its folder lacks is made and written; a killed one goes on from there.

The results of a sweep as arrays, controller by controller, from the folder that `lwr-dyn sweep` has written.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import make_folder, read_text
from lwr_dyn.foundation.progress import Report
from lwr_dyn.model.run import repr_html, short_repr
from lwr_dyn.studies.sweep.running.chunks import Chunk, ChunkFault, Done, decoded, encoded, in_threads, joined, pyarrow
from lwr_dyn.studies.sweep.running.cluster import connected, on_cluster
from lwr_dyn.studies.sweep.running.cost import ControllerCost, SweepCost, duration, first_runs, measured, memory
from lwr_dyn.studies.sweep.running.processes import in_processes
from lwr_dyn.studies.sweep.running.sweep_folder import (
    MANIFEST,
    SweepFolder,
    SweepManifest,
    SweptController,
    folder_names,
    manifest_in,
    versions,
    write_whole,
)
from lwr_dyn.studies.sweep.running.workshop import BY_SIMULATE, SweepJob, workshop_of
from lwr_dyn.studies.sweep.summary import ControllerRuns
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
    study : SweepStudy
    folder : str or Path
        Made if missing; of an earlier sweep of the same study with the same kernels and versions.
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
        with SweepFolder.opened(folder, manifest, study.text) as opened:
            return _filled(study, opened, cost, client, report)


@contextmanager
def _made(folder: str | Path, study: SweepStudy) -> Iterator[None]:
    """The folder, not of another study; one that was made now and is still empty after a fault is deleted."""
    is_new = not Path(folder).exists()
    path = make_folder(folder)
    try:
        refuse_early(path, study)
        yield
    except BaseException:
        if is_new:
            with suppress(OSError):  # it holds results
                path.rmdir()
        raise


def processors() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def refuse_early(folder: Path, study: SweepStudy) -> None:
    """Refuse the folder of another study or of other versions before a kernel is compiled.

    Raises `OtherSweepError`, and `FileAccessError` for a folder with other files.
    """
    found = manifest_in(folder)
    if found is not None:
        found.refuse_other(str(folder), SweepManifest(study.name, study.digest, found.controllers, versions()))


def plan(study: SweepStudy, workers: int) -> tuple[SweepCost, SweepManifest]:
    """Cost and manifest of a study, from first runs of each controller; raises what these raise."""
    workshop = workshop_of(study)
    costs, controllers = [], []
    spent = first_runs(study, [i for i, text in enumerate(study.controllers) if workshop.is_slow(text)])
    for i, (text, name) in enumerate(zip(study.controllers, folder_names(study.controllers), strict=True)):
        slow, kernel = i in spent, [BY_SIMULATE]

        def runs_of(count: int, text: str = text, kernel: list[str] = kernel) -> bytes:
            runs, kernel[0] = workshop.runs(text, 0, count)
            return encoded(runs, "")

        size = min(study.count, max(1, study.chunk // SLOW_SHARE) if slow else study.chunk)
        if slow:
            costs.append(ControllerCost(text, study.count, size, spent[i][0], 0.0, spent[i][1], 1, slow))
        else:
            costs.append(measured(runs_of, text, study.count, size))
        controllers.append(SweptController(text, name, kernel[0], size, study.count, slow))
    held = memory(costs, workers)
    manifest = SweepManifest(study.name, study.digest, tuple(controllers), versions())
    return SweepCost(tuple(costs), workers, held), manifest


def _filled(study: SweepStudy, folder: SweepFolder, cost: SweepCost, client: Any, report: Report) -> SweepOutcome:
    """Make the chunks that are missing."""
    manifest = folder.manifest
    digests = tuple(manifest.chunk_digest(one) for one in manifest.controllers)
    job = SweepJob(study, digests, tuple(one.kernel for one in manifest.controllers), manifest.versions)
    kept = {one.controller: folder.kept(one) for one in manifest.controllers}
    left = [
        Chunk(i, number, *one.bounds(number))
        for i, one in enumerate(manifest.controllers)
        for number in range(one.count)
        if number not in kept[one.controller]
    ]
    made = dict.fromkeys(study.controllers, 0)
    failures: dict[str, dict[int, str]] = {text: {} for text in study.controllers}
    clock = _Clock(cost, left, report)
    with closing(_done(left, job, manifest.controllers, cost.workers, client)) as results:
        for chunk, result in results:
            text = study.controllers[chunk.controller]
            if isinstance(result, ChunkFault):
                refuse_changed(study)
                failures[text][chunk.number] = f"runs {chunk.first} to {chunk.stop - 1}: {result.why}"
            else:
                write_whole(folder.file(manifest.controllers[chunk.controller], chunk.number), result)
                made[text] += 1
            clock.tick(chunk)
    folder.write_failures(failures)
    counts = {text: len(numbers) for text, numbers in kept.items()}
    return SweepOutcome(folder.path, cost, made, counts, failures, clock.elapsed)


def _done(
    left: Sequence[Chunk], job: SweepJob, controllers: Sequence[SweptController], workers: int, client: Any
) -> Generator[Done, None, None]:
    """The chunks by the scheduler: threads for kernels, then processes for the rest; or a cluster for all."""
    if client is not None:
        yield from on_cluster(left, job, client)
        return
    slow = [chunk for chunk in left if controllers[chunk.controller].slow]
    yield from in_threads([chunk for chunk in left if not controllers[chunk.controller].slow], job, workers)
    yield from in_processes(slow, job, workers)


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


NEEDED = "a folder that `lwr-dyn sweep` has written"


@dataclass(frozen=True, slots=True, eq=False)
class SweepResults:
    """What a sweep has computed so far.

    `controllers` maps each controller, as typed, to its runs in the order of their numbers; one without any finished
    chunk is not there. `missing` are the numbers of the chunks that have no file, `failures` says why, where a chunk
    was tried.
    """

    folder: Path
    manifest: SweepManifest
    controllers: Mapping[str, ControllerRuns]
    missing: Mapping[str, tuple[int, ...]]
    failures: Mapping[str, Mapping[int, str]]
    __repr__ = short_repr
    _repr_html_ = repr_html

    @classmethod
    def load(cls, folder: str | Path) -> SweepResults:
        """The results in a folder, also while a sweep writes into it.

        Raises
        ------
        FileAccessError
            No sweep in the folder, or a file that is damaged.
        MissingPackageError
            Without pyarrow.
        """
        path = Path(folder)
        if not (path / MANIFEST).exists():
            raise FileAccessError(str(folder), f"no {MANIFEST}", NEEDED)
        manifest = SweepManifest.read(str(path / MANIFEST), read_text(path / MANIFEST, NEEDED))
        found = SweepFolder(path, manifest)
        kept = {one.controller: sorted(found.kept(one)) for one in manifest.controllers}
        controllers = {
            one.controller: joined(
                [decoded(found.file(one, number), one.controller) for number in kept[one.controller]]
            )
            for one in manifest.controllers
            if kept[one.controller]
        }
        missing = {
            one.controller: tuple(sorted(set(range(one.count)) - set(kept[one.controller])))
            for one in manifest.controllers
        }
        return cls(path, manifest, controllers, missing, found.read_failures())

    @property
    def is_complete(self) -> bool:
        """Whether no chunk is missing."""
        return not any(self.missing.values())
