"""Files of JavaScript: script and module, from the command, with the test vectors; bad paths in one line."""

import json
import re

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.functions import Argument, EmittedFunction, TemplateFunction, emitted_code
from lwr_dyn.codegen.emit.javascript_file import javascript_source, js_function, shared_functions
from lwr_dyn.foundation.errors import OptionError
from tests.codegen.emit.emitted_robots import ARMS, DYNAMICS, emitted_robot
from tests.codegen.emit.programs import node, output, program


def evaluated(text, expression, folder):
    """The value of an expression after a script, as node sees it."""
    return node(folder, f"{text}\nconsole.log(JSON.stringify({expression}));")


USE = """
const cases = JSON.parse(require("fs").readFileSync("vectors.json"));
const rows = cases.functions.map(f => {
  const g = robot[f.name.replace("lwr4plus_", "")];
  return f.arguments[0].rows.map((_, k) => Array.from(g(...f.arguments.map(a => a.rows[k]))));
});
console.log(JSON.stringify(rows));
"""


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".js", ".mjs"])
def test_a_file_gives_its_test_vectors(ending, lwr_dyn_command, tmp_path):
    out, vectors = tmp_path / f"arm{ending}", tmp_path / "vectors.json"
    functions = "gravity_vector,jacobian,inverse_dynamics"
    code, said, _ = lwr_dyn_command("kernels", "lwr4plus", "--language", "js", "--out", str(out),
                                    "--vectors", str(vectors), "--emit", functions, "--inputs", "payload")  # fmt: skip
    assert code == 0
    assert "gravity_vector" in said
    text = out.read_text()
    assert text.startswith("// KUKA LWR 4+")
    assert "// source file sha256: " in text
    if ending == ".mjs":
        loading = f"import robot, {{ jacobian, n }} from {json.dumps(out.as_uri())};\n"
        loading += "if (jacobian !== robot.jacobian || n !== 7) throw new Error();\n"
    else:
        loading = f"{text}const robot = lwr4plus;\n"
    begin = 'import { createRequire } from "module";\nconst require = createRequire(import.meta.url);\n'
    results = node(tmp_path, begin + loading + USE, "use.mjs")
    cases = json.loads(vectors.read_text())["functions"]
    assert len(cases) == 3
    for case, rows in zip(cases, results, strict=True):
        wanted = np.array(case["result"]["rows"])
        assert np.abs(np.array(rows) - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_functions_with_branches_stand_in_the_same_object(tmp_path):
    source = {"js": "const half = 0.5;\nfunction @NAME@(x) { return half * x; }\nconst third = x => x / 3;\n"}
    halved = TemplateFunction("halved", "x / 2", {"js": "halved, third"}, source)
    only_c = TemplateFunction("only_c", "", {}, {"c": ""})
    text = javascript_source([*emitted_robot("kr30ha", ("gravity_vector",)).functions, halved, only_c], "robot")
    members = ["name", "n", "functions", "gravity_vector", "halved", "third"]
    assert evaluated(text, "[robot.halved(3), Object.keys(robot), robot.n]", tmp_path) == [1.5, members, 6]


def test_a_compact_file_is_shorter_and_the_same(tmp_path):
    functions = emitted_robot("kr30ha", ("gravity_vector", "jacobian")).functions
    plain, short = (javascript_source(functions, "robot", is_compact=c) for c in (False, True))
    assert len(short) < 0.8 * len(plain)
    calls = "[robot.jacobian([1, -2, .3, .4, 5, 6]), robot.gravity_vector([1, 2, 3, 4, 5, 6])].map(x => [...x])"
    one, other = (evaluated(text, calls, tmp_path) for text in (plain, short))
    assert one == other


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--out", "a.txt"), "a path that ends in .js (a plain script) or .mjs (an ES module)"),
        (("--out", "a.js", "--dtype", "float32"), "numbers of JavaScript are double"),
        (("--out", "a.js", "--prefix", "class"), "a name that JavaScript and browsers have not taken"),
        (("--out", "/no/such/folder/a.js"), "no directory /no/such/folder"),
    ],
)
def test_bad_input_gets_one_line(options, message, lwr_dyn_command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OptionError, match="script, module"):
        javascript_source([], "robot", form="amd")
    code, out, err = lwr_dyn_command("kernels", "kr30ha", "--language", "js", "--emit", "jacobian", *options)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


LARGEST_BYTECODE = 61_440
"""V8's max_optimized_bytecode_size."""


@pytest.mark.slow
@pytest.mark.parametrize("arm", ARMS)
def test_values_with_the_librarys_sines_are_those_of_python(arm, tmp_path):
    """Those of its own sines have the bits of C: `test_javascript_file_bits`."""
    robot, dynamics = emitted_robot(arm), lwr_dyn.dynamics_of(lwr_dyn.load(arm))
    states = np.random.default_rng(5).uniform(-3.0, 3.0, (20, 3, robot.functions[0].width))
    text = javascript_source(robot.functions, "robot", sincos="libm")
    for f in robot.functions:
        calls = f"{states[:, : len(f.arguments)].tolist()}.map(s => [...robot.{f.name}(...s)])"
        wanted = getattr(dynamics, f.name)(*np.swapaxes(states, 0, 1)[: len(f.arguments)])
        found = np.reshape(evaluated(text, calls, tmp_path), wanted.shape)
        assert np.abs(found - wanted).max() < 1e-13 * np.abs(wanted).max(), f.name


