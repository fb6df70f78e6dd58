"""With the base dependencies alone the core installs, imports, checks, simulates and replays.

Some of its tests run here; `scripts/soak.py core` runs them all.
"""

import os
import re
import shutil

import pytest

from tests.custody.core_alone import installed_core, run, run_tests

pytestmark = pytest.mark.slow

SHARE = ("arms/papers", "control/*", "laws", "foundation")
"""Folders of tests that need nothing but pytest and hypothesis, and little time."""
HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")
COMMANDS = (
    (("check", "x.urdf"), 0, "checks hold"),
    (("simulate", "lwr4plus", *HOLD, "--csv", "x.csv"), 0, "wrote x.csv"),
    (("simulate", "lwr4plus", "--plot", "torque"), 2, "pip install 'lwr_dyn[plots]'"),
    (("simulate", "lwr4plus", "--engine", "kernels"), 2, "pip install 'lwr_dyn[batch]'"),
    (("fk", "lwr4", "--symbolic"), 2, "pip install 'lwr_dyn[symbolic]'"),
)
"""A command, its exit code, a part of its output: what no example shows; `scripts/wheel_smoke.py` runs those."""
LACKED = {
    "tests/foundation/test_column_files.py": {"pyarrow"},
    "tests/foundation/test_registry.py": {"casadi", "lark", "llvmlite", "pygls", "rosbags"},
}
"""Tests of `SHARE` that an extra brings, with its package: a file format, rows of registries."""


@pytest.fixture(scope="module")
def core(tmp_path_factory):
    folder = tmp_path_factory.mktemp("core")
    try:
        return installed_core(folder), folder
    except RuntimeError as fault:
        if os.environ.get("CI"):
            raise
        pytest.skip(f"no environment could be made: {fault}")


def test_the_commands_of_the_core(core):
    python, folder = core
    shutil.copy(folder / "models" / "kr30ha" / "kr30ha.urdf", folder / "x.urdf")
    for arguments, code, words in COMMANDS:
        process = run([str(python), "-m", "lwr_dyn", *arguments], folder)
        assert process.returncode == code, process.stderr
        assert words in process.stdout + process.stderr, arguments
        assert code == 0 or process.stderr.count("\n") == 1


def test_a_function_that_needs_an_extra_names_it(core):
    python, folder = core
    code = "import lwr_dyn; lwr_dyn.batch_dynamics(lwr_dyn.load('lwr4plus'))"
    assert "pip install 'lwr_dyn[batch]'" in run([str(python), "-c", code], folder).stderr


def test_its_tests_pass(core):
    python, folder = core
    process = run_tests(python, folder, SHARE)
    assert process.returncode == 0, process.stdout[-3000:]
    lacked = {file: set() for file in LACKED}
    for file, package in re.findall(r"^SKIPPED \[\d+\] (.+):\d+: (.+) not installed", process.stdout, re.M):
        lacked[file].add(package)
    assert lacked == LACKED
