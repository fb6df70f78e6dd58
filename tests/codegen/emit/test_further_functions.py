"""Laws as one function: torques and memory in C are those of the controllers along samples, with any gains."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit import further_functions as further
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.codegen.emit.functions import EMITTED, emitted_function
from lwr_dyn.codegen.emit.javascript_file import javascript_source
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from lwr_dyn.codegen.rollouts.law_forms import LAW_FORMS, NoKernelFormError, law_form, states_of
from lwr_dyn.codegen.rollouts.law_forms import STEP as H
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.paper_laws import PID
from lwr_dyn.control.protocol import reset
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.friction import Direction, JointFriction, friction_torque, smooth_friction
from tests.codegen.emit.programs import node
from tests.codegen.emit.shared_library import SharedLibrary

CLOSE = 1e-12
LAWS = tuple(LAW_FORMS.names)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    names = [further.STEP + law.replace("-", "_") for law in LAWS]
    return SharedLibrary(emitted_arm(lwr_dyn.load("lwr4plus"), names), tmp_path_factory.mktemp("laws"))


def arguments_of(form, state, memory):
    """The arrays of a call, in order."""
    kept = [memory, np.array([H])] if form.memory else []
    values = [np.array(x, float).ravel() for x in form.values().values()]
    return [*map(np.ascontiguousarray, state), *kept, *values]


def worst(form, controller, arm, call):
    """The largest difference of a torque, as a share of the largest one of its sample, with the memory handed on."""
    share = 0.0
    for sequence in states_of(arm):
        reset(controller)
        memory = form.start().copy()
        for k, state in enumerate(sequence):
            tau = np.array(controller(k * H, *np.array(state)))
            out = call(arguments_of(form, state, memory))
            memory = out[arm.n :].copy()
            share = max(share, np.abs(out[: arm.n] - tau).max() / max(1.0, np.abs(tau).max()))
    return share


def test_every_law_with_a_form_has_a_step():
    steps = {name.removeprefix(further.STEP) for name in EMITTED.names if name.startswith(further.STEP)}
    assert steps == {law.replace("-", "_") for law in LAWS}


@pytest.mark.slow
@pytest.mark.parametrize("law", [*LAWS, "other gains"])
def test_the_step_in_c_is_the_controller_whose_gains_are_arguments(library, law):
    arm = library.arm
    if law == "other gains":
        law = "pid"
        controller = PID(900.0, 40.0, arm.effort, 300.0, lwr_dyn.dynamics_of(arm), tracking_time=0.2)
    else:
        controller = make_controller(law, arm)
    form = law_form(controller, arm)

    def call(given):
        out = np.zeros(arm.n + form.memory)
        library.call(further.STEP + law.replace("-", "_"), *given, out, kind=None)
        return out

    assert worst(form, controller, arm, call) < CLOSE


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pid+friction", "inverse-dynamics+friction-measured"])
def test_friction_around_a_law_in_javascript(law, tmp_path):
    arm = lwr_dyn.load("wam7")
    controller = make_controller(law, arm)
    form, function = law_form(controller, arm), further.step_function(controller, arm)
    assert [a.name for a in function.arguments][-2:] == ["law_friction", "law_friction_width"]
    rows = [arguments_of(form, state, 0.1 + form.start()) for sequence in states_of(arm) for state in sequence]
    text = javascript_source([function], "robot")
    calls = json.dumps([[x.tolist() for x in row] for row in rows])
    found = np.array(node(tmp_path, f"{text}\nconsole.log(JSON.stringify({calls}.map(a => [...robot.step(...a)])));\n"))
    expected = np.array([np.array(function.symbolic(*row)).ravel() for row in rows])
    assert np.abs(found - expected).max() < CLOSE * np.abs(expected).max()

    def call(given):
        return np.array(function.symbolic(*given)).ravel()

    assert worst(form, controller, arm, call) < CLOSE


def test_text_says_the_tuned_gains_and_the_memory():
    arm = lwr_dyn.load("lwr4plus")
    function = further.step_function(make_controller("pid", arm), arm, "pid")
    assert function.shape == (14,)
    assert "starts at 0" in function.text
    assert "law_effort = 176, 176, 100, 100, 100, 38, 38" in function.text
    assert "Kp = 2500; Kd = 100" in further.step_function(make_controller("inverse-dynamics", arm), arm).text


@pytest.mark.slow
def test_controllers_without_form_and_arms_without_masses_are_refused():
    arm = lwr_dyn.load("lwr4plus")
    with pytest.raises(NoKernelFormError):
        further.step_function(make_controller("joint-impedance", arm), arm)
    with pytest.raises(MissingDataError):
        emitted_arm(lwr_dyn.load("lwr4"), ["step_pid"])
    assert "step_motor_pd" in dict(emitted_arm(lwr_dyn.load("wam7")).left_out)


def state(n, seed=0):
    return np.random.default_rng(seed).uniform(-2.0, 2.0, (3, n))


@pytest.mark.parametrize(("robot", "distinct", "zeros"), [("lwr4plus", 248, 236), ("kr30ha", 167, 164)])
def test_half_of_the_places_are_zero_and_the_rest_are_shared(robot, distinct, zeros):
    spec = kernel_spec(lwr_dyn.load(robot))
    compact = further.compact_regressor(spec)
    assert compact.function.size1_out(0) == distinct
    assert (compact.index == 0).sum() == zeros
    assert set(np.abs(compact.index)) == set(range(distinct + 1))
    dense = emitted_function(spec, further.DENSE, lwr_dyn.load(robot)).symbolic
    for seed in range(3):
        given = state(spec.n, seed)
        values = np.append(0.0, np.array(compact.function(*given)).ravel())
        expected = np.array(dense(*given)).ravel()
        found = np.sign(compact.index) * values[np.abs(compact.index)]
        assert np.abs(found - expected).max() < CLOSE * np.abs(expected).max()


@pytest.mark.slow
def test_c_and_javascript_place_them_as_python(tmp_path):
    arm = lwr_dyn.load("kr30ha")
    emitted = emitted_arm(arm, [further.COMPACT, further.EXPANDED])
    library, given = SharedLibrary(emitted, tmp_path), state(arm.n)
    compact = further.compact_regressor(emitted.spec)
    values, whole = np.zeros(compact.function.size1_out(0)), np.zeros(compact.index.size)
    library.call(further.COMPACT, *given, values)
    library.call(further.EXPANDED, values, whole)
    expected = np.array(emitted_function(emitted.spec, further.DENSE, arm).symbolic(*given)).ravel()
    assert np.abs(whole - expected).max() < CLOSE * np.abs(expected).max()
    text = javascript_source(
        [emitted_function(emitted.spec, name, arm) for name in (further.COMPACT, further.EXPANDED)], "robot"
    )
    script = f"""{text}
