"""The test vectors in JSON: complete, and what the emitted JavaScript gives, inverse kinematics included."""

import json

import casadi
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.emission import emitted_arm, vectors_text
from lwr_dyn.codegen.emit.functions import Argument, EmittedFunction, Store, emitted_code
from lwr_dyn.codegen.emit.javascript_file import js_files
from tests.codegen.emit.programs import node

RUN = """
import { readFileSync } from "fs";
import robot from "./arm.mjs";
const vectors = JSON.parse(readFileSync("vectors.json", "utf8"));
const apart = (a, b) => (b === null ? (Number.isNaN(a) ? 0 : 1) : Math.abs(a - b));
const compared = {};
for (const f of vectors.functions) {
  let worst = 0, calls = 0;
  const rows = f.result.rows, straight = f.result.tolerance === undefined;
  rows.forEach((row, k) => {
    const given = f.arguments.map((a) => (straight || a.rows[k].length > 1 ? a.rows[k] : a.rows[k][0]));
    const expected = row.flat(2), pairs = f.name.endsWith("_intervals");
    const out = new Float64Array(pairs ? 256 : expected.length), counts = new Int32Array(8);
    const returned = robot[f.name](...given, out, ...(pairs ? [counts] : []));
    const found = pairs ? row.flatMap((_, b) => [...out.subarray(32 * b, 32 * b + 2 * counts[b])]) : [...out];
    const tolerance = straight ? 1e-12 * Math.max(0.1, ...rows.flat().map(Math.abs)) : f.result.tolerance;
    if (found.length !== expected.length) worst = Infinity;
    expected.forEach((x, i) => { worst = Math.max(worst, apart(found[i], x) / (tolerance || 1e-300)); });
    if (f.result.returned) worst = Math.max(worst, apart(returned, f.result.returned[k]) / 1e-9);
    calls++;
  });
  compared[f.name] = [worst, calls];
}
console.log(JSON.stringify(compared));
"""


def compared(folder, robot, functions, change=lambda vectors: None):
    """Function -> (worst difference as a share of what is allowed, calls)."""
    emitted = emitted_arm(lwr_dyn.load(robot), functions)
    (folder / "arm.mjs").write_text(js_files(emitted, folder / "arm.mjs")[folder / "arm.mjs"])
    vectors = json.loads(vectors_text(emitted))
    change(vectors)
    (folder / "vectors.json").write_text(json.dumps(vectors))
    names = {c.function.name for c in emitted.codes} | {t.name for t in emitted.templates}
    return names, node(folder, RUN, "run.mjs")


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "functions"), [("kr30ha", ()), ("lwr4plus", ("inverse_kinematics", "flange_pose"))])
def test_javascript_gives_every_vector(robot, functions, tmp_path):
    names, found = compared(tmp_path, robot, functions)
    assert names <= set(found)
    assert max(worst for worst, _ in found.values()) <= 1.0, found
    assert found["inverse_kinematics"][1] == 4
    assert found["inverse_kinematics_near"][1] >= 2


def test_a_vector_that_differs_is_seen(tmp_path):
    def change(vectors):
        (near,) = (f for f in vectors["functions"] if f["name"] == "inverse_kinematics_near")
        near["result"]["rows"][1][2] += 1e-8

    _, found = compared(tmp_path, "kr30ha", ("inverse_kinematics", "gravity_vector"), change)
    assert [name for name, (worst, _) in found.items() if not worst <= 1.0] == ["inverse_kinematics_near"]


X = casadi.SX.sym("x", 2)


@pytest.mark.parametrize(
    ("results", "early", "stores"),
    [
        ((X[0] + 1.0, X[1] * X[0]), False, [2, 3]),  # both at the end
        ((X[1], X[0] + 1.0), True, [0, 2]), ((X[0] + 1.0, X[1], X[0]), True, [0, 1, 3]),
        ((X[0] + 1.0, X[0] * X[1], X[1] - 2.0), True, [1, 3, 5]),
    ],
)  # fmt: skip
def test_results_may_stand_in_an_argument_where_they_are_stored_last(results, early, stores):
    """Not where one is an argument itself, which a result before it would change, nor where they are more numbers."""
    symbolic = casadi.Function("f", [X], [casadi.vertcat(*results)])
    code = emitted_code(EmittedFunction("f", "", (Argument("x", 2, "rad"),), (len(results),), "1", symbolic))
    assert code.stores_early == early
    assert [i for i, one in enumerate(code.statements) if isinstance(one, Store)] == stores
