"""Faults planted in the code, one at a time, in a copy of the tree: do the matching tests see them?

A module's own test comes first (its name, or `tests/covered.toml`), then the folder of its mirror, `tests/laws` and
`tests/agreement`. A run longer than `PATIENCE` counts as seen: a fault that makes a loop endless is noticed.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

from soak_lines.mutations import Mutant, mutants_of

ROOT = Path(__file__).resolve().parents[2]
CORE = (
    "arrays.py", "files.py", "registry.py", "tables.py", "errors.py", "loading.py", "front.py", "model", "papers",
    "urdf", "dynamics", "kinematics", "trajectory", "control", "simulation", "checks", "viewer", "cli",
)  # fmt: skip
COUNT, SEED = int(os.environ.get("LWR_DYN_MUTANTS", "100")), 24
NEEDED = 0.95
PATIENCE = 240.0
"""[s] Of one run of tests."""
KNOWN = (
    ("simulation/record.py", "side * speeds > 0.0", "side * speeds <= 0.0"),
    ("trajectory/motion_profile.py", "np.roots(slope[::-1])", "np.roots(slope)"),
    ("kinematics/arm_angle.py", "(passage.low + passage.high) / 2.0", "(passage.low + passage.high) * 2.0"),
    ("krl/planner.py", "if wrist[passed] < NEAR:", "if wrist[passed] < 2 * NEAR:"),
    ("control/worst_case_inertia.py", "middle = (lower + upper) / 2\n", "middle = (lower + upper) * 2\n"),
)
"""Faults that the tests of version 0.1.0 did not see."""
REASONS = Path(__file__).with_name("mutants.toml")
"""name = "why this change changes nothing"."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a mutant: the test files that were run, and whether one failed."""

    mutant: Mutant
    seen: bool
    seconds: float


def known_mutants(root: Path) -> list[Mutant]:
    """The faults that were not seen once."""
    out = []
    for module, old, new in KNOWN:
        source = (root / "lwr_dyn" / module).read_text(encoding="utf-8")
        at = source.index(old)
        out.append(Mutant(module, source[:at].count("\n") + 1, "known", at, at + len(old), old, new))
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


def tests_of(module: str, root: Path) -> list[list[str]]:
    """Runs of tests that match a module, the nearest first."""
    name = module.removesuffix(".py")
    covered = tomllib.loads((root / "tests" / "covered.toml").read_text(encoding="utf-8"))["covered"]
    own = [root / "tests" / covered.get(name, ""), (root / "tests" / name).with_name(f"test_{Path(name).name}.py")]
    folder = (root / "tests" / name).parent
    wider = [folder] if folder != root / "tests" else []
    wider += [root / "tests" / x for x in ("laws", "agreement")]
    near = list(dict.fromkeys(str(p) for p in own if p.is_file()))
    return [run for run in (near, [str(p) for p in wider if p.is_dir()]) if run]


def fails(root: Path, tests: list[str]) -> bool:
    """Whether one of the tests fails, or they take too long."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    environment = os.environ | {"PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, cwd=root, env=environment, start_new_session=True, **silent)
    try:
        return process.wait(PATIENCE) not in (0, 5)  # 5: no test was collected
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return True


def fate(mutant: Mutant, root: Path) -> Fate:
    """Plant one fault in the copy, run its tests, and take it out again."""
    path, start = root / "lwr_dyn" / mutant.module, time.perf_counter()
    source = path.read_text(encoding="utf-8")
    path.write_text(mutant.applied(source), encoding="utf-8")
    try:
        compile(mutant.applied(source), str(path), "exec")
        seen = any(fails(root, tests) for tests in tests_of(mutant.module, root))
    finally:
        path.write_text(source, encoding="utf-8")
    return Fate(mutant, seen, time.perf_counter() - start)


def copied(folder: Path) -> Path:
    """A copy of the files that git knows."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in listed.splitlines():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / name)
    return folder


def mutants() -> tuple[str, bool, str]:
    """Faults planted in the core, drawn by seed, that its tests see (LWR_DYN_MUTANTS of them)."""
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8"))["changes_nothing"] if REASONS.exists() else {}
    with tempfile.TemporaryDirectory() as place:
        root = copied(Path(place))
        fates = []
        for mutant in drawn(COUNT, SEED, root):
            fates.append(fate(mutant, root))
            word = "seen" if fates[-1].seen else "NOT SEEN"
            print(f"{word} {fates[-1].seconds:.0f} s {mutant.name}", file=sys.stderr, flush=True)
    survivors = [x.mutant for x in fates if not x.seen]
    idle = [x for x in survivors if x.name in reasons]
    missed = [x for x in survivors if x.name not in reasons]
    share = 1.0 - len(missed) / max(len(fates) - len(idle), 1)
    rows = [f"| {x.name} | {reasons.get(x.name, 'not seen')} |" for x in survivors]
    table = "\n".join(["| mutant that no test sees | why |", "|---|---|", *rows]).replace("`", "")
    seen = sum(x.seen for x in fates)
    words = f"{seen} of {len(fates)} seen; {len(idle)} change nothing; {share:.1%} of the rest seen"
    return words, share >= NEEDED, table
