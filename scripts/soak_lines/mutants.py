"""Faults planted in the code, one at a time, in copies of the tree: does the test of the module see them?

Drawn evenly over the lines of the whole package, those in C included (not the JavaScript of pages). Each is tried with
the tests that its module's name finds, and no other: `test_<module>.py` and `test_<module>_<aspect>.py` in the folder
of tests that mirrors the module's, its row in `tests/covered.toml`, its examples; first those that plain `pytest` runs,
then the slow ones. Tests run in a fork of a process that has loaded the libraries. Tests that do not end in `PATIENCE`
have seen a fault if they end without it.

The draw that is reported follows from the last commit of tests, so no test was written for it. Work with others:
`LWR_DYN_MUTANTS` (how many), `LWR_DYN_MUTANT_SEED`, `LWR_DYN_MUTANT_PLACES` (such as "krl,control/laws"),
`LWR_DYN_MUTANTS_QUICK=1` (without the slow tests).
"""

from __future__ import annotations

import multiprocessing
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import groupby, pairwise
from pathlib import Path

import numpy  # noqa: F401  loaded once, before the forks
import pinocchio  # noqa: F401
import pytest
import scipy.optimize  # noqa: F401
import yourdfpy  # noqa: F401

from soak_lines.mutations import Mutant, mutants_of
from soak_lines.mutations_of_c import mutants_of_c
from tests.own_tests import own_tests

ROOT = Path(__file__).resolve().parents[2]
COUNT = int(os.environ.get("LWR_DYN_MUTANTS", "200"))
PLACES = tuple(os.environ.get("LWR_DYN_MUTANT_PLACES", "").split(","))
MARKS = ("not slow",) if os.environ.get("LWR_DYN_MUTANTS_QUICK") else ("not slow", "slow")
NEEDED, NEEDED_QUICK = 0.90, 0.80
"""Shares of the mutants that change something: seen at all, and by what plain `pytest` runs."""
MOST_IDLE = 0.10
"""At most this share may be called mutants that change nothing."""
PATIENCE, LONGEST = 150, 600.0
"""[s] Processor time of one test file, and its time on the clock."""
KNOWN = (
    ("simulation/loops.py", "side * speeds > 0.0", "side * speeds <= 0.0"),
    ("trajectory/motion_profile.py", "np.roots(slope[::-1])", "np.roots(slope)"),
    ("kinematics/arm_angle.py", "(passage.low + passage.high) / 2.0", "(passage.low + passage.high) * 2.0"),
    ("krl/motion/pose_paths.py", "if wrist[passed] < NEAR:", "if wrist[passed] < 2 * NEAR:"),
    ("control/inertia/worst_case.py", "middle = (lower + upper) / 2\n", "middle = (lower + upper) * 2\n"),
    ("codegen/rollouts/rollouts.py", "first_run + i", "first_run - i"),
    ("arms/loading.py", "if arm.file and run.meta", "if arm.file or run.meta"),
    ("control/gains.py", "OMEGA_N, XI = 50.0, 1.0", "OMEGA_N, XI = 50.0, 2.0"),
    ("trajectory/references/pose_path_reference.py", "if s <= 0.0:", "if s <= 1.0:"),
    ("kinematics/arm_angle.py", "(0.5 - INSET)", "(0.5 + INSET)"),
    ("studies/sweep/read_study.py", "if lacking is not None:", "if lacking is None:"),
    ("reproduction/basis.py", "if np.ptp(trial) <= still:", "if np.ptp(trial) >= still:"),
)
"""Faults that the tests of versions 0.1.0 and 0.2.0 did not see, or in modules where they saw none of those drawn."""
RECORDS = ("tests/custody/test_values.py", "tests/cli/test_printed.py", "tests/codegen/test_written.py")
"""Tests that compare with what there was: they see that something changed, and not that it is wrong."""
REASONS = Path(__file__).with_name("mutants.toml")
"""key = "why this change changes nothing"."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a mutant: the tests that saw it (empty: none), quick or slow, whether they ended, the time."""

    mutant: Mutant
    by: str
    quick: bool
    ended: bool
    seconds: float

    @property
    def words(self) -> str:
        """For the log."""
        if not self.by:
            return "NOT SEEN"
        return f"{'seen' if self.ended else 'does not end'} by {self.by}{'' if self.quick else ', slow'}"


