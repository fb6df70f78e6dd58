"""`lwr-dyn kernels`: the source of one function, the cost of all, and one line for bad input."""

import json

import pytest


def test_the_command_prints_a_source_or_the_cost_of_functions(lwr_dyn_command):
    code, out, _ = lwr_dyn_command("kernels", "lwr4plus", "--emit", "gravity_vector", "--inputs", "payload")
    assert code == 0
    assert "Inputs: q, payload." in out
    compile(out, "source", "exec")
    code, out, _ = lwr_dyn_command("kernels", "lwr4plus", "--json")
    assert {f["name"]: f["inputs"] for f in json.loads(out)["functions"]}["mass_matrix"] == ["q"]
    code, out, _ = lwr_dyn_command("kernels", "lwr4plus")
    assert "torque_regressor" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("lwr4plus", "--emit", "gravity"), "no function of a batch named 'gravity' (did you mean gravity_vector?)"),
        (("lwr4",), "masses and inertias not given"),
        (("lwr4plus", "--inputs", "colour"), "inputs: 'colour'"),
        (("lwr4plus", "--emit", "jacobian", "--json"), "--json: with --emit"),
        (("lwr4plus", "--dtype", "int8"), "dtype: 'int8'"),
    ],
)
def test_bad_input_gets_one_line(lwr_dyn_command, arguments, message):
    code, out, err = lwr_dyn_command("kernels", *arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
