"""The share of long tests that CI draws: by its commit, what has changed first, no row without a test."""

import os
import re
import subprocess
import sys
from fnmatch import fnmatchcase
from pathlib import Path
from types import SimpleNamespace

import pytest

from scripts.soak import LINES
from scripts.soak_lines import suite
from tests.share import CASES, COMMIT, FILES, changed_files, drawn, family, left_out

ROOT = Path(__file__).resolve().parents[1]
PAGES = next(iter(CASES))
PAGE_CASES = [f"{PAGES}[docs/{k}.md]" for k in range(10)]


@pytest.mark.parametrize(("one_in", "count"), [(1, 10), (3, 4), (10, 1), (99, 1)])
def test_one_in_n_is_drawn_and_never_none(one_in, count):
    assert len(drawn(PAGE_CASES, one_in, "seed")) == count


def test_a_commit_draws_the_same_and_each_case_has_its_turn():
    assert drawn(PAGE_CASES, 3, "seed") == drawn(reversed(PAGE_CASES), 3, "seed")
    times = [sum(case in drawn(PAGE_CASES, 3, f"{seed}") for seed in range(300)) for case in PAGE_CASES]
    assert min(times) > 80  # 120 of 300 on average
    assert max(times) < 160


def test_what_has_changed_comes_first_and_the_number_stays():
    for seed in range(20):
        found = drawn(PAGE_CASES, 3, f"{seed}", {"docs/2.md", "docs/5.md", "docs/7.md"})
        assert found > {PAGE_CASES[2], PAGE_CASES[5], PAGE_CASES[7]}
        assert len(found) == 4
        files = [f"tests/{name}/test_x.py" for name in "abcd"]
        for changed in ("tests/b/test_x.py", "lwr_dyn/b/y.py"):
            assert drawn(files, 4, f"{seed}", {changed}) == {"tests/b/test_x.py"}
    assert len(drawn(PAGE_CASES, 3, "seed", {f"docs/{k}.md" for k in range(10)})) == 4


def test_a_file_is_drawn_with_all_its_tests_and_others_stay():
    files = [f"tests/pages/explorer/test_page_{name}.py" for name in "abcd"]
    tests = [f"{file}::test_{k}" for file in files for k in range(3)]
    others = ["tests/model/test_arm.py::test_x", f"{PAGES.partition('::')[0]}::test_few_blocks_are_not_run"]
    rest = left_out([*tests, *others], "seed", {files[3]})
    assert len(rest) == 6
    assert {name.partition("::")[0] for name in rest} < set(files[:3])
    assert {family(name) for name in others} == {None}


def test_every_row_is_of_slow_tests_that_are_there():
    test_files = [path.relative_to(ROOT).as_posix() for path in (ROOT / "tests").rglob("test_*.py")]
    for function, one_in in CASES.items():
        file, _, name = function.partition("::")
        text = (ROOT / file).read_text(encoding="utf-8")
        found = re.search(rf"((?:^@.*\n(?:^[ )].*\n)*)+)def {name}\(", text, re.M)
        assert found is not None, function
        assert "parametrize" in found[1], function
        assert "mark.slow" in found[1] or "pytestmark = pytest.mark.slow" in text, function
        assert one_in > 1
        assert not [pattern for pattern in FILES if fnmatchcase(file, pattern)], "of two rows"
    for pattern, one_in in FILES.items():
        files = [name for name in test_files if fnmatchcase(name, pattern)]
        assert len(files) >= one_in > 1, pattern
        assert not [name for name in files if family(f"{name}::x")[0] != pattern], "a file is of one row"
        slow = [name for name in files if "mark.slow" in (ROOT / name).read_text(encoding="utf-8")]
        assert len(slow) > one_in or pattern.startswith("tests/reproduction"), pattern


def collected(**variables):
    """The pages that a session would run."""
    command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-m", "share", PAGES.partition("::")[0]]
    environment = {name: value for name, value in os.environ.items() if name != COMMIT} | variables
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return {line for line in done.stdout.splitlines() if line.startswith(f"{PAGES}[")}


@pytest.mark.slow
def test_without_a_commit_every_page_is_run_and_with_one_a_share():
    pages = collected()
    assert len(pages) == len([page for page in (ROOT / "docs").rglob("*.md") if "_build" not in page.parts]) + 1
    share = collected(**{COMMIT: "a0b1"})
    assert share < pages
    assert len(share) == -(-len(pages) // CASES[PAGES])
    assert share == drawn(pages, CASES[PAGES], "a0b1", changed_files())


def test_ci_names_its_commit_and_soak_runs_every_case(monkeypatch):
    ran = []

    def run(command, **options):
        ran.append((command, options["env"]))
        return SimpleNamespace(stdout="12 passed\n", returncode=0)

    monkeypatch.setenv(COMMIT, "a0b1")
    monkeypatch.setattr(suite.subprocess, "run", run)
    assert LINES["shares"] == "suite:shares"
    assert suite.shares() == ("12 passed", True)
    [(command, environment)] = ran
    assert command[-3:] == ["-m", "share", "tests"]
    assert COMMIT not in environment
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert re.search(rf'^export {COMMIT}="\$\{{{COMMIT}-\$\(git rev-parse HEAD ', script, re.M)
    assert script.index(COMMIT) < script.index("\npytest -n auto")