def test_sine_and_cosine_beside_mpmath(tmp_path):
    import mpmath

    x = [*np.random.default_rng(2).uniform(-50.0, 50.0, 300), 0.0, np.pi, -np.pi / 2, 1e-9, 1e5]
    calls = f"{json.dumps(x)}.map(a => (sincos([a], 0), [...turned]))"
    for angle, pair in zip(x, evaluated(shared_functions("sincos("), calls, tmp_path), strict=True):
        assert max(abs(f(angle) - found) for f, found in zip((mpmath.sin, mpmath.cos), pair, strict=True)) < 3e-16


def test_rarer_operations_beside_numpy(tmp_path):
    """Exponential, tanh, logarithm by the bits of numbers; choices, smallest, largest, absolute, a comparison."""
    x, y = casadi.SX.sym("x"), casadi.SX.sym("y")
    results = [casadi.exp(x), casadi.tanh(x), casadi.log(casadi.fabs(x)), casadi.fmin(x, y), casadi.fmax(x, y),
               casadi.if_else(x < y, x * y, -y), casadi.sqrt(casadi.fabs(x)), casadi.fabs(y)]  # fmt: skip
    symbolic = casadi.Function("f", [x, y], [casadi.vertcat(*results)])
    arguments = Argument("x", 1, "1"), Argument("y", 1, "1")
    function = EmittedFunction("rarer", "", arguments, (8,), "1", symbolic)
    text = javascript_source([function], "robot")
    states = np.random.default_rng(4).normal(size=(200, 2)) * np.geomspace(1e-6, 100.0, 200)[:, None]
    values = evaluated(text, f"{states.tolist()}.map(([x, y]) => Array.from(robot.rarer([x], [y])))", tmp_path)
    x, y = states.T
    wanted = np.array([np.exp(x), np.tanh(x), np.log(abs(x)), np.minimum(x, y), np.maximum(x, y),
                       np.where(x < y, x * y, -y), np.sqrt(abs(x)), abs(y)])  # fmt: skip
    assert (np.abs(np.transpose(values) - wanted) <= 2e-15 * np.abs(wanted)).all()


@pytest.mark.slow
def test_a_split_function_has_the_same_bits_and_small_parts(tmp_path):
    function = emitted_robot(ARMS[0]).functions[DYNAMICS.index("coriolis_matrix")]
    code = emitted_code(function, "libm")
    split = js_function(code, "split", largest=600)
    heads = re.findall(r"function (split_\d+)\(", split)
    assert len(heads) > 3
    for part in split.split("\nfunction ")[: len(heads)]:
        assert len(re.findall(r"^  v\d+ = ", part, re.M)) <= 600 + 14  # and the sines and cosines
    text = js_function(code, "whole") + split
    text = shared_functions(text) + text
    q, dq = np.random.default_rng(1).uniform(-2.0, 2.0, (2, 7)).tolist()
    whole, parts = evaluated(text, f"[whole, split].map(f => Array.from(f({q}, {dq})))", tmp_path)
    assert whole == parts


def test_a_function_without_end_of_results_is_split_no_further():
    function = emitted_robot(ARMS[2]).functions[DYNAMICS.index("gravity_vector")]
    text = js_function(emitted_code(function, "libm"), "g", largest=1)
    assert len(re.findall(r"function g_\d+", text)) == function.width


@pytest.mark.slow
def test_v8_compiles_every_function(tmp_path):
    """Bytecode below V8's bound, and machine code of its best compiler; the largest functions we have."""
    names = ("forward_dynamics", "coriolis_matrix", "torque_regressor")
    path = tmp_path / "compiled.js"
    path.write_text(javascript_source(emitted_robot("wam7", names).functions, "robot") + _OPTIMISED)
    flags = "--print-bytecode", "--print-bytecode-filter=*_*"
    shown = output([program("node"), "--allow-natives-syntax", *flags, str(path)])
    found = re.findall(r"\[generated bytecode for function: (\w+) .*?\]\nBytecode length: (\d+)", shown)
    sizes = {name: int(size) for name, size in found if name in names}
    assert set(sizes) == set(names)
    assert max(sizes.values()) < 0.75 * LARGEST_BYTECODE
    assert optimised(path) == dict.fromkeys(names, True)
    bound = sizes["coriolis_matrix"] - 1
    assert optimised(path, f"--max-optimized-bytecode-size={bound}") == {name: sizes[name] <= bound for name in names}


def optimised(path, *flags):
    """Whether V8's best compiler takes each function of `robot`."""
    shown = output([program("node"), "--allow-natives-syntax", *flags, str(path)])
    return json.loads(shown.splitlines()[-1])


_OPTIMISED = """
const optimised = {};
for (const [name, about] of Object.entries(robot.functions)) {
  const values = about.arguments.map(([, width]) => new Float64Array(width)), out = new Float64Array(about.width);
  const f = robot[name];
  %PrepareFunctionForOptimization(f);
  for (let k = 0; k < 3; k++) f(...values, out);
  %OptimizeFunctionOnNextCall(f);
  f(...values, out);
  optimised[name] = (%GetOptimizationStatus(f) & 16) !== 0;
}
console.log(JSON.stringify(optimised));
"""
"""Bit 4 (16) of the status: optimised."""
