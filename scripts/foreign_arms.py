"""`lwr-dyn check` on every URDF of the installed packages: what holds, fails, is refused, crashes or takes too long.

Each file runs in a process of its own with a limit of 30 s of CPU time (a busy machine stretches wall time). A tree
gets the options that its own refusal asks for: the first tip that it lists, and joints locked at 0 or the middle of
their range. Files of the same content count once. Exit 1 for a traceback or a file over the limit.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import queue
import re
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from lwr_dyn.arms.urdf.parse import parse_urdf
from lwr_dyn.arms.urdf.tree import position_limits
from lwr_dyn.foundation.errors import LwrDynError

LIMIT = 30.0
"""[s] Longest CPU time for one file."""
BAD_KINDS = {"crashed", "over the limit"}
_MOVING = re.compile(rb"type\s*=\s*[\"'](revolute|continuous|prismatic|planar|floating)[\"']")
_WORKER = """
import json, os, resource, sys, tempfile
import lwr_dyn.checks.arm.run_checks, lwr_dyn.cli.check, lwr_dyn.arms.urdf.reader, yourdfpy
from lwr_dyn.cli.main import main

def child(arguments, limit, files):
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    for number, file in zip((1, 2), files):
        os.dup2(file.fileno(), number)
    code = 3
    try:
        main(arguments)
    except SystemExit as end:
        code = end.code or 0
    except BaseException as fault:
        print(f"Traceback: {type(fault).__name__}: {fault}", file=sys.stderr)
    sys.stdout.flush(), sys.stderr.flush()
    os._exit(code)

for line in sys.stdin:
    limit, *arguments = json.loads(line)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        pid = os.fork() or child(arguments, limit, (out, err))
        _, status, usage = os.wait4(pid, 0)
        out.seek(0), err.seek(0)
        texts = [file.read().decode() for file in (out, err)]
    record = [os.waitstatus_to_exitcode(status), *texts, usage.ru_utime + usage.ru_stime]
    print(json.dumps(record), flush=True)