def seed() -> int:
    """Of the draw: given, or from the last commit that changed a test."""
    given = os.environ.get("LWR_DYN_MUTANT_SEED")
    command = ["git", "log", "-1", "--format=%H", "--", "tests"]
    return int(given or subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout[:8], 16)


def known_mutants(root: Path) -> list[Mutant]:
    """The faults that were not seen once."""
    out = []
    for module, old, new in KNOWN:
        source = (root / "lwr_dyn" / module).read_text(encoding="utf-8")
        at = source.index(old)
        line = source[:at].count("\n")
        text = source.splitlines()[line].strip()
        out.append(Mutant(module, line + 1, "known", at, at + len(old), old, new, text))
    return out


def drawn(count: int, seed: int, root: Path = ROOT, places: Sequence[str] = PLACES) -> list[Mutant]:
    """As many mutants of lines that are as far from each other: all such lines in a row, one of each part of it."""
    every: list[Mutant] = []
    changes_of = {".py": mutants_of, ".c": mutants_of_c}
    for path in sorted((root / "lwr_dyn").rglob("*")):
        module = path.relative_to(root / "lwr_dyn").as_posix()
        if path.suffix in changes_of and module.startswith(tuple(places)):
            every += sorted(changes_of[path.suffix](path, module), key=lambda x: (x.line, x.begin))
    lines = [list(group) for _, group in groupby(every, key=lambda x: (x.module, x.line))]
    random_ = random.Random(seed)
    ends = [round(k * len(lines) / count) for k in range(count + 1)]
    parts = [lines[a:b] for a, b in pairwise(ends) if b > a]
    return [random_.choice(random_.choice(part)) for part in parts]


def ends_well(root: Path, tests: str, marked: str) -> bool | None:
    """Whether all tests of a file with such marks hold; None when they take too long."""
    child = os.fork()
    if child == 0:
        _run_tests(root, tests, marked)
    until = time.monotonic() + LONGEST
    while time.monotonic() < until:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            code = os.waitstatus_to_exitcode(status)
            return None if code == -signal.SIGXCPU else code in (0, 5)  # 5: no test was collected
        time.sleep(0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def _run_tests(root: Path, tests: str, marked: str) -> None:
    """In a child: pytest on the copy; does not return."""
    code = 1
    try:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE + 5))
        Path("/proc/self/oom_score_adj").write_text("1000")  # a fault that takes all memory ends itself first
        silent = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(silent, number)
        os.chdir(root)
        os.environ["PYTHONPATH"] = str(root)
        sys.dont_write_bytecode, os.environ["PYTHONDONTWRITEBYTECODE"] = True, "1"
        sys.path[:] = [str(root), *(x for x in sys.path if not x.startswith(str(ROOT)))]
        for name in [name for name in sys.modules if name == "tests" or name.startswith("tests.")]:
            del sys.modules[name]
        code = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "--doctest-modules", "-m", marked, tests]))
    finally:
        os._exit(code)


def fate(mutant: Mutant, root: Path, known: dict[tuple[str, str], bool]) -> Fate:
    """Plant one fault in the copy, run its tests, and take it out again.

    `known` says which test files hold on the copy as it is: the failure of another shows nothing.
    """
    path, start = root / "lwr_dyn" / mutant.module, time.perf_counter()
    source = path.read_text(encoding="utf-8")
    files = own_tests(mutant.module.rpartition(".")[0], root / "tests")
    files += [path] if ">>> " in source else []
    for marked in MARKS:
        for tests in map(str, files):
            path.write_text(mutant.applied(source), encoding="utf-8")
            try:
                outcome = ends_well(root, tests, marked)
            finally:
                path.write_text(source, encoding="utf-8")
            if outcome is True:
                continue
            if (tests, marked) not in known:
                known[tests, marked] = ends_well(root, tests, marked) is True
            if known[tests, marked]:
                by = Path(tests).relative_to(root).as_posix()
                return Fate(mutant, by, marked == "not slow", outcome is False, time.perf_counter() - start)
    return Fate(mutant, "", False, True, time.perf_counter() - start)


