"""Emitted C that runs: beside Pinocchio at many states, under sanitizers, in the example of a control loop."""

import re
import subprocess

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.emission import emitted_arm
from tests.codegen.emit.emitted_robots import ARMS
from tests.codegen.emit.hard_numbers import SANITIZERS, write_program
from tests.codegen.emit.many_states import COMPARED, SHARE, differences
from tests.codegen.emit.programs import output, program
from tests.docs.console import ROOT


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "flags"), [
    (ARMS[0], ("-O0", "-std=c99")), (ARMS[2], ("-O1", "-march=native", "-ffp-contract=fast"))
])  # fmt: skip
def test_c_is_pinocchio_to_1e_14_of_the_largest_number(arm, flags, tmp_path):
    found = differences(arm, 500, tmp_path, *flags)
    assert set(found) == set(COMPARED)
    assert max(found.values()) < SHARE, found
    assert min(found.values()) > 0.0


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


EXAMPLE = ROOT / "scripts/examples/control_loop.c"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Werror", "-fsanitize=address,undefined")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The emitted functions and the run."""
    made = tmp_path_factory.mktemp("loop")
    arm = lwr_dyn.load("lwr4plus")
    emitted = emitted_arm(arm, ("step_inverse_dynamics", "forward_dynamics"), inputs=("payload",))
    for path, text in c_files(emitted, made / "lwr4plus.c").items():
        path.write_text(text)
    ends = np.radians([[0, 30, 0, -70, 0, 35, 0], [40, 60, -20, -20, 30, 60, 10]])
    move = lwr_dyn.reference("point-to-point", arm, start=ends[0], end=ends[1], duration=1.0)
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), move, payload=2.0)
    run.save(made / "run.csv")
    return made


def build(folder, text):
    (folder / "loop.c").write_text(text)
    output([program("gcc"), "-O1", *STRICT, "-I.", "loop.c", "lwr4plus.c", "-lm", "-o", "loop"], folder)
    with (folder / "run.csv").open() as table:
        return subprocess.run([str(folder / "loop")], stdin=table, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_the_example_is_short_and_its_run_is_the_one_in_python(folder):
    text = EXAMPLE.read_text()
    assert len(text.splitlines()) <= 60
    done = build(folder, text)
    assert (done.returncode, done.stderr) == (0, "")
    rad, torque = (float(x.split()[0]) for x in done.stdout.partition(": ")[2].split(", "))
    assert rad < 1e-13
    assert torque < 1e-9


def test_a_gain_that_differs_in_one_digit_is_seen(folder):
    done = build(folder, EXAMPLE.read_text().replace("Kd[i] = 100.0", "Kd[i] = 100.0001"))
    assert (done.returncode, done.stderr) == (1, "")
