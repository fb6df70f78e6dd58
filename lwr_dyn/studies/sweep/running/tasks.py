"""What the schedulers carry out: chunks, each the bytes of a file, or the reason why there are none."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass

from lwr_dyn.foundation.errors import LwrDynError


@dataclass(frozen=True, slots=True, order=True)
class Chunk:
    """Runs `first` to `stop` (without it) of controller number `controller`; `number` counts its chunks."""

    controller: int
    number: int
    first: int
    stop: int

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.stop - self.first


@dataclass(frozen=True, slots=True)
class ChunkFault:
    """Why a chunk has no file."""

    why: str


Work = Callable[[Chunk], bytes]
"""Makes the file of a chunk."""
Done = tuple[Chunk, bytes | ChunkFault]


def outcome(work: Work, chunk: Chunk) -> bytes | ChunkFault:
    """The file, or what this package says against it; raises what is a fault of this package."""
    try:
        return work(chunk)
    except LwrDynError as fault:
        return ChunkFault(str(fault))


def in_threads(chunks: Iterable[Chunk], work: Work, threads: int) -> Iterator[Done]:
    """The chunks as they are done, by threads of this process; few are begun ahead of what is taken."""
    left = deque(chunks)
    with ThreadPoolExecutor(threads, thread_name_prefix="lwr_dyn_sweep") as pool:
        running: dict[Future[bytes | ChunkFault], Chunk] = {}
        try:
            while left or running:
                while left and len(running) < threads + 1:
                    chunk = left.popleft()
                    running[pool.submit(outcome, work, chunk)] = chunk
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
