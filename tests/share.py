"""Which of the long tests CI runs: of some a share, drawn by the commit. What is drawn, and how much, stands here.

`.ci/run` names the commit in LWR_DYN_SHARE. Without that variable, as in `pytest -m slow` and `scripts/soak.py shares`,
everything runs. What the last commits changed comes first: a page, a file of tests, or the package that it tests. The
number stays, so that CI takes the same time after any change: where much has changed, what has not waits for the weekly
run of everything. `pytest --collect-only -q -m share` lists what is drawn from. (A plugin of pytest: see conftest.py.)
"""

from __future__ import annotations

import hashlib
import os
import subprocess
from collections import defaultdict
from collections.abc import Collection, Iterable
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
COMMIT = "LWR_DYN_SHARE"
"""The variable with any text that draws: another text, other cases."""
LAST = 10
"""Commits whose files come first."""
CASES = {
    # the same check of one more page, command, script or arm
    "tests/docs/test_pages.py::test_a_page_does_what_it_shows": 4,
    "tests/docs/test_site.py::test_a_page_breaks_no_rule_of_axe": 3,
    "tests/custody/test_help_text.py::test_the_examples_run": 3,
    "tests/scripts/test_scripts.py::test_a_worked_example_runs": 3,
    "tests/scripts/test_default_arms.py::test_a_seeded_share_runs_inside_its_limits_or_says_why_not": 4,
    "tests/reproduction/test_compare_mutants.py::test_no_mutant_moves_a_number_unseen": 2,
    "tests/hostile/test_fuzz.py::test_changed_good_files_are_read_or_refused": 2,
    # of one more screen
    "tests/reproduction/report/test_page_reading.py::test_no_rule_of_accessibility_is_broken": 2,
    "tests/pages/replay/test_framing.py::test_arm_paths_and_base_are_in_sight_and_no_panel_covers_them": 2,
}
"""Function -> n: one in n of its cases, at least one."""
FILES = {
    # pages in a browser: each has its quick tests, of what it is made of
    "tests/pages/explorer/test_page*.py": 3,
    # compilers, languages and forms of emitted functions beyond those of the quick tests
    "tests/codegen/emit/test_*.py": 2,
    "tests/codegen/kernels/test_*.py": 2,
}
"""Files by a pattern -> n: the slow tests of one in n of them, at least of one."""


def drawn(names: Iterable[str], one_in: int, seed: str, changed: Collection[str] = ()) -> set[str]:
    """One in `one_in` of the names, rounded up: those that changed, then as a hash has them.

    A name is that of a file of tests, or of a case: `FILE::FUNCTION[CASE]`, where the case may be a file.
    """
    packages = {name.rpartition("/")[0] for name in changed if name.startswith("lwr_dyn/")}

    def place(name: str) -> tuple[bool, bytes]:
        file = name.partition("[")[2].removesuffix("]") if "[" in name else name
        tested = file.rpartition("/")[0].replace("tests/", "lwr_dyn/", 1)
        return file not in changed and tested not in packages, hashlib.sha256(f"{seed} {name}".encode()).digest()

    names = sorted(set(names), key=place)
    return set(names[: -(-len(names) // one_in)])


@cache
def changed_files() -> frozenset[str]:
    """Paths that the last commits changed; none where there is no git, or no history."""
    log = ["git", "log", f"-{LAST}", "--first-parent", "--min-parents=1", "-m", "--name-only", "--format="]
    try:
        done = subprocess.run(log, cwd=ROOT, capture_output=True, text=True)
    except OSError:
        return frozenset()
    return frozenset(done.stdout.split("\n")) - {""} if done.returncode == 0 else frozenset()


def family(nodeid: str) -> tuple[str, int, str] | None:
    """(row, n, what of it is drawn) of a slow test; None where all runs."""
    function, file = nodeid.partition("[")[0], nodeid.partition("::")[0]
    if function in CASES:
        return function, CASES[function], nodeid
    return next(((row, one_in, file) for row, one_in in FILES.items() if fnmatchcase(file, row)), None)


def left_out(nodeids: Iterable[str], seed: str, changed: Collection[str]) -> set[str]:
    """Those of these slow tests that are not drawn."""
    rows: dict[tuple[str, int], dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for nodeid in nodeids:
        if found := family(nodeid):
            row, one_in, name = found
            rows[row, one_in][name].append(nodeid)
    return {
        nodeid
        for (_, one_in), names in rows.items()
        for name in names.keys() - drawn(names, one_in, seed, changed)
        for nodeid in names[name]
    }


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items) -> None:
    slow = [item for item in items if item.get_closest_marker("slow")]
    for item in slow:
        if family(item.nodeid):
            item.add_marker("share")
    if seed := os.environ.get(COMMIT):
        rest = left_out([item.nodeid for item in slow], seed, changed_files())
        config.hook.pytest_deselected(items=[item for item in slow if item.nodeid in rest])
        items[:] = [item for item in items if item.nodeid not in rest]
