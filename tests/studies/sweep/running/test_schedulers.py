"""Chunks by threads and by processes that die."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter, deque
from contextlib import suppress
from functools import partial
from multiprocessing import Pipe
from pathlib import Path
from threading import Thread
from types import SimpleNamespace

import pytest

from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.studies.sweep.running import schedulers

CHUNKS = [schedulers.Chunk(0, k, 4 * k, 4 * k + 4) for k in range(6)]


def work(folder, chunk):
    """Chunk 1 kills its process each time, chunk 2 the first time, chunk 3 is refused."""
    if chunk.number == 1 or (chunk.number == 2 and not (folder / "died").exists()):
        (folder / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if chunk.number == 3:
        raise LwrDynError("run 13: no")
    return bytes(range(chunk.first, chunk.stop))


class Unreadable:
    """Work that a process cannot read."""

    def __reduce__(self):
        return os._exit, (3,)


@pytest.mark.slow
def test_a_process_that_dies_costs_its_own_chunk_only(tmp_path):
    done = dict(schedulers.in_processes(CHUNKS, partial(work, tmp_path), 2))
    assert set(done) == set(CHUNKS)
    for chunk in (CHUNKS[k] for k in (0, 2, 4, 5)):
        assert done[chunk] == bytes(range(chunk.first, chunk.stop))
    assert done[CHUNKS[1]] == schedulers.ChunkFault(f"its process died {schedulers.TRIES} times (killed by SIGKILL)")
    assert done[CHUNKS[3]] == schedulers.ChunkFault("run 13: no")


def test_a_process_without_its_first_one_ends(monkeypatch):
    parents, slept = iter([5, 5, 1, 5]), []

    def ended(code):
        raise SystemExit(code)

    monkeypatch.setattr(schedulers, "os", SimpleNamespace(getppid=lambda: next(parents), _exit=ended))
    monkeypatch.setattr(schedulers, "time", SimpleNamespace(sleep=slept.append))
    with pytest.raises(SystemExit, match="1"):
        schedulers._end_with(5)
    assert slept == [0.2, 0.2]


def test_a_chunk_that_kills_its_process_goes_to_the_end_and_is_given_up_the_third_time():
    def worker(ready=True, chunk=CHUNKS[1]):
        process = SimpleNamespace(join=lambda *_: None, kill=lambda: None, exitcode=-9)
        return schedulers._Worker(process, SimpleNamespace(close=lambda: None), chunk, ready)

    deaths, left = Counter(), deque([CHUNKS[2]])
    assert list(schedulers._died(worker(), deaths, left)) == list(schedulers._died(worker(), deaths, left)) == []
    assert list(left) == [CHUNKS[2], CHUNKS[1], CHUNKS[1]]
    why = schedulers.ChunkFault("its process died 3 times (killed by SIGKILL)")
    assert list(schedulers._died(worker(), deaths, left)) == [(CHUNKS[1], why)]
    for begun in (worker(ready=False), worker(chunk=None)):
        with pytest.raises(schedulers.WorkerStartError, match=r"before its first one \(killed by SIGKILL\)"):
            list(schedulers._died(begun, deaths, left))


def test_a_process_is_spawned_with_its_work_and_one_end_of_a_pipe(monkeypatch):
    made = []

    class Process:
        def __init__(self, **given):
            made.append(given)

        def start(self):
            made.append("started")

    def context(kind):
        made.append(kind)
        return SimpleNamespace(Pipe=Pipe, Process=Process)

    monkeypatch.setattr(schedulers, "get_context", context)
    worker = schedulers._started(work)
    there, sent = made[1].pop("args")
    assert made == ["spawn", {"target": schedulers._serve, "daemon": True}, "started"]
    assert (sent, there.closed, worker.pipe.closed, worker.chunk, worker.ready) == (work, True, False, None, False)


@pytest.fixture
def served(monkeypatch):
    """Threads in place of processes: one that raises SystemExit is a process that ends with exit code 3."""
    begun = []

    def started(work):
        here, there = Pipe()

        def serve():
            with suppress(SystemExit):
                schedulers._serve(there, work)
            there.close()

        begun.append(Thread(target=serve, daemon=True))
        begun[-1].start()
        process = SimpleNamespace(join=lambda *_: None, kill=lambda: None, exitcode=3)
        return schedulers._Worker(process, here)

    monkeypatch.setattr(schedulers, "_started", started)
    monkeypatch.setattr(schedulers.signal, "signal", lambda *_: None)  # of the first thread alone
    monkeypatch.setattr(schedulers, "_end_with", lambda first: None)
    return begun


def test_workers_take_chunks_one_by_one_and_are_replaced_when_they_die(served):
    def made(chunk):
        if chunk.number == 1:
            raise SystemExit
        return work(None, chunk) if chunk.number == 3 else bytes(range(chunk.first, chunk.stop))

    done = list(schedulers.in_processes(CHUNKS, made, 2))
    assert sorted(chunk for chunk, _ in done) == CHUNKS
    found = dict(done)
    assert found.pop(CHUNKS[1]) == schedulers.ChunkFault("its process died 3 times (exit code 3)")
    assert found.pop(CHUNKS[3]) == schedulers.ChunkFault("run 13: no")
    assert found == {chunk: bytes(range(chunk.first, chunk.stop)) for chunk in (CHUNKS[k] for k in (0, 2, 4, 5))}
    assert 3 <= len(served) <= 5  # two, and one more where a death leaves more chunks than idle workers
    for thread in served:
        thread.join(10)
        assert not thread.is_alive()
    with pytest.raises(RuntimeError, match="ZeroDivisionError: "):
        list(schedulers.in_processes(CHUNKS, lambda chunk: 1 // 0, 1))
    assert list(schedulers.in_processes([], made, 2)) == []


def test_workers_that_die_before_they_begin_end_the_sweep(served, monkeypatch):
    def ended(pipe, work):
        raise SystemExit

    monkeypatch.setattr(schedulers, "_serve", ended)
    with pytest.raises(schedulers.WorkerStartError, match=r"before its first one \(exit code 3\); allowed: a smaller"):
        list(schedulers.in_processes(CHUNKS, work, 1))


@pytest.mark.slow
def test_processes_that_cannot_begin_end_the_sweep():
    with pytest.raises(schedulers.WorkerStartError, match="exit code 3"):
        list(schedulers.in_processes(CHUNKS, Unreadable(), 1))


def test_threads_make_every_chunk_once_and_raise_what_is_a_fault_of_the_package(tmp_path):
    seen = []

    def made(chunk):
        seen.append(chunk)
        return work(tmp_path, chunk)

    (tmp_path / "died").touch()
    chunks = [chunk for chunk in CHUNKS if chunk.number != 1]
    done = dict(schedulers.in_threads(chunks, made, 3))
    assert sorted(seen) == chunks == sorted(done)
    assert done[CHUNKS[3]] == schedulers.ChunkFault("run 13: no")
    assert done[CHUNKS[5]] == bytes(range(20, 24))
    with pytest.raises(ZeroDivisionError):
        list(schedulers.in_threads(chunks, lambda chunk: 1 // 0, 2))


FIRST = """
import time
from functools import partial
from tests.studies.sweep.running.test_schedulers import CHUNKS, waits
from lwr_dyn.studies.sweep.running.schedulers import in_processes
if __name__ == "__main__":
    list(in_processes(CHUNKS, partial(waits, FILE), 1))
"""


def waits(path, chunk):
    Path(path).write_text(str(os.getpid()))
    time.sleep(60)
    return b""


@pytest.mark.slow
def test_processes_end_with_a_first_one_that_is_killed(tmp_path):
    script, said = tmp_path / "first.py", tmp_path / "said"
    script.write_text(FIRST.replace("FILE", repr(str(said))))
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[4])}
    first = subprocess.Popen([sys.executable, str(script)], env=environment)
    while not (said.exists() and said.read_text()):
        assert first.poll() is None
        time.sleep(0.02)
    first.kill()
    first.wait()
    worker = int(said.read_text())
    for _ in range(500):
        if not Path(f"/proc/{worker}").exists():
            break
        time.sleep(0.02)
    else:
        pytest.fail("the worker goes on")
