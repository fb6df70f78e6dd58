"""C files: no warning of gcc and clang as C99 and C++, results of their own test vectors, guards, odd names."""

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.c_file import c_files, c_function
from lwr_dyn.codegen.emit.emission import emitted_arm, identifier
from lwr_dyn.codegen.emit.functions import Argument, EmittedFunction, emitted_code
from lwr_dyn.foundation.errors import OptionError
from tests.codegen.emit.programs import program
from tests.codegen.emit.shared_library import SharedLibrary

WARNINGS = ("-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Wfloat-equal",
            "-Werror")  # fmt: skip
C99 = ("-std=c99", "-Wmissing-prototypes")
NARROW = ("inverse_dynamics", "mass_matrix", "gravity_vector", "flange_pose")


def written(folder: Path, arm, functions=NARROW, **options):
    emitted = emitted_arm(arm, functions, **options)
    for path, text in c_files(emitted, folder / "arm.c").items():
        path.write_text(text)
    return emitted


def build(folder: Path, emitted, name: str, *flags: str) -> subprocess.CompletedProcess[str]:
    command = [program(name), *flags, *WARNINGS, f"-D{emitted.prefix.upper()}_SELF_TEST", "-x",
               "c++" if name.endswith("++") else "c", "arm.c", "-lm", "-o", "self_test"]  # fmt: skip
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def self_test(folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(folder / "self_test")], capture_output=True, text=True, check=False, timeout=60)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("compiler_name", "flags", "robot", "options"),
    [
        ("gcc", ("-O1", *C99), "lwr4plus", {"functions": ()}),
        ("clang", ("-O1", *C99), "kr30ha", {"functions": (), "inputs": ("payload", "gravity", "friction")}),
        ("g++", ("-O0",), "lwr4plus", {"kind": "libm"}),
        ("clang++", ("-O0",), "wam7", {"dtype": "float32"}),
        ("gcc", ("-O0", *C99), "wam7", {"dtype": "float32", "kind": "libm", "friction": "arm"}),
        ("gcc", ("-O1", "-std=c99", "-ffp-contract=fast", "-march=native"), "kr30ha", {"inputs": ("inertia",)}),
    ],
)  # fmt: skip
def test_compilers_have_no_warning_and_functions_give_their_vectors(tmp_path, compiler_name, flags, robot, options):
    emitted = written(tmp_path, lwr_dyn.load(robot), **options)
    result = build(tmp_path, emitted, compiler_name, *flags)
    assert (result.returncode, result.stderr) == (0, "")
    told = self_test(tmp_path)
    assert told.returncode == 0, told.stdout
    assert {line.split()[0] for line in told.stdout.splitlines()} >= {c.function.name for c in emitted.codes}


def test_a_load_as_an_argument_costs_single_precision_no_digits(tmp_path):
    emitted = written(tmp_path, lwr_dyn.load("wam7"), ("forward_dynamics",), inputs=("payload",), dtype="float32")
    assert build(tmp_path, emitted, "gcc", "-O0", *C99).returncode == 0
    shares = [float(line.split()[-1]) for line in self_test(tmp_path).stdout.splitlines()]
    assert len(shares) == 3
    assert 0.0 < max(shares) < 1e-6  # 6e-6 while the load's moments about two points were added and subtracted


def test_the_self_test_fails_when_one_digit_is_wrong(tmp_path):
    emitted = written(tmp_path, lwr_dyn.load("kr30ha"), ("gravity_vector",))
    source = tmp_path / "arm.c"
    text = source.read_text()
    line = re.findall(r"const double v\d+ = v\d+ \* \d+\.\d{6,};", text)[-1]
    source.write_text(text.replace(line, line.replace("* ", "* 1.0000001 * ")))
    assert build(tmp_path, emitted, "gcc", "-O0", *C99).returncode == 0
    assert self_test(tmp_path).returncode == 1


@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-funsafe-math-optimizations"])
def test_fast_math_is_refused(tmp_path, flag):
    emitted = written(tmp_path, lwr_dyn.load("kr30ha"), ("gravity_vector",))
    result = build(tmp_path, emitted, "gcc", flag)
    assert result.returncode != 0
    assert "compile without -ffast-math" in result.stderr