const values = robot.{further.COMPACT}(...{json.dumps(given.tolist())});
const places = [...Array({compact.index.size}).keys()].map(robot.{further.EXPANDED}_index);
console.log(JSON.stringify([[...robot.{further.EXPANDED}(values)], places]));
"""
    found, places = node(tmp_path, script)
    assert np.abs(found - expected).max() < CLOSE * np.abs(expected).max()
    assert places == compact.index.tolist()


def test_torque_is_the_regressor_times_the_parameters():
    arm = lwr_dyn.load("kr30ha")
    spec, given = kernel_spec(arm), state(arm.n, 7)
    compact = further.compact_regressor(spec)
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
    made = further.compact_result(casadi.Function("f", [x], [casadi.densify(out)]))
    assert made.index.tolist() == [-1, 0, 1, 2]
    assert np.array(made.function(0.5)).ravel() == pytest.approx([np.sin(0.5), 1.5])
    with pytest.raises(OptionError, match="always the same"):
        further.compact_result(casadi.Function("f", [x], [casadi.vertcat(x, 3)]))


def test_an_arm_without_masses_has_one_too():
    (code,) = emitted_arm(lwr_dyn.load("lwr4"), [further.COMPACT]).codes
    assert code.function.width < 490 / 2 + 20


@pytest.mark.parametrize("curve", [None, 0.05])
def test_friction_is_that_of_the_models(curve, tmp_path):
    arm = lwr_dyn.load("wam7")
    models = arm.friction_models()
    if curve is not None:
        first = JointFriction(Direction(4.0, 1.0, 6.0, curve), Direction(3.0, 0.5, 3.5, 2.0 * curve), 0.3)
        models = (first, *models[1:])
    arm = replace(arm, friction=models)
    library = SharedLibrary(emitted_arm(arm, list(further.TEXT)), tmp_path)
    out, width = np.zeros(7), 2e-3
    smooth = smooth_friction(models, width)
    for speed in (-2.0, -1e-3, 0.0, 1e-6, 0.02, 1.5):
        dq = speed * np.linspace(1.0, 1.3, 7)
        library.call("friction_torque", dq, out, kind=None)
        assert np.abs(out - friction_torque(models, dq)).max() < 1e-13
        library.call("smooth_friction_torque", dq, np.array([width]), out, kind=None)
        assert np.abs(out - smooth(dq)).max() < 1e-13


def test_an_arm_without_friction_has_none_and_one_that_grows_with_the_load_is_refused():
    with pytest.raises(MissingDataError, match="friction"):
        emitted_arm(lwr_dyn.load("lwr4plus"), ["friction_torque"])
    arm = lwr_dyn.load("wam7")
    grows = replace(arm, friction=(*arm.friction[:6], replace(arm.friction[6], load=0.05)))
    for name in ("friction_torque", "smooth_friction_torque"):
        with pytest.raises(OptionError, match=r"friction of joint_7: 0\.05 of the load; allowed: none: the functions"):
            further.friction_function(kernel_spec(arm), name, grows)


def test_a_sigmoid_is_emitted_as_it_is():
    """Of the Panda: smooth by itself, whatever the width."""
    arm = lwr_dyn.load("panda")
    v = np.random.default_rng(3).uniform(-2.0, 2.0, arm.n)
    expected = friction_torque(arm.friction_models(), v)
    for name, arguments in (("friction_torque", (v,)), ("smooth_friction_torque", (v, 1e-3))):
        function = further.friction_function(kernel_spec(arm), name, arm).symbolic
        np.testing.assert_allclose(np.array(function(*arguments)).ravel(), expected, atol=1e-14)
