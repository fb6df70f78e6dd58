"""Chunks on a Dask cluster that runs already: its scheduler is asked first, its workers' versions are compared, and a
worker that dies costs time only.

A worker sends the bytes of a file of results, and this process writes them. What a study names (robot, controllers,
files of the task) every worker reads itself: with the same content under the same path as here.
"""

import asyncio
import logging
import socket
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from typing import Any

from lwr_dyn.foundation.errors import LwrDynError, MissingPackageError
from lwr_dyn.foundation.files import reason_of
from lwr_dyn.studies.sweep.running.schedulers import Chunk, ChunkFault, Done, Work, outcome
from lwr_dyn.studies.sweep.running.sweep_folder import versions

ANSWER = 10.0
"""[s] A scheduler has to answer."""
DESERTED = 60.0
"""[s] Without any worker the sweep ends; a worker that dies is usually started again within seconds."""
_LOOK = 2.0
_SHORT = 0.1
_DASK = "distributed"
_AHEAD = 2
"""Chunks in the hands of the cluster, for each thread of a worker."""


class SchedulerError(LwrDynError, ConnectionError):
    """A Dask scheduler does not answer, or is lost: its `address` and the `fault`."""

    def __init__(self, address: str, fault: str, allowed: str) -> None:
        super().__init__(f"--scheduler {address}: {fault}; allowed: {allowed}")
        self.address, self.fault = address, fault


class WorkerVersionError(LwrDynError, RuntimeError):
    """A worker of a cluster has other versions than this process, or lacks a package."""

    def __init__(self, worker: str, package: str, found: str, needed: str) -> None:
        super().__init__(
            f"worker {worker} has {package} {found}, here is {needed}; allowed: the same versions everywhere"
        )
        self.worker, self.package, self.found, self.needed = worker, package, found, needed


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """A client of the cluster, whose workers have the versions of this process.

    Raises
    ------
    SchedulerError
        No Dask scheduler answers there, or it has no workers.
    WorkerVersionError
        A worker has another version of what numbers and bytes depend on.
    MissingPackageError
        Without dask and distributed.
    """
    try:
        from distributed import Client
    except ImportError:
        raise MissingPackageError("distributed", "sweeps") from None
    with _quiet():
        _ask(address)
        with Client(address, timeout=ANSWER, set_as_default=False) as client:
            refuse_other_versions(_versions_of_workers(client))
            yield client


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask's own messages left out: what matters is said in one line."""
    loggers = [logging.getLogger(n) for n in list(logging.root.manager.loggerDict) if n.partition(".")[0] == _DASK]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)


def refuse_other_versions(found: Mapping[str, Any], needed: Mapping[str, str] | None = None) -> None:
    """Raise `WorkerVersionError` for the first worker -> package -> version that differs from `needed`, as here.

    >>> refuse_other_versions({"tcp://10.0.0.7:40000": {"numpy": "1.0"}}, {"numpy": "2.0"})
    Traceback (most recent call last):
    lwr_dyn.studies.sweep.running.cluster.WorkerVersionError: worker tcp://10.0.0.7:40000 has numpy 1.0, here is 2...
    """
    for worker, has in sorted(found.items()):
        if not isinstance(has, dict):
            raise WorkerVersionError(worker, "versions that cannot be read:", str(has), "a worker that answers")
        for package, version in (needed or versions()).items():
            if has.get(package) != version:
                raise WorkerVersionError(worker, package, has.get(package, "none"), version)


def on_cluster(chunks: Iterable[Chunk], work: Work, client: Any) -> Iterator[Done]:
    """The chunks as they are done; `work` must be picklable.

    The scheduler gives a chunk up once several workers have died while they had it, which may be the fault of another
    one. Such a chunk is tried again at the end, alone; if it then kills its workers again, it is a `ChunkFault`.
    """
    suspects: list[Chunk] = []
    threads = sum(client.nthreads().values())
    for chunk, result in _done(deque(chunks), work, client, max(1, _AHEAD * threads)):
        if result is None:
            suspects.append(chunk)
        else:
            yield chunk, result
    for chunk, result in _done(deque(sorted(suspects)), work, client, 1):
        yield chunk, ChunkFault("its workers died, again and again") if result is None else result


