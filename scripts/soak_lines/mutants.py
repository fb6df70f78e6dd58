"""Faults planted in the code, one at a time, in a copy of the tree: do the matching tests see them?

A module's own test comes first (its name, or `tests/covered.toml`) and its examples, then the tests that import it,
then the folder of its mirror; one test file at a time, until one fails. Tests run in a fork of a process that has
loaded the libraries. Tests that do not end in `PATIENCE` have seen a fault if they end without it.
"""

from __future__ import annotations

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
from dataclasses import dataclass
from pathlib import Path

import numpy  # noqa: F401  loaded once, before the forks
import pinocchio  # noqa: F401
import pytest
import scipy.optimize  # noqa: F401
import yourdfpy  # noqa: F401

from soak_lines.mutations import Mutant, mutants_of

ROOT = Path(__file__).resolve().parents[2]
CORE = (
    "arrays.py", "files.py", "registry.py", "tables.py", "errors.py", "loading.py", "front.py", "model", "papers",
    "urdf", "dynamics", "kinematics", "trajectory", "control", "simulation", "checks", "viewer", "cli",
)  # fmt: skip
COUNT, SEED = 100, 24
FIRST, LAST = (int(x) for x in os.environ.get("LWR_DYN_MUTANTS", f"0:{COUNT}").split(":"))
"""Which of them are tried."""
NEEDED = 0.95
PATIENCE, LONGEST = 150, 600.0
"""[s] Processor time of one test file, and its time on the clock."""
KNOWN = (
    ("simulation/record.py", "side * speeds > 0.0", "side * speeds <= 0.0"),
    ("trajectory/motion_profile.py", "np.roots(slope[::-1])", "np.roots(slope)"),
    ("kinematics/arm_angle.py", "(passage.low + passage.high) / 2.0", "(passage.low + passage.high) * 2.0"),
    ("krl/motion/path_axes.py", "if wrist[passed] < NEAR:", "if wrist[passed] < 2 * NEAR:"),
    ("control/worst_case_inertia.py", "middle = (lower + upper) / 2\n", "middle = (lower + upper) * 2\n"),
)
"""Faults that the tests of version 0.1.0 did not see."""
REASONS = Path(__file__).with_name("mutants.toml")
"""key = "why this change changes nothing"."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a mutant: the test file that saw it (empty: none), whether that one ended, the time."""

    mutant: Mutant
    by: str
    ended: bool
    seconds: float

    @property
    def words(self) -> str:
        """For the log."""
        return f"{'seen' if self.ended else 'does not end'} by {self.by}" if self.by else "NOT SEEN"


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


def drawn(count: int, seed: int, root: Path = ROOT) -> list[Mutant]:
    """The known faults, and others of the core drawn by seed, at most one a line."""
    places = [root / "lwr_dyn" / part for part in CORE]
    files = [path for place in places for path in ([place] if place.suffix else place.rglob("*.py"))]
    every: list[Mutant] = []
    for path in sorted(files):
        every += mutants_of(path, path.relative_to(root / "lwr_dyn").as_posix())
    chosen = known_mutants(root)
    taken = {(x.module, x.line) for x in chosen}
    for mutant in random.Random(seed).sample(every, len(every)):
        if len(chosen) < count and (mutant.module, mutant.line) not in taken:
            taken.add((mutant.module, mutant.line))
            chosen.append(mutant)
    return chosen


def tests_of(module: str, root: Path) -> list[str]:
    """Test files that match a module, the nearest first, and the module itself for its examples; each file once."""
    name, tests = module.removesuffix(".py"), root / "tests"
    covered = tomllib.loads((tests / "covered.toml").read_text(encoding="utf-8"))["covered"]
    own = [tests / covered.get(name, "none"), (tests / name).with_name(f"test_{Path(name).name}.py")]
    dotted = "lwr_dyn." + name.replace("/", ".")
    package, _, last = dotted.rpartition(".")
    marks = (f"from {dotted} import", f"import {dotted}", f"from {package} import {last}")
    every = sorted(tests.rglob("test_*.py"))
    importing = [p for p in every if any(mark in p.read_text(encoding="utf-8") for mark in marks)]
    folder = [p for p in every if p.parent == (tests / name).parent]
    importing.sort(key=lambda p: p not in folder)
    examples = [p for p in [root / "lwr_dyn" / module] if ">>> " in p.read_text(encoding="utf-8")]
    return [str(p) for p in dict.fromkeys([*own, *examples, *importing, *folder]) if p.is_file()]


def ends_well(root: Path, tests: str) -> bool | None:
    """Whether all tests of a file hold; None when they take too long."""
    child = os.fork()
    if child == 0:
        _run_tests(root, tests)
    until = time.monotonic() + LONGEST
    while time.monotonic() < until:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            code = os.waitstatus_to_exitcode(status)
            return None if code == -signal.SIGXCPU else code in (0, 5)  # 5: no test was collected
        time.sleep(0.1)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def _run_tests(root: Path, tests: str) -> None:
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
        code = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "--doctest-modules", tests]))
    finally:
        os._exit(code)


def fate(mutant: Mutant, root: Path, known: dict[str, bool]) -> Fate:
    """Plant one fault in the copy, run its tests, and take it out again.

    `known` says which test files hold on the copy as it is: the failure of another shows nothing.
    """
    path, start = root / "lwr_dyn" / mutant.module, time.perf_counter()
    source = path.read_text(encoding="utf-8")
    for tests in tests_of(mutant.module, root):
        path.write_text(mutant.applied(source), encoding="utf-8")
        try:
            outcome = ends_well(root, tests)
        finally:
            path.write_text(source, encoding="utf-8")
        if outcome is True:
            continue
        if tests not in known:
            known[tests] = ends_well(root, tests) is True
        if known[tests]:
            by = Path(tests).relative_to(root).as_posix()
            return Fate(mutant, by, outcome is False, time.perf_counter() - start)
    return Fate(mutant, "", True, time.perf_counter() - start)


def copied(folder: Path) -> Path:
    """A copy of the files that git knows."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in listed.splitlines():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    return folder


def mutants() -> tuple[str, bool, str]:
    """Faults planted in the core, drawn by seed, that its tests see (LWR_DYN_MUTANTS=0:100 of them)."""
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8"))["changes_nothing"] if REASONS.exists() else {}
    with tempfile.TemporaryDirectory() as place:
        root = copied(Path(place))
        fates: list[Fate] = []
        known: dict[str, bool] = {}
        for mutant in drawn(COUNT, SEED, root)[FIRST:LAST]:
            fates.append(fate(mutant, root, known))
            print(f"{mutant.name}: {fates[-1].words}, {fates[-1].seconds:.0f} s", file=sys.stderr, flush=True)
    survivors = [x.mutant for x in fates if not x.by]
    idle = [x for x in survivors if x.key in reasons]
    missed = [x for x in survivors if x.key not in reasons]
    share = 1.0 - len(missed) / max(len(fates) - len(idle), 1)
    rows = [f"| {x.name} | {reasons.get(x.key, 'not seen')} |" for x in survivors]
    table = "\n".join(["| mutant that no test sees | why |", "|---|---|", *rows]).replace("`", "")
    seen = sum(bool(x.by) for x in fates)
    words = f"{seen} of {len(fates)} seen; {len(idle)} change nothing; {share:.1%} of the rest seen"
    return words, share >= NEEDED, table
