"""The compact regressor: its numbers at the places of its map are the dense one, in C and JavaScript."""

import json
import subprocess

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.codegen.emit.functions import emitted_function
from lwr_dyn.codegen.emit.further_functions import COMPACT, DENSE, EXPANDED, compact_regressor, compact_result
from lwr_dyn.codegen.emit.javascript_file import javascript_source
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.errors import OptionError
from tests.codegen.emit.programs import program
from tests.codegen.emit.shared_library import SharedLibrary

CLOSE = 1e-12


def state(n, seed=0):
    return np.random.default_rng(seed).uniform(-2.0, 2.0, (3, n))


@pytest.mark.parametrize(("robot", "distinct", "zeros"), [("lwr4plus", 248, 236), ("kr30ha", 167, 164)])
def test_half_of_the_places_are_zero_and_the_rest_are_shared(robot, distinct, zeros):
    spec = kernel_spec(lwr_dyn.load(robot))
    compact = compact_regressor(spec)
    assert compact.function.size1_out(0) == distinct
    assert (compact.index == 0).sum() == zeros
    assert set(np.abs(compact.index)) == set(range(distinct + 1))
    dense = emitted_function(spec, DENSE, lwr_dyn.load(robot)).symbolic
    for seed in range(3):
        given = state(spec.n, seed)
        values = np.append(0.0, np.array(compact.function(*given)).ravel())
        expected = np.array(dense(*given)).ravel()
        found = np.sign(compact.index) * values[np.abs(compact.index)]
        assert np.abs(found - expected).max() < CLOSE * np.abs(expected).max()


@pytest.mark.slow
def test_c_and_javascript_place_them_as_python(tmp_path):
    arm = lwr_dyn.load("kr30ha")
    emitted = emitted_arm(arm, [COMPACT, EXPANDED])
    library, given = SharedLibrary(emitted, tmp_path), state(arm.n)
    compact = compact_regressor(emitted.spec)
    values, whole = np.zeros(compact.function.size1_out(0)), np.zeros(compact.index.size)
    library.call(COMPACT, *given, values)
    library.call(EXPANDED, values, whole)
    expected = np.array(emitted_function(emitted.spec, DENSE, arm).symbolic(*given)).ravel()
    assert np.abs(whole - expected).max() < CLOSE * np.abs(expected).max()
    text = javascript_source([emitted_function(emitted.spec, name, arm) for name in (COMPACT, EXPANDED)], "robot")
    script = f"""{text}
const values = robot.{COMPACT}(...{json.dumps(given.tolist())});
const places = [...Array({compact.index.size}).keys()].map(robot.{EXPANDED}_index);
console.log(JSON.stringify([[...robot.{EXPANDED}(values)], places]));
"""
    (tmp_path / "y.js").write_text(script)
    made = subprocess.run([program("node"), "y.js"], cwd=tmp_path, capture_output=True, text=True, check=True)
    found, places = json.loads(made.stdout)
    assert np.abs(found - expected).max() < CLOSE * np.abs(expected).max()
    assert places == compact.index.tolist()


def test_torque_is_the_regressor_times_the_parameters(tmp_path):
    arm = lwr_dyn.load("kr30ha")
    spec, given = kernel_spec(arm), state(arm.n, 7)
    compact = compact_regressor(spec)
    values = np.append(0.0, np.array(compact.function(*given)).ravel())
    Y = (np.sign(compact.index) * values[np.abs(compact.index)]).reshape(arm.n, -1)
    order = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
    parameters = np.concatenate([body_parameters(link.body, order) for link in arm.chain.links])
    rotors = np.array([0.0 if x.rotor is None else x.rotor.gear_ratio**2 * x.rotor.inertia for x in arm.chain.links])
    tau = lwr_dyn.dynamics_of(arm).inverse_dynamics(*given)
    assert np.abs(Y @ parameters + rotors * given[2] - tau).max() < CLOSE * np.abs(tau).max()


def test_results_that_differ_in_sign_are_one_number():
    import casadi

    x = casadi.SX.sym("x")
    out = casadi.vertcat(-casadi.sin(x), 0, casadi.sin(x), 3 * x)
    made = compact_result(casadi.Function("f", [x], [casadi.densify(out)]))
    assert made.index.tolist() == [-1, 0, 1, 2]
    assert np.array(made.function(0.5)).ravel() == pytest.approx([np.sin(0.5), 1.5])
    with pytest.raises(OptionError, match="always the same"):
        compact_result(casadi.Function("f", [x], [casadi.vertcat(x, 3)]))


def test_an_arm_without_masses_has_one_too():
    codes = emitted_arm(lwr_dyn.load("lwr4"), [COMPACT]).codes
    assert codes[0].function.width < 490 / 2 + 20
