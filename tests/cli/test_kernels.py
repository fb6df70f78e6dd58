"""`lwr-dyn kernels`: files of C, test vectors; the source of one function, the cost of all; one line for bad input."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, kernel_spec
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import cache_folder

TO_C = ("--language", "c", "--out", "a.c")


@pytest.mark.slow
def test_the_command_prints_a_source_or_the_cost_of_functions(printed, recorded):
    out = printed("kernels", "lwr4plus", "--emit", "gravity_vector", "--inputs", "payload")
    assert "Inputs: q, payload." in out
    compile(out, "source", "exec")
    functions = recorded("kernels", "lwr4plus")["functions"]
    assert {f["name"]: f["inputs"] for f in functions}["mass_matrix"] == ["q"]
    assert "torque_regressor" in printed("kernels", "lwr4plus")


STOP = OptionError("stop", "here", "nothing")


@pytest.mark.parametrize(
    ("options", "chosen"),
    [
        ((), ([], "none", "armature", "float64")),
        (("--inputs", "payload, gravity", "--own-friction", "--dtype", "float32"),
         (["payload", "gravity"], "arm", "armature", "float32")),
    ],
)  # fmt: skip
def test_what_is_typed_reaches_the_functions(asked, refused, folder, options, chosen):
    spec = asked("lwr_dyn.cli.kernels.kernel_spec", STOP)
    emitted = asked("lwr_dyn.codegen.emit.emission.emitted_arm", STOP)
    refused("kernels", "wam7", *options)
    assert (spec[0][0][0].name, spec[0][0][1:]) == ("wam7", chosen)
    inputs, friction, _, dtype = chosen
    for more, functions, kind, prefix in (
        ((), [], "own", None),
        (
            ("--emit", "jacobian, mass_matrix", "--sincos", "libm", "--prefix", "x"),
            ["jacobian", "mass_matrix"],
            "libm",
            "x",
        ),
    ):
        refused("kernels", "wam7", *TO_C, *options, *more)
        (arm, names), given = emitted.pop()
        assert (arm.name, names, given) == (
            "wam7", functions,
            {"inputs": inputs, "friction": friction, "dtype": dtype, "kind": kind, "prefix": prefix},
        )  # fmt: skip


def test_the_costs_are_those_of_the_generated_functions(recorded, printed):
    from lwr_dyn.codegen.kernels.kernel_source import generate

    arm = lwr_dyn.load("kr30ha")
    record = recorded("kernels", "kr30ha", "--dtype", "float32")
    spec = kernel_spec(arm, (), "none", "armature", "float32")
    for row, name in zip(record["functions"], FUNCTIONS, strict=True):
        x = generate(spec, name).interface
        found = {
            "name": name,
            "operations": x.operations,
            "fused": x.fused,
            "inputs": list(x.inputs),
            "result": x.width,
        }
        assert row == found
    assert {key: record[key] for key in ("robot", "dtype", "cache")} == {
        "robot": "kr30ha (kuka)", "dtype": "float32", "cache": str(cache_folder()),
    }  # fmt: skip
    lines = printed("kernels", "kr30ha", "--dtype", "float32").splitlines()
    assert f"kr30ha (kuka), float32; kept in {cache_folder()}" in lines
    assert sum(line.startswith(tuple(FUNCTIONS)) for line in lines) == len(FUNCTIONS)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("lwr4plus", "--emit", "gravity"), "no function of a batch named 'gravity' (did you mean gravity_vector?)"),
        (("lwr4",), "masses and inertias not given"),
        (("lwr4plus", "--inputs", "colour"), "inputs: 'colour'"),
        (("lwr4plus", "--emit", "jacobian", "--json"), "--json: with --emit"),
        (("lwr4plus", "--dtype", "int8"), "dtype: 'int8'"),
        (("lwr4plus", "--out", "a.c"), "--out: without --language"),
        (("lwr4plus", "--sincos", "own"), "--sincos: without --language"),
        (("lwr4plus", "--language", "c"), "--language: without --out"),
        (("lwr4plus", "--language", "pascal", "--out", "a.c"), "no language named 'pascal'"),
        (("lwr4plus", "--language", "c", "--out", "a.txt"), "a path that ends in .c"),
        (("lwr4plus", "--language", "c", "--out", "/no/such/folder/a.c"), "no directory /no/such/folder"),
        (("lwr4plus", *TO_C, "--vectors", "/no/such/v"), "no directory /no/such"),
        (("kr30ha", *TO_C, "--emit", "jacobian", "--vectors", "./a.h"), "--vectors: './a.h'; allowed: another file"),
        (("lwr4plus", *TO_C, "--emit", "gravity"), "did you mean gravity_vector?"),
        (("lwr4plus", *TO_C, "--sincos", "mine"), "sincos: 'mine'; allowed: own, libm"),
        (("lwr4plus", *TO_C, "--json"), "--json: with --language"),
        (("lwr4", *TO_C, "--emit", "mass_matrix"), "masses and inertias not given"),
        (("wam7", *TO_C, "--friction", "arm"), "--friction is now --own-friction, without a value"),
    ],
)
def test_bad_input_gets_one_line(refused, arguments, message, folder):
    assert message in refused("kernels", *arguments)
    assert not list(folder.iterdir())


def test_c_is_written_with_header_and_test_vectors(printed, tmp_path):
    out, vectors = tmp_path / "arm.c", tmp_path / "vectors.json"
    options = ("--language", "c", "--out", str(out), "--vectors", str(vectors), "--emit")
    said = printed("kernels", "kr30ha", *options, "gravity_vector, jacobian", "--prefix", "my arm")
    assert "names begin with my_arm_: 'my arm' is no identifier" in said
    assert "my_arm_gravity_vector" in said
    assert "void my_arm_jacobian(const double q[6], double out[MY_ARM_RESTRICT 36])" in out.read_text()
    assert out.with_suffix(".h").read_text().count("void my_arm_") == 2
    functions = json.loads(vectors.read_text())["functions"]
    assert [f["name"] for f in functions] == ["gravity_vector", "jacobian"]
    dynamics = lwr_dyn.dynamics_of(lwr_dyn.load("kr30ha"))
    for q, expected in zip(functions[0]["arguments"][0]["rows"], functions[0]["result"]["rows"], strict=True):
        found = dynamics.gravity_vector(q)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(found).max())


def test_tuned_gains_stand_in_the_header_alone(printed, tmp_path):
    out = tmp_path / "arm.c"
    options = ("--language", "c", "--out", str(out), "--emit", "step_inverse_dynamics")
    said = printed("kernels", "kr30ha", *options)
    assert said.splitlines()[-1].endswith("  torque of inverse dynamics with feed-forward")
    assert "gains as tuned: Kp = 2500" in " ".join(out.with_suffix(".h").read_text().split())


@pytest.mark.slow
def test_an_arm_without_masses_gets_its_kinematics_and_is_told_what_is_left_out(printed, tmp_path):
    said = printed("kernels", "lwr4", "--language", "c", "--out", str(tmp_path / "arm.c"))
    assert "left out: mass_matrix: lwr4: masses and inertias not given" in said
    text = (tmp_path / "arm.h").read_text()
    assert "lwr4_flange_pose" in text
    assert "mass_matrix" not in text
