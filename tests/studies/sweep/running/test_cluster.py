"""A Dask cluster: addresses and versions that are refused, workers that die, a scheduler that is lost."""

import os
import re
import signal
import socket
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Thread
from types import SimpleNamespace

import dask
import pytest
from distributed import KilledWorker

from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.studies.sweep.running import cluster
from lwr_dyn.studies.sweep.running.schedulers import Chunk, ChunkFault
from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.running.sweep_folder import versions
from tests.studies.sweep.small import OWN, contents, small_study

CHUNKS = [Chunk(0, k, 4 * k, 4 * k + 4) for k in range(9)]


def work(poison, chunk):
    if chunk.number == poison:
        os.kill(os.getpid(), signal.SIGKILL)
    if chunk.number == 5:
        raise LwrDynError("run 20: no")
    time.sleep(0.02)
    return bytes(range(chunk.first, chunk.stop))


@pytest.fixture(scope="module")
def local_cluster():
    """Two processes; a chunk is given up with its second worker, and a dead worker after a second."""
    from distributed import LocalCluster

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1, "distributed.comm.timeouts.connect": "1s"}),
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as started,
    ):
        yield started


@pytest.mark.slow
def test_a_chunk_that_kills_its_worker_ends_as_a_fault_and_the_rest_is_made(local_cluster):
    with cluster.connected(local_cluster.scheduler_address) as client:
        done = dict(cluster.on_cluster(CHUNKS, partial(work, 3), client))
    assert set(done) == set(CHUNKS)
    assert done.pop(CHUNKS[3]) == ChunkFault("its workers died, again and again")
    assert done.pop(CHUNKS[5]) == ChunkFault("run 20: no")
    assert all(data == bytes(range(chunk.first, chunk.stop)) for chunk, data in done.items())


def test_chunks_whose_workers_died_are_tried_again_one_by_one_in_their_order():
    """On threads in place of workers: chunks 7 and 2 end at their second try, 3 never does."""
    tries, begun = [], []

    def submit(function, run, chunk, pure):
        begun.append((chunk.number, len(tries)))
        return pool.submit(function, run, chunk)

    def fails(chunk):
        time.sleep(0.005)
        tries.append(chunk.number)
        if chunk.number == 3 or (chunk.number in (2, 7) and tries.count(chunk.number) == 1):
            raise KilledWorker("task", None, 1)
        return bytes([chunk.number])

    with ThreadPoolExecutor(1) as pool:
        client = SimpleNamespace(nthreads=lambda: {"a": 1, "b": 2}, submit=submit)
        done = dict(cluster.on_cluster(CHUNKS[::-1], fails, client))
    assert tries == [8, 7, 6, 5, 4, 3, 2, 1, 0, 2, 3, 7]
    assert begun[:6] == [(number, 0) for number in (8, 7, 6, 5, 4, 3)]  # two for each thread of a worker
    assert begun[9:] == [(2, 9), (3, 10), (7, 11)]
    assert done.pop(CHUNKS[3]) == ChunkFault("its workers died, again and again")
    assert done == {chunk: bytes([chunk.number]) for chunk in CHUNKS if chunk.number != 3}


@pytest.mark.slow
def test_a_worker_of_another_version_is_refused(local_cluster, monkeypatch):
    with cluster.connected(local_cluster.scheduler_address):
        pass
    monkeypatch.setattr(cluster, "versions", lambda: versions() | {"llvmlite": "0.1"})
    with pytest.raises(cluster.WorkerVersionError, match=r"worker tcp://\S+ has llvmlite \S+, here is 0\.1"):
        cluster.connected(local_cluster.scheduler_address).__enter__()


@pytest.mark.slow
def test_a_sweep_on_a_cluster_gives_the_bytes_of_one_here_though_a_worker_dies(local_cluster, tmp_path):
    study = small_study(tmp_path)
    sweep(study, tmp_path / "here", threads=1)
    workers = [nanny.pid for nanny in local_cluster.workers.values()]
    chunks = []

    def kill(report):
        if isinstance(report, float):
            chunks.append(report)
            if len(chunks) == 4:
                os.kill(workers[0], signal.SIGKILL)

    done = sweep(study, tmp_path / "there", scheduler=local_cluster.scheduler_address, report=kill)
    assert (done.made, done.failures, done.cost.workers) == ({OWN: 12}, {OWN: {}}, 2)
    assert not Path(f"/proc/{workers[0]}").exists()
    assert contents(tmp_path / "there") == contents(tmp_path / "here")


@pytest.mark.parametrize(
    ("has", "words"),
    [
        ({"numpy": "1", "pyarrow": "2"}, "b has numpy 1, here is 2"),
        ({"pyarrow": "2"}, "b has numpy none, here is 2"),
        ({"lwr_dyn": "none (No module named 'lwr_dyn')"}, "has numpy none"),
        (RuntimeError("no"), "versions that cannot be read: no"),
    ],
)
def test_versions_are_compared_one_by_one(has, words):
    needed = {"numpy": "2", "pyarrow": "2"}
    cluster.refuse_other_versions({"a": needed}, needed)
    with pytest.raises(cluster.WorkerVersionError, match=re.escape(words)):
        cluster.refuse_other_versions({"a": needed, "b": has}, needed)


@pytest.mark.slow
@pytest.mark.parametrize("address", ["nonsense", "http://host:1", "", "tcp://127.0.0.1:{closed}", "127.0.0.1:{other}"])
def test_a_scheduler_that_cannot_be_reached_is_refused(address, monkeypatch):
    monkeypatch.setattr(cluster, "ANSWER", 0.3)
    with socket.create_server(("127.0.0.1", 0)) as closed, socket.create_server(("127.0.0.1", 0)) as other:
        ports = {"closed": closed.getsockname()[1], "other": other.getsockname()[1]}
        closed.close()
        Thread(target=answer, args=(other,), daemon=True).start()
        with pytest.raises(cluster.SchedulerError) as refused:
            cluster.connected(address.format(**ports)).__enter__()
    assert str(refused.value).startswith(f"--scheduler {address.format(**ports)}: ")
    assert "\n" not in str(refused.value)


def answer(server):
    """As a server of another kind does."""
    try:
        with server.accept()[0] as connection:
            connection.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" * 20)
            time.sleep(1)
    except OSError:
        pass


class Deserted:
    """A client whose chunks never end, of a scheduler that is lost or has no workers."""

    def __init__(self, status):
        self.status = status
        self.scheduler = SimpleNamespace(address="tcp://x:1")
        self.released = 0

    def nthreads(self):
        return {"worker": 1}

    def scheduler_info(self):
        return {"workers": {}}

    def submit(self, *_, **__):
        return Endless(self)


@dataclass(eq=False)
class Endless:
    client: Deserted

    def add_done_callback(self, _):
        """It is never called."""

    def release(self):
        self.client.released += 1


@pytest.mark.parametrize(
    ("status", "words"), [("connecting", "the scheduler is lost"), ("running", "no worker for 0.1")]
)
def test_a_cluster_that_is_lost_ends_the_sweep_in_one_line(status, words, monkeypatch):
    monkeypatch.setattr(cluster, "DESERTED", 0.1)
    monkeypatch.setattr(cluster, "_LOOK", 0.02)
    client = Deserted(status)
    with pytest.raises(cluster.SchedulerError, match=f"{words}.*; all finished chunks are kept"):
        list(cluster.on_cluster(CHUNKS, partial(work, None), client))
    assert client.released == 2