"""
T = TypeVar("T")
_ROUNDS = 5
"""Runs of one file: as it is, with a tip, with locks, with more locks (mimics)."""


@dataclass(frozen=True, slots=True)
class Done:
    """A finished run: exit code, stdout, stderr, CPU time [s]."""

    code: int
    out: str
    err: str
    seconds: float


@dataclass(frozen=True, slots=True)
class Outcome:
    """What `check` made of one file: kind, the gist of its line or the checks that fail, options, seconds."""

    file: Path
    kind: str
    gist: str
    options: tuple[str, ...]
    seconds: float


def installed_urdfs(folders: Iterable[str | Path]) -> list[Path]:
    """Every file under these folders that ends in .urdf, in any case; of equal files the first."""
    found: dict[str, Path] = {}
    for folder in folders:
        for path in sorted(Path(folder).rglob("*")):
            if path.suffix.lower() == ".urdf" and path.is_file():
                found.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), path)
    return list(found.values())


def has_moving_joint(path: Path) -> bool:
    """Whether a joint of the file moves; boxes and tables are not arms."""
    return _MOVING.search(path.read_bytes()) is not None


class Worker:
    """A process that has imported everything, and forks for each command."""

    def __init__(self) -> None:
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        environment["PYTHONPATH"] = os.pathsep.join(sys.path)
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen([sys.executable, "-c", _WORKER], text=True, env=environment, **pipes)

    def run(self, arguments: Sequence[str], limit: float) -> Done:
        """One run of `lwr-dyn`, with a limit of CPU time [s]."""
        print(json.dumps([int(limit), *arguments]), file=self.process.stdin, flush=True)
        return Done(*json.loads(self.process.stdout.readline()))

    def close(self) -> None:
        """End the process."""
        self.process.communicate()


def check_file(path: Path, worker: Worker, limit: float = LIMIT) -> Outcome:
    """The outcome of one file, with the options that its refusals ask for."""
    options: tuple[str, ...] = ()
    for _ in range(_ROUNDS):
        done = worker.run(("check", str(path), "--json", *options), limit)
        added = _asked_for(path, _refusal(done))
        if not added:
            break
        options += added
    return Outcome(path, *_judged(path, done), options, done.seconds)


def _judged(path: Path, done: Done) -> tuple[str, str]:
    """Kind and gist of a finished run."""
    lines = done.err.strip().splitlines()
    if done.code == -signal.SIGXCPU:
        return "over the limit", f"more than {done.seconds:.0f} s"
    if done.code == 2 and len(lines) == 1 and lines[0].startswith("lwr-dyn: "):
        return "refused", lines[0].removeprefix(f"lwr-dyn: {path.name}: ")
    if done.code not in (0, 1) or any("Traceback" in line for line in lines):
        return "crashed", lines[-1] if lines else f"exit code {done.code}"
    record = json.loads(done.out)
    failed = [verdict["name"] for verdict in record["verdicts"] if not verdict["holds"]]
    return ("fails", ", ".join(failed)) if failed else ("holds", f"{len(record['verdicts'])} checks")


def _refusal(done: Done) -> str:
    """The line that refuses the chain: the error, or what `check` says that it left out of a tree."""
    if done.code not in (0, 1) or not done.out:
        return done.err
    return "".join(note for note in json.loads(done.out).get("notes", ()) if "skipped: " in note)


def _asked_for(path: Path, message: str) -> tuple[str, ...]:
    """The options that a refusal asks for: a tip, or locks of joints."""
    tip = re.search(r"--tip:? (\S+?),? (?:\(\d|or )", message)
    if tip:
        return ("--tip", tip[1])
    locks = re.findall(r"--lock (\S+)=VALUE", message)
    try:
        urdf = parse_urdf(path)
    except LwrDynError:
        return ()
    return tuple(word for name in locks for word in ("--lock", f"{name}={_inside(urdf.joints[name])!r}"))


def _inside(joint: object) -> float:
    """0, or the middle of a range without it."""
    low, up = position_limits(joint)
    return 0.0 if low is None or up is None or low <= 0.0 <= up else (low + up) / 2


def of_each(judge: Callable[[Path, Worker], T], paths: Sequence[Path], processes: int) -> list[T]:
    """What `judge` makes of every file, in their order; each call has a worker to itself."""
    workers: queue.Queue[Worker] = queue.Queue()
    for _ in range(processes):
        workers.put(Worker())

    def one(path: Path) -> T:
        worker = workers.get()
        try:
            return judge(path, worker)
        finally:
            workers.put(worker)

    with ThreadPoolExecutor(processes) as pool:
        found = list(pool.map(one, paths))
    for _ in range(processes):
        workers.get().close()
    return found


def survey(paths: Sequence[Path], processes: int, limit: float = LIMIT) -> list[Outcome]:
    """The outcome of every file; each is printed on stderr when it is there."""

    def outcome(path: Path, worker: Worker) -> Outcome:
        result = check_file(path, worker, limit)
        print(_line(result), file=sys.stderr, flush=True)
        return result

    return of_each(outcome, paths, processes)


def table(outcomes: Sequence[Outcome]) -> str:
    """Counts by outcome, then one line a file."""
    counts = Counter(outcome.kind for outcome in outcomes)
    lines = [f"{kind}: {count}" for kind, count in counts.most_common()]
    lines.append(f"read without options: {sum(x.kind != 'refused' and not x.options for x in outcomes)}")
    return "\n".join(lines + [_line(outcome) for outcome in sorted(outcomes, key=lambda x: (x.kind, x.gist))])


def _line(outcome: Outcome) -> str:
    options = " ".join(outcome.options)[:60]
    return f"{outcome.kind} | {outcome.file.name} {options} | {outcome.gist[:300]} | {outcome.seconds:.1f} s"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "folders", nargs="*", default=sys.path[1:], help="where to look (default: the installed packages)"
    )
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    everything = installed_urdfs(options.folders)
    arms = [path for path in everything if has_moving_joint(path)]
    outcomes = survey(arms, options.processes)
    print(f"{len(everything)} distinct URDFs, {len(arms)} with a moving joint")
    print(table(outcomes))
    worst = max(outcomes, key=lambda x: x.seconds)
    print(f"longest: {worst.file.name}, {worst.seconds:.1f} s")
    return 1 if any(x.kind in BAD_KINDS for x in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