def _done(left: deque[Chunk], work: Work, client: Any, most: int) -> Iterator[tuple[Chunk, bytes | ChunkFault | None]]:
    """The chunks as they are done, at most so many at once; None for one whose workers died."""
    from distributed import KilledWorker

    ended: SimpleQueue[Any] = SimpleQueue()
    running: dict[Any, Chunk] = {}
    try:
        while left or running:
            while left and len(running) < most:
                chunk = left.popleft()
                future = client.submit(outcome, work, chunk, pure=False)
                running[future] = chunk
                future.add_done_callback(ended.put)
            future = _next(ended, client)
            try:
                result = future.result()
            except KilledWorker:
                result = None
            except Exception as fault:
                _refuse_lost(client, fault)
                raise
            yield running.pop(future), result
            del future  # the worker forgets the bytes
    finally:
        for future in running:
            future.release()


def _next(ended: SimpleQueue[Any], client: Any) -> Any:
    """The next future that has ended; raises `SchedulerError` once no scheduler or no worker is left."""
    alone = 0.0
    while True:
        try:
            return ended.get(timeout=_LOOK)
        except Empty:
            _refuse_lost(client)
            alone = 0.0 if client.scheduler_info()["workers"] else alone + _LOOK
            if alone >= DESERTED:
                gone = f"no worker for {DESERTED:g} s; all finished chunks are kept"
                raise SchedulerError(client.scheduler.address, gone, "a cluster with workers") from None


def _refuse_lost(client: Any, fault: Exception | None = None) -> None:
    from distributed.client import FutureCancelledError

    if client.status != "running" or isinstance(fault, FutureCancelledError):
        gone = "the scheduler is lost; all finished chunks are kept"
        raise SchedulerError(client.scheduler.address, gone, "the same command again, with a scheduler that runs")


def _ask(address: str) -> None:
    """Raise `SchedulerError` unless a Dask scheduler with workers answers; a client that fails would go on trying."""
    from distributed.comm import get_address_host_port
    from distributed.core import rpc
    from distributed.security import Security

    async def identity() -> Any:
        async with rpc(address, timeout=ANSWER, connection_args=Security().get_connection_args("client")) as scheduler:
            return await asyncio.wait_for(scheduler.identity(), ANSWER)

    allowed = "the address that `dask scheduler` prints, such as tcp://10.0.0.5:8786"
    try:
        place = get_address_host_port(address)
        if address.partition("://")[0] in (address, "tcp", "tls"):  # where nothing listens Dask would try again
            socket.create_connection(place, timeout=ANSWER).close()
        found = asyncio.run(identity())
    except ValueError as fault:
        raise SchedulerError(address, str(fault), allowed) from None
    except (ConnectionRefusedError, socket.gaierror) as fault:
        raise SchedulerError(address, reason_of(fault), allowed) from None
    except (OSError, TimeoutError):
        raise SchedulerError(address, f"does not answer within {ANSWER:g} s", allowed) from None
    except Exception:  # what another kind of server answers can be read as anything
        raise SchedulerError(address, "what answers there is no Dask scheduler", allowed) from None
    if found.get("type") != "Scheduler":
        raise SchedulerError(address, f"what answers there is a {found.get('type', 'stranger')}", allowed)


def _versions_of_workers(client: Any) -> Mapping[str, Any]:
    """What each worker says; those that died while they were asked have been replaced a moment later."""

    def found() -> dict[str, str]:  # a function of this kind is sent whole, and does not need lwr_dyn there
        try:
            from lwr_dyn.studies.sweep.running.sweep_folder import versions
        except ImportError as fault:
            return {"lwr_dyn": f"none ({fault})"}
        return versions()

    answers: Mapping[str, Any] = {}
    begin = time.monotonic()
    while not answers or any(isinstance(each, OSError) for each in answers.values()):
        if time.monotonic() - begin > 2 * ANSWER:
            break
        time.sleep(_SHORT)
        answers = client.run(found, on_error="return")
    if not answers:
        raise SchedulerError(client.scheduler.address, "the scheduler has no workers", "a cluster with workers")
    return answers
