"""Loads files in a process of its own: an engine that aborts, crashes or hangs ends that process alone.

`python -m lwr_dyn.checks.engines.child_process ENGINE` reads one job a line on stdin and answers one line each on
stdout. An engine's own prints are kept off the terminal: C++ code writes to the file descriptors, past Python's
streams.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.checks.engines.engine import ENGINES, ArmInFile
from lwr_dyn.foundation.arrays import Array


@contextmanager
def quiet() -> Iterator[list[str]]:
    """Nothing reaches stdout and stderr inside; the list holds the printed lines afterwards."""
    lines: list[str] = []
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [(number, os.dup(number)) for number in (1, 2)]
    with tempfile.TemporaryFile() as file:
        try:
            for number, _ in kept:
                os.dup2(file.fileno(), number)
            yield lines
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for number, old in kept:
                os.dup2(old, number)
                os.close(old)
            file.seek(0)
            lines += [line.strip() for line in file.read().decode("utf-8", "replace").splitlines() if line.strip()]


def one_line(fault: BaseException, printed: list[str]) -> str:
    """An engine's reason in one line: its own words, and the error that it printed if there is one."""
    said = " ".join(str(fault).split()) or type(fault).__name__
    errors = [line for line in printed if "error" in line.lower()]
    said = said if not errors or errors[0] in said else f"{said} ({errors[0]})"
    return said if len(said) <= _LONGEST else f"{said[:_LONGEST]} ..."


_LONGEST = 220
SECONDS = 180.0
"""Longest time for all files of one engine, import included."""


@dataclass(frozen=True, slots=True, eq=False)
class TriedStates:
    """q, dq, ddq, (k, n) each [rad or m]."""

    q: Array
    dq: Array
    ddq: Array


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """A file to load, as what, and with which options of the engine."""

    path: Path
    scope: ArmInFile
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """What an engine makes of a file over the states; without dynamics, `torque` and what is like it are empty."""

    mass: float
    flange: Array
    held: dict[str, Array]
    links: tuple[str, ...]
    mass_matrix: Array = field(default_factory=lambda: np.zeros(0))
    velocity_torque: Array = field(default_factory=lambda: np.zeros(0))
    gravity_torque: Array = field(default_factory=lambda: np.zeros(0))
    torque: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def has_dynamics(self) -> bool:
        """Whether the engine computes torques, at every state."""
        return self.torque.size > 0 and bool(np.isfinite(self.torque).all())


def load_all(engine: str, jobs: Sequence[Job], states: TriedStates, seconds: float = SECONDS) -> list[Loaded | str]:
    """Each file as the engine has it, or its reason why not in one line."""
    out: list[Loaded | str] = []
    while len(out) < len(jobs):
        lines, end = _run(engine, jobs[len(out) :], states, seconds)
        out += [_answer(line) for line in lines]
        if len(out) < len(jobs):
            out.append(end)
        if end.startswith("no answer"):
            out += [end] * (len(jobs) - len(out))
    return out


def _run(engine: str, jobs: Sequence[Job], states: TriedStates, seconds: float) -> tuple[list[str], str]:
    """The answers of one process, and how it ended."""
    head = {"states": [x.tolist() for x in (states.q, states.dq, states.ddq)]}
    records = [{"path": str(job.path), "scope": asdict(job.scope), "options": dict(job.options)} for job in jobs]
    text = "\n".join(map(json.dumps, [head, *records])) + "\n"
    command = [sys.executable, "-m", "lwr_dyn.checks.engines.child_process", engine]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(x for x in sys.path if x)}
    environment |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, input=text.encode(), capture_output=True, timeout=seconds, env=environment)
    except subprocess.TimeoutExpired as late:
        return (late.output or b"").decode().splitlines(), f"no answer within {seconds:g} s"
    return done.stdout.decode().splitlines(), _end(done.returncode, done.stderr.decode("utf-8", "replace"))


def _end(code: int, printed: str) -> str:
    lines = printed.strip().splitlines() or [""]
    how = f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
    return f"{how} {lines[-1][:160]}".strip()


def _answer(line: str) -> Loaded | str:
    record = json.loads(line)
    if "fault" in record:
        return str(record["fault"])
    arrays = {name: np.array(value, dtype=float) for name, value in record["arrays"].items()}
    held = {name: np.array(value, dtype=float) for name, value in record["held"].items()}
    return Loaded(record["mass"], held=held, links=tuple(record["links"]), **arrays)


def main(engine: str) -> None:
    """Answer the jobs on stdin; prints of the engine go to stderr."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    head, *jobs = [json.loads(line) for line in sys.stdin]
    states = TriedStates(*(np.array(x) for x in head["states"]))
    for job in jobs:
        print(json.dumps(_record(engine, job, states)), file=answers, flush=True)


def _record(engine: str, job: Mapping[str, Any], states: TriedStates) -> dict[str, Any]:
    given = job["scope"]
    scope = ArmInFile(tuple(given["joints"]), given["tip"], tuple(given["gravity"]), given["held"])
    try:
        with quiet() as printed:
            found = load_here(engine, Job(Path(job["path"]), scope, job["options"]), states)
    except Exception as fault:
        return {"fault": one_line(fault, printed)}
    names = ("flange", "mass_matrix", "velocity_torque", "gravity_torque", "torque")
    arrays = {name: getattr(found, name).tolist() for name in names if getattr(found, name).size}
    held = {name: values.tolist() for name, values in found.held.items()}
    return {"mass": found.mass, "arrays": arrays, "held": held, "links": list(found.links)}


def load_here(engine: str, job: Job, states: TriedStates) -> Loaded:
    """The file in this process; raises what the engine raises."""
    model: Any = ENGINES.load(engine)(job.path, job.scope, job.options)
    rows = list(zip(states.q, states.dq, states.ddq, strict=True))
    torques = {} if ENGINES[engine].facts.get("kinematics") else {
        "mass_matrix": np.array([model.mass_matrix(q) for q, _, _ in rows]),
        "velocity_torque": np.array([model.velocity_torque(q, dq) for q, dq, _ in rows]),
        "gravity_torque": np.array([model.gravity_torque(q) for q, _, _ in rows]),
        "torque": np.array([model.torque(*row) for row in rows]),
    }  # fmt: skip
    flange = np.array([model.flange(q) for q, _, _ in rows])
    return Loaded(model.mass, flange, model.held(), tuple(model.links()), **torques)


if __name__ == "__main__":
    main(sys.argv[1])
