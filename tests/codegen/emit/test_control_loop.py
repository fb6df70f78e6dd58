"""The example in C: at most 60 lines, without a warning, and its run is the one in Python."""

import subprocess

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.emission import emitted_arm
from tests.codegen.emit.programs import output, program
from tests.docs.console import ROOT

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