def test_a_result_that_is_no_wider_than_an_argument_may_take_its_place(tmp_path):
    library = SharedLibrary(emitted_arm(lwr_dyn.load("kr30ha"), ("inverse_dynamics",)), tmp_path, "-O2")
    q, dq, ddq, apart = np.arange(1, 7) / 10, np.arange(6, 0, -1) / 10, np.eye(6)[0].copy(), np.zeros(6)
    expected = lwr_dyn.dynamics_of(library.arm).inverse_dynamics(q, dq, ddq)
    library.call("inverse_dynamics", q, dq, ddq, apart, kind=None)
    library.call("inverse_dynamics", q, dq, ddq, ddq, kind=None)
    assert np.array_equal(apart, ddq)
    np.testing.assert_allclose(apart, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.slow
def test_nothing_is_allocated_and_nothing_is_global(tmp_path):
    written(tmp_path, lwr_dyn.load("lwr4plus"))
    subprocess.run([program("gcc"), "-O2", "-std=c99", "-c", "arm.c"], cwd=tmp_path, check=True)
    symbols = subprocess.check_output(["nm", "arm.o"], cwd=tmp_path, text=True).split("\n")
    kinds = {(line.split()[-2], line.split()[-1]) for line in symbols if line and ".LC" not in line}
    assert kinds == {("T", f"lwr4plus_{name}") for name in NARROW}


def test_the_comment_says_where_the_numbers_are_from():
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    files = c_files(emitted_arm(arm, ("gravity_vector",), friction="none"), Path("a.c"))
    for text in files.values():
        assert "robot lwr4plus, reading physical" in text
        assert arm.digest in text
        assert "rotor-inertia-power" in text
        assert f"lwr-dyn {lwr_dyn.__version__}" in text
        assert "q[6] joint_7 [rad]" in text


def test_names_that_are_no_identifiers_are_made_one():
    found = [identifier(x) for x in ("KR 30-HA", "7dof", "_x__y", "*/", "größe")]
    assert found == ["KR_30_HA", "arm_7dof", "x_y", "arm", "gr_e"]
    arm = replace(lwr_dyn.load("kr30ha"), name="KR */ 30", title='evil */ int x; /* ??/ "\\\n#error')
    text = c_files(emitted_arm(arm, ("gravity_vector",)), Path("b c.c"))[Path("b c.h")]
    assert "void KR_30_gravity_vector(const double q[6], double out[6]);" in text
    assert "#ifndef KR_30_B_C_H\n#define KR_30_B_C_H\n" in text
    assert not [x for x in ("*/", "??/", "\n#error") if x in text.partition("*/\n")[0]]


@pytest.mark.parametrize("path", ["a.txt", "a", 'a".c', "a\n.c", "a.C"])
def test_bad_file_names_are_refused(path):
    emitted = emitted_arm(lwr_dyn.load("kr30ha"), ("gravity_vector",))
    with pytest.raises(OptionError, match="--out"):
        c_files(emitted, Path(path))


def exponentials():
    x = casadi.SX.sym("x", 2)
    out = casadi.vertcat(casadi.exp(x[0]), casadi.tanh(x[1]), casadi.log(x[1] * x[1] + 0.5))
    function = casadi.Function("laws", [x], [out])
    return EmittedFunction("laws", "exp, tanh, log", (Argument("x", 2, "1"),), (3,), "1", function)


def test_exponentials_keep_their_digits_and_nan(tmp_path):
    arm = emitted_arm(lwr_dyn.load("kr30ha"), ("gravity_vector",))
    emitted = replace(arm, codes=(emitted_code(exponentials()),))
    for path, text in c_files(emitted, tmp_path / "arm.c").items():
        path.write_text(text)
    assert build(tmp_path, emitted, "gcc", "-O1", *C99, "-fsanitize=undefined").stderr == ""
    told = self_test(tmp_path)
    assert told.returncode == 0, told.stdout
    (tmp_path / "nan.c").write_text(
        '#include "arm.h"\n#include <math.h>\n#include <stdio.h>\nint main(void) { double x[2] = {NAN, NAN}, out[3];'
        ' kr30ha_laws(x, out); printf("%d", isnan(out[0]) && isnan(out[1]) && isnan(out[2])); return 0; }\n'
    )
    command = [program("gcc"), "-fsanitize=undefined", "nan.c", "arm.c", "-lm", "-o", "nan"]
    subprocess.run(command, cwd=tmp_path, check=True)
    said = subprocess.run([str(tmp_path / "nan")], capture_output=True, text=True, check=True)
    assert (said.stdout, said.stderr) == ("1", "")


def test_an_argument_that_is_not_read_is_named_to_the_compiler():
    x, y = casadi.SX.sym("x", 2), casadi.SX.sym("y", 3)
    function = casadi.Function("first", [x, y], [x[0] * x[1]])
    code = emitted_code(
        EmittedFunction("first", "", (Argument("x", 2, "1"), Argument("y", 3, "1")), (1,), "1", function)
    )
    head, brace, unread, *lines = c_function(code, "f", "restrict").splitlines()
    assert head.startswith("void f(const double x[2], const double y[3], double out[")
    assert (brace, unread, lines[-1]) == ("{", "    (void)y;", "}")
    assert not [line for line in lines if "(void)" in line]


def test_exponentials_are_of_float64_alone():
    with pytest.raises(OptionError, match="exponentials"):
        emitted_code(exponentials(), "own", "float32")


@pytest.mark.parametrize(
    ("given", "frame", "ends"),
    [
        ({}, "base", "base, flange"),
        ({"mount": "ceiling"}, "world", "world (where a function says base), flange"),
        (
            {"tool": {"xyz": [0.0, 0.0, 0.2]}}, "base",
            "base, tool centre point (where a function says flange)",
        ),
    ],
)  # fmt: skip
def test_the_top_names_the_frames_of_a_mounted_arm_with_a_tool(tmp_path, given, frame, ends):
    written(tmp_path, lwr_dyn.load("kr30ha", **given), ("gravity_vector",))
    top = " ".join((tmp_path / "arm.c").read_text().replace("\n *", " ").split())
    assert f"gravity in the {frame} frame [m/s^2]: 0.0 0.0 -9.81" in top
    assert f"frames: {ends} numbers:" in top
