"""Emitted functions under the sanitizers of two compilers; all of all arms: soak.py emitted_sanitized."""

import re
import subprocess

import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.emission import emitted_arm
from tests.codegen.emit.hard_numbers import SANITIZERS, write_program
from tests.codegen.emit.programs import program

STATES = 100


def run(compiler, files, folder):
    """The finished process; skipped where a compiler has no sanitizers."""
    built = subprocess.run([program(compiler), "-O0", "-std=c99", *SANITIZERS, *files, "-lm", "-o", "hard"], cwd=folder,
                           capture_output=True, text=True, check=False)  # fmt: skip
    if "cannot find" in built.stderr:
        pytest.skip(f"{compiler} has no sanitizers here")
    assert built.returncode == 0, built.stderr
    return subprocess.run([str(folder / "hard")], capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.parametrize(("compiler", "robot", "options"), [
    ("gcc", "kr30ha", {}),
    ("clang", "wam7", {"functions": ("smooth_friction_torque", "inverse_kinematics")}),
    ("gcc", "lwr4plus", {"functions": ("inverse_kinematics", "gravity_vector"), "dtype": "float32"}),
])  # fmt: skip
def test_no_function_does_what_c_does_not_define(compiler, robot, options, tmp_path):
    emitted = emitted_arm(lwr_dyn.load(robot), **{"functions": (), **options})
    done = run(compiler, write_program(emitted, tmp_path, STATES), tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert int(done.stdout) == STATES * (len(emitted.codes) + len(emitted.templates))


@pytest.mark.parametrize("fault", ["out[6 + (q[0] > 0.0)] = 1.0;", "out[0] += (double)(int)(q[0] * 1e10);"])
def test_a_fault_is_seen(fault, tmp_path):
    emitted = emitted_arm(lwr_dyn.load("kr30ha"), ("gravity_vector",))
    files = write_program(emitted, tmp_path, STATES)
    text = (tmp_path / "arm.c").read_text()
    (tmp_path / "arm.c").write_text(re.sub(r"^}", f"    {fault}\n}}", text, count=1, flags=re.M))
    done = run("gcc", files, tmp_path)
    assert done.returncode != 0
    assert "ERROR: AddressSanitizer" in done.stderr or "runtime error" in done.stderr
