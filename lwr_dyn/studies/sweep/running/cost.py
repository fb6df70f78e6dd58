"""What a sweep will cost, stated ahead: measured on its first runs."""

import resource
import struct
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isnan

from lwr_dyn.codegen.rollouts.substeps import Steps
from lwr_dyn.foundation.document import Fact, Section
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.studies.sweep.running.chunk_file import encoded
from lwr_dyn.studies.sweep.running.schedulers import Chunk, ChunkFault, in_processes
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop, workshop_of
from lwr_dyn.studies.sweep.sweep_study import SweepStudy

ENOUGH = 0.3
"""[s] Of processor time, from which on a measurement counts."""
MOST = 256
"""Runs that are measured at most."""
_KEPT = 6
"""Copies of the numbers of a chunk that a thread holds at most: parameters, metrics, columns, the file."""
_READ = 1.6
"""Memory of all results, which the report reads, over the size of their files: 1.5 of 600 000 runs in 446 MB."""


@dataclass(frozen=True, slots=True)
class ControllerCost:
    """Of one controller: [s] of processor time a run and for each chunk beside, measured on so many runs.

    `bytes` are those of the file, a run.
    """

    controller: str
    runs: int
    chunk: int
    seconds: float
    aside: float
    bytes: float
    measured: int
    slow: bool
    """Whether `simulate` makes the runs, in processes of their own."""
    steps: Steps | None = None
    """The study's substeps of smooth friction, with their error; None without it, and for `simulate`."""
    better: Steps | None = None
    """Where that error is 1e-6 rad or more: substeps that leave less."""

    @property
    def step_words(self) -> str:
        """The error of the step where it is not small, in one line; empty where it is."""
        if self.steps is None or self.steps.are_enough:
            return ""
        if isnan(self.steps.error):
            return f"{self.controller}: no run that a kernel follows shows the error of the step"
        words = f"{self.controller}: smooth friction leaves positions up to {self.steps.error:.1g} rad off (estimated)"
        if self.better is None or self.better.substeps == self.steps.substeps:
            return f"{words}; smaller steps change as much: the loop amplifies what is small"
        return f"{words}; loop.substeps = {self.better.substeps} leaves {self.better.error:.1g} rad"

    def of(self, runs: int) -> float:
        """[s] Processor time of a chunk of so many runs."""
        return self.aside + runs * self.seconds

    @property
    def processor(self) -> float:
        """[s] Processor time of all runs."""
        return -(-self.runs // self.chunk) * self.aside + self.runs * self.seconds


@dataclass(frozen=True, slots=True)
class SweepCost:
    """Of all controllers, on so many threads or processes."""

    controllers: tuple[ControllerCost, ...]
    workers: int
    memory: float
    """[bytes]"""

    @property
    def runs(self) -> int:
        """Of all controllers."""
        return sum(one.runs for one in self.controllers)

    @property
    def processor(self) -> float:
        """[s] Processor time."""
        return sum(one.processor for one in self.controllers)

    @property
    def seconds(self) -> float:
        """[s] By the clock, if the workers are as fast as this processor and have it to themselves."""
        return self.processor / self.workers

    @property
    def disk(self) -> float:
        """[bytes] Of the files."""
        return sum(one.runs * one.bytes for one in self.controllers)

    @property
    def words(self) -> str:
        """The statement in one line."""
        time_, space = duration(self.seconds), f"{size(self.memory)} of memory, {size(self.disk)} of files"
        on = f"{self.workers} worker{'s' if self.workers > 1 else ''}"
        return f"about {time_} on {on} ({duration(self.processor)} of processor time), {space}"

    def table(self) -> Table:
        """The statement, a row a controller."""
        rows = [
            (one.controller, one.runs, 1e3 * one.processor / one.runs,
             "simulate, in processes" if one.slow else "kernel", one.measured,
             None if one.steps is None or isnan(one.steps.error) else one.steps.error)
            for one in self.controllers
        ]  # fmt: skip
        step_error = ("step error", "rad") if any(one.steps for one in self.controllers) else ("", "")
        headings = (
            Heading("controller", says="As the study has it."), Heading("runs", format=",d", says="Of it."),
            Heading("a run", "ms", ".3g", "run_ms", "Processor time a run, ms."),
            Heading("by", says="What computes the runs."),
            Heading("measured on", "runs", "d", "measured", "Runs on which it was measured."),
            Heading(*step_error, ".1g", "step_error",
                    "Of positions by the step of smooth friction, estimated; null without it, and for simulate.",
                    kind=float | None),
        )  # fmt: skip
        return Table("Cost", headings, rows, self.words)

    def section(self) -> Section:
        """The statement in the record of a document."""
        return Section("", [
            Fact("runs", self.runs, "Of all controllers."), Fact("processor_s", self.processor, "Processor time, s."),
            Fact("seconds", self.seconds, "By the clock, s."),
            Fact("workers", self.workers, "Threads, processes, or threads of a cluster."),
            Fact("memory_bytes", self.memory, "Of this process at most."),
            Fact("disk_bytes", self.disk, "Of the files."),
            replace(self.table(), key="controllers", says="One record a controller.", when=False),
        ], "cost", "As stated ahead.")  # fmt: skip


def measured(workshop: SweepWorkshop, controller: str, runs: int, chunk: int) -> tuple[ControllerCost, str]:
    """The cost of a controller with a kernel, from its first runs, and the digest of the kernel.

    Raises as `SweepWorkshop.runs`, so that a study that cannot run ends here.
    """
    least = min(2, runs)  # one run alone has a kernel of its own, in scalar code
    _timed(workshop, controller, least)  # compiles the kernel
    few, size, kernel = _timed(workshop, controller, least)
    count, spent = least, few
    while spent < few + ENOUGH and count < min(MOST, runs):
        count = min(4 * count, MOST, runs)
        spent, size, _ = _timed(workshop, controller, count)
    seconds = max(spent - few, 0.0) / (count - least) if count > least else few / least
    aside = max(few - least * seconds, 0.0)
    cost = ControllerCost(controller, runs, chunk, seconds, aside, size / count, count, False)
    found = workshop.steps(controller)
    better = workshop.enough_steps(controller) if found is not None and not found.are_enough else None
    return replace(cost, steps=found, better=better), kernel


def _timed(workshop: SweepWorkshop, controller: str, count: int) -> tuple[float, int, str]:
    """[s] of processor time for the first so many runs, [bytes] of their file, and what made them."""
    start = time.thread_time()
    runs, kernel = workshop.runs(controller, 0, count)
    size = len(encoded(runs, ""))
    return time.thread_time() - start, size, kernel


def memory(costs: Sequence[ControllerCost], workers: int) -> float:
    """[bytes] What this process holds, with a chunk a worker or all results for the report.

    Processes for `simulate` are as large as this one.
    """
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    chunks = workers * _KEPT * max(one.chunk * one.bytes for one in costs)
    results = _READ * sum(one.runs * one.bytes for one in costs)
    return peak * (1 + workers * any(one.slow for one in costs)) + max(chunks, results)


def duration(seconds: float) -> str:
    """A time in words.

    >>> duration(0.3), duration(95), duration(7300)
    ('1 s', '2 min', '2 h 2 min')
    """
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"


def size(count: float) -> str:
    """Bytes in words.

    >>> size(4.2e8), size(2.5e9)
    ('420 MB', '2.5 GB')
    """
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{max(1, round(count / 1e6))} MB"


_ANSWER = struct.Struct("<dQ")


class FirstRunError(LwrDynError, RuntimeError):
    """The first run of a `controller` fails, so that its cost is not known."""

    def __init__(self, controller: str, why: str) -> None:
        super().__init__(f"first run of {controller}: {why}")
        self.controller = controller


@dataclass(frozen=True, slots=True)
class FirstRun:
    """Makes first runs of a study; the answer is the processor time [s] and the size of the file [bytes]."""

    study: SweepStudy

    def __call__(self, chunk: Chunk) -> bytes:
        """The packed answer of a chunk; raises as `SweepWorkshop.runs`."""
        spent, size, _ = _timed(workshop_of(self.study), self.study.controllers[chunk.controller], 1)
        return _ANSWER.pack(spent, size)


def first_runs(study: SweepStudy, controllers: Sequence[int]) -> dict[int, tuple[float, float]]:
    """Number of a controller -> processor time [s] and size [bytes] of its first run.

    Raises `FirstRunError` where a run fails or its process dies again and again, and as `in_processes`.
    """
    found: dict[int, tuple[float, float]] = {}
    for chunk, answer in in_processes([Chunk(i, 0, 0, 1) for i in controllers], FirstRun(study), 1):
        if isinstance(answer, ChunkFault):
            raise FirstRunError(study.controllers[chunk.controller], answer.why)
        found[chunk.controller] = _ANSWER.unpack(answer)
    return found