def copied(folder: Path) -> Path:
    """A copy of the files that git knows."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in listed.splitlines():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    return folder


def tried(chosen: Sequence[Mutant], root: Path) -> tuple[list[Fate], set[str]]:
    """The fates of some mutants in one copy, each printed as it is known; the test files that fail without a fault."""
    known: dict[tuple[str, str], bool] = {}
    fates = []
    for mutant in chosen:
        fates.append(fate(mutant, root, known))
        print(f"{mutant.name}: {fates[-1].words}, {fates[-1].seconds:.0f} s", file=sys.stderr, flush=True)
    return fates, {Path(tests).relative_to(root).as_posix() for (tests, _), holds in known.items() if not holds}


def in_copies(chosen: Sequence[Mutant]) -> tuple[list[Fate], set[str]]:
    """`tried` in as many copies of the tree as there are cores; a module stays in one copy.

    By processes that may have children: tests start some, and a child of a `Pool` may not.
    """
    workers = max(len(os.sched_getaffinity(0)), 1)
    parts: list[list[Mutant]] = [[] for _ in range(workers)]
    of_modules = defaultdict(list)
    for mutant in chosen:
        of_modules[mutant.module].append(mutant)
    for mutants_here in sorted(of_modules.values(), key=len, reverse=True):
        min(parts, key=len).extend(mutants_here)
    context = multiprocessing.get_context("fork")
    with tempfile.TemporaryDirectory() as place, ProcessPoolExecutor(workers, context) as pool:
        copies = [copied(Path(place) / str(k)) for k in range(workers)]
        results = list(pool.map(tried, parts, copies))
    found = {one.mutant: one for fates, _ in results for one in fates}
    return [found[mutant] for mutant in chosen], set().union(*(failing for _, failing in results))


def share(fates: Iterable[Fate], reasons: dict[str, str], quick: bool = False) -> float:
    """Those that are seen, of those that change something."""
    counted = [one for one in fates if one.by or one.mutant.key not in reasons]
    return sum(bool(one.by) and (one.quick or not quick) for one in counted) / max(len(counted), 1)


def by_package(fates: Sequence[Fate], reasons: dict[str, str]) -> list[str]:
    """Rows of a table: package, mutants, seen by quick tests, by slow ones, not seen, change nothing."""
    rows = []
    for package, group in groupby(
        sorted(fates, key=lambda x: x.mutant.module), lambda x: x.mutant.module.split("/")[0]
    ):
        here = list(group)
        quick, slow = sum(x.quick for x in here), sum(bool(x.by) and not x.quick for x in here)
        idle = sum(not x.by and x.mutant.key in reasons for x in here)
        cells = (package, len(here), quick, slow, len(here) - quick - slow - idle, idle, f"{share(here, reasons):.0%}")
        rows.append(f"| {' | '.join(map(str, cells))} |")
    return rows


def mutants() -> tuple[str, bool, str]:
    """Faults planted all over the package that the tests of their modules see (LWR_DYN_MUTANTS=200 of them)."""
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8"))["changes_nothing"]
    number = seed()
    fates, failing = in_copies(drawn(COUNT, number))
    known, failing_too = in_copies(known_mutants(ROOT)) if PLACES == ("",) else ([], set())
    unseen = [x.mutant for x in (*fates, *known) if not x.by]
    idle = sum(x.key in reasons for x in unseen)
    rows = [f"| {x.name} | {reasons.get(x.key, 'not seen')} |" for x in unseen]
    table = [
        "| package | mutants | seen by quick tests | by slow ones | not seen | change nothing | seen |",
        "|---|---|---|---|---|---|---|",
        *by_package(fates, reasons),
        "",
        "| mutant that no test of its module sees | why |",
        "|---|---|",
        *rows,
    ]
    seen, quick = share(fates, reasons), share(fates, reasons, quick=True)
    once = sum(bool(x.by) for x in known)
    words = f"seed {number:x}: {seen:.1%} of {len(fates)} seen, {quick:.1%} by quick tests; {idle} change nothing; "
    words += f"{sum(x.by in RECORDS for x in fates)} seen by a record of what there was; "
    words += f"{once} of the {len(known)} known ones seen"
    if failing | failing_too:
        words += f"; fail without a fault, and so see none: {', '.join(sorted(failing | failing_too))}"
    holds = seen >= NEEDED and quick >= NEEDED_QUICK and idle <= MOST_IDLE * len(fates) and once == len(known)
    return words, holds, "\n".join(table).replace("`", "")
