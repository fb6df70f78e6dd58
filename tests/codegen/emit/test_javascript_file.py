"""Files of JavaScript: script and module, from the command, with the test vectors; bad paths in one line."""

import json

import numpy as np
import pytest

from lwr_dyn.codegen.emit.functions import TemplateFunction
from lwr_dyn.codegen.emit.javascript_file import javascript_source
from lwr_dyn.foundation.errors import OptionError
from tests.codegen.emit.emitted_robots import emitted_robot
from tests.codegen.emit.programs import output, program

USE = """
const cases = JSON.parse(require("fs").readFileSync(process.argv[2]));
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
    use = tmp_path / "use.mjs"
    if ending == ".mjs":
        loading = f"import robot, {{ jacobian, n }} from {json.dumps(out.as_uri())};\n"
        loading += "if (jacobian !== robot.jacobian || n !== 7) throw new Error();\n"
    else:
        loading = f"{text}const robot = lwr4plus;\n"
    use.write_text('import { createRequire } from "module";\nconst require = createRequire(import.meta.url);\n'
                   + loading + USE)  # fmt: skip
    results = json.loads(output([program("node"), str(use), str(vectors)]))
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
    path = tmp_path / "run.js"
    path.write_text(text + "console.log(JSON.stringify([robot.halved(3), Object.keys(robot), robot.n]));")
    members = ["name", "n", "functions", "gravity_vector", "halved", "third"]
    assert json.loads(output([program("node"), str(path)])) == [1.5, members, 6]


def test_a_compact_file_is_shorter_and_the_same(tmp_path):
    functions = emitted_robot("kr30ha", ("gravity_vector", "jacobian")).functions
    plain, short = (javascript_source(functions, "robot", is_compact=c) for c in (False, True))
    assert len(short) < 0.8 * len(plain)
    path = tmp_path / "run.js"
    results = []
    for text in (plain, short):
        path.write_text(
            text + "console.log(robot.jacobian([1, -2, .3, .4, 5, 6]), robot.gravity_vector([1,2,3,4,5,6]));"
        )
        results.append(output([program("node"), str(path)]))
    assert results[0] == results[1]


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
    code, out, err = lwr_dyn_command("kernels", "kr30ha", "--language", "js", "--emit", "jacobian", *options)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_another_form_is_refused():
    with pytest.raises(OptionError, match="script, module"):
        javascript_source([], "robot", form="amd")
