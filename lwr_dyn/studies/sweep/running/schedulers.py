"""Chunks by threads, and by processes for controllers in Python, where one that dies costs its chunk and no other.

A pool of the standard library breaks whole when a process dies. Here each process has a pipe of its own: a chunk goes
in, its file comes out, and the end of the pipe means death.
"""

import os
import signal
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from threading import Thread
from typing import Any

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
                for future in wait_for(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


TRIES = 3
"""How often a chunk may kill its process."""
_LOOK = 0.2
"""[s] Between two looks for the parent."""


class WorkerStartError(LwrDynError, OSError):
    """A process for the runs of a sweep dies before it begins."""

    def __init__(self, words: str) -> None:
        super().__init__(f"a process for the runs ends before its first one ({words}); allowed: a smaller --jobs")


@dataclass(slots=True, eq=False)
class _Worker:
    process: Any
    pipe: Connection
    chunk: Chunk | None = None
    ready: bool = False

    def give(self, chunk: Chunk) -> None:
        """A chunk to make; where the process is dead, the end of the pipe says so later."""
        self.chunk = chunk
        with suppress(BrokenPipeError, ConnectionResetError):
            self.pipe.send(chunk)

    def answer(self) -> Done | bool | None:
        """What it says: that it has begun (True), or its chunk; None when it is dead."""
        try:
            said = self.pipe.recv()
        except (EOFError, ConnectionResetError):
            return None
        if isinstance(said, BaseException):
            raise said
        if said is True:
            self.ready = True
            return True
        chunk, self.chunk = self.chunk, None
        assert chunk is not None  # it answers only what it was given
        return chunk, said

    def end(self) -> str:
        """End the process; how it ended, in words."""
        self.pipe.close()
        self.process.join(0.2)
        self.process.kill()
        self.process.join()
        code = self.process.exitcode
        return f"killed by {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit code {code}"


def in_processes(chunks: Iterable[Chunk], work: Work, processes: int) -> Iterator[Done]:
    """The chunks as they are done; `work` is sent to each process once and must be picklable.

    A chunk whose process dies `TRIES` times is a `ChunkFault`. Raises `WorkerStartError`.
    """
    left, deaths, workers = deque(chunks), Counter[Chunk](), list[_Worker]()
    try:
        while left or any(worker.chunk for worker in workers):
            while len(workers) < processes and len(left) > sum(worker.chunk is None for worker in workers):
                workers.append(_started(work))
            for worker in [worker for worker in workers if worker.chunk is None][: len(left)]:
                worker.give(left.popleft())
            ended = wait([worker.pipe for worker in workers if worker.chunk])
            for worker in [worker for worker in workers if worker.pipe in ended]:
                said = worker.answer()
                if said is None:
                    workers.remove(worker)
                    yield from _died(worker, deaths, left)
                elif not isinstance(said, bool):
                    yield said
    finally:
        for worker in workers:
            worker.end()


def _died(worker: _Worker, deaths: Counter[Chunk], left: deque[Chunk]) -> Iterator[Done]:
    """Put the chunk of a dead process at the end of the line, or give it up."""
    words, chunk = worker.end(), worker.chunk
    if not worker.ready or chunk is None:
        raise WorkerStartError(words)
    deaths[chunk] += 1
    if deaths[chunk] < TRIES:
        left.append(chunk)
    else:
        yield chunk, ChunkFault(f"its process died {TRIES} times ({words})")


def _started(work: Work) -> _Worker:
    context = get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, work), daemon=True)
    process.start()
    there.close()
    return _Worker(process, here)


def _serve(pipe: Connection, work: Work) -> None:
    """Make chunks until the pipe ends; ends at once when the first process is gone, in the middle of a run too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the first process
    Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        pipe.send(True)
        while True:
            chunk = pipe.recv()
            try:
                said: Any = outcome(work, chunk)
            except Exception as fault:  # a fault of this package, raised again in the first process
                said = RuntimeError(f"{type(fault).__name__}: {fault}")
            pipe.send(said)


def _end_with(first: int) -> None:
    """End this process once its parent is another than `first`: a killed one leaves its children to the system."""
    while os.getppid() == first:
        time.sleep(_LOOK)
    os._exit(1)
