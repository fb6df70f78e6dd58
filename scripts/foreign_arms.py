"""`lwr-dyn check` on every URDF of the installed packages: what holds, fails, is refused, crashes or takes too long.

Each file runs in a process of its own with a limit of 30 s of CPU time (a busy machine stretches wall time). A tree gets the options that its own refusal asks for: the
tip behind the most moving joints, and branches locked at 0 or the middle of their range. Files of the same content
count once. Exit 1 for a traceback or a file over the limit.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.errors import LwrDynError
from lwr_dyn.urdf.parse import parse_urdf
from lwr_dyn.urdf.tree import build_tree, position_limits

LIMIT = 30.0
"""[s] Longest CPU time for one file."""
_STUCK = 20.0
"""Wall time over CPU time at which a process that waits is stopped."""
_MOVING = re.compile(rb"type\s*=\s*[\"'](revolute|continuous|prismatic|planar|floating)[\"']")
_COMMAND = """
import resource, sys, time
limit, *arguments = sys.argv[1:]
resource.setrlimit(resource.RLIMIT_CPU, (int(float(limit)), int(float(limit)) + 5))
from lwr_dyn.cli.main import main
try:
    main(arguments)
except SystemExit as end:
    sys.exit(end.code)
except BaseException as fault:
    print(f"Traceback: {type(fault).__name__}: {fault}", file=sys.stderr)
    sys.exit(3)
finally:
    print(time.process_time(), file=sys.stderr)
"""
_ROUNDS = 5
"""Runs of one file: as it is, with a tip, with locks, with more locks (mimics)."""


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


def check_file(path: Path, limit: float = LIMIT) -> Outcome:
    """The outcome of one file, with the options that its refusals ask for."""
    options: tuple[str, ...] = ()
    for _ in range(_ROUNDS):
        done, seconds = _run(("check", str(path), "--json", *options), limit)
        if done is None:
            return Outcome(path, "over the limit", f"more than {limit:g} s", options, limit)
        added = _asked_for(path, done.stderr) if done.returncode == 2 else ()
        if not added:
            break
        options += added
    return Outcome(path, *_judged(path, done), options, seconds)


def _run(arguments: Sequence[str], limit: float) -> tuple[subprocess.CompletedProcess[str] | None, float]:
    """A run of `lwr-dyn` and its CPU time [s]; None instead of a run that was stopped at the limit."""
    command = [sys.executable, "-c", _COMMAND, str(limit), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_STUCK * limit)
    except subprocess.TimeoutExpired:
        return None, limit
    if done.returncode == -signal.SIGXCPU:
        return None, limit
    *lines, seconds = done.stderr.splitlines() or ["nan"]
    return subprocess.CompletedProcess(command, done.returncode, done.stdout, "\n".join(lines)), float(seconds)


def _judged(path: Path, done: subprocess.CompletedProcess[str]) -> tuple[str, str]:
    """Kind and gist of a finished run."""
    lines = done.stderr.strip().splitlines()
    if done.returncode == 2 and len(lines) == 1 and lines[0].startswith("lwr-dyn: "):
        return "refused", lines[0].removeprefix(f"lwr-dyn: {path.name}: ")
    if done.returncode not in (0, 1) or any("Traceback" in line for line in lines):
        return "crashed", lines[-1] if lines else f"exit code {done.returncode}"
    record = json.loads(done.stdout)
    failed = [verdict["name"] for verdict in record["verdicts"] if not verdict["holds"]]
    return ("fails", ", ".join(failed)) if failed else ("holds", f"{len(record['verdicts'])} checks")


def _asked_for(path: Path, message: str) -> tuple[str, ...]:
    """The options that a refusal asks for: a tip, or locks of branches."""
    locks = re.findall(r"--lock (\S+)=VALUE", message)
    try:
        urdf = parse_urdf(path)
        if "--tip" in message:
            tree = build_tree(urdf, {})
            depth = {x: sum(not tree.is_fixed(j) for j in tree.path_to(x)) for x in urdf.links if not tree.out_of[x]}
            return ("--tip", max(depth, key=lambda link: depth[link]))
    except LwrDynError:
        return ()
    return tuple(word for name in locks for word in ("--lock", f"{name}={_inside(urdf.joints[name])!r}"))


def _inside(joint: object) -> float:
    """0, or the middle of a range without it."""
    low, up = position_limits(joint)
    return 0.0 if low is None or up is None or low <= 0.0 <= up else (low + up) / 2


def survey(paths: Sequence[Path], processes: int, limit: float = LIMIT) -> list[Outcome]:
    """The outcome of every file; each is printed on stderr when it is there."""
    with ThreadPoolExecutor(processes) as pool:
        outcomes = []
        for outcome in pool.map(lambda path: check_file(path, limit), paths):
            print(_line(outcome), file=sys.stderr, flush=True)
            outcomes.append(outcome)
        return outcomes


def table(outcomes: Sequence[Outcome]) -> str:
    """Counts by outcome, then one line a file."""
    counts = Counter(outcome.kind for outcome in outcomes)
    lines = [f"{kind}: {count}" for kind, count in counts.most_common()]
    return "\n".join(lines + [_line(outcome) for outcome in sorted(outcomes, key=lambda x: (x.kind, x.gist))])


def _line(outcome: Outcome) -> str:
    options = " ".join(outcome.options)[:60]
    return f"{outcome.kind} | {outcome.file.name} {options} | {outcome.gist[:300]} | {outcome.seconds:.1f} s"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", default=sys.path, help="where to look (default: the installed packages)")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    everything = installed_urdfs(options.folders)
    arms = [path for path in everything if has_moving_joint(path)]
    outcomes = survey(arms, options.processes)
    print(f"{len(everything)} distinct URDFs, {len(arms)} with a moving joint")
    print(table(outcomes))
    worst = max(outcomes, key=lambda x: x.seconds)
    print(f"longest: {worst.file.name}, {worst.seconds:.1f} s")
    return 1 if any(x.kind in ("crashed", "over the limit") for x in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
