"""The first run of each controller without a kernel, for the cost: in a process of its own, which may die."""

import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.studies.sweep.running.chunk_file import encoded
from lwr_dyn.studies.sweep.running.processes import in_processes
from lwr_dyn.studies.sweep.running.tasks import Chunk, ChunkFault
from lwr_dyn.studies.sweep.running.workshop import workshop_of
from lwr_dyn.studies.sweep.study.study_file import SweepStudy

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
        workshop = workshop_of(self.study)
        start = time.thread_time()
        runs, _ = workshop.runs(self.study.controllers[chunk.controller], chunk.first, chunk.stop)
        size = len(encoded(runs, ""))
        return _ANSWER.pack(time.thread_time() - start, size)


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
