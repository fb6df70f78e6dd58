"""Laws as one function: torques and memory in C are those of the controllers along samples, with any gains."""

import json
import subprocess

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.codegen.emit.functions import EMITTED
from lwr_dyn.codegen.emit.further_functions import STEP, step_function
from lwr_dyn.codegen.emit.javascript_file import javascript_source
from lwr_dyn.codegen.rollouts.law_forms import LAW_FORMS, NoKernelFormError, law_form, states_of
from lwr_dyn.codegen.rollouts.law_forms import STEP as H
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.paper_laws import PID
from lwr_dyn.control.protocol import reset
from lwr_dyn.foundation.errors import MissingDataError
from tests.codegen.emit.programs import program
from tests.codegen.emit.shared_library import SharedLibrary

CLOSE = 1e-12
LAWS = tuple(LAW_FORMS.names)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    names = [STEP + law.replace("-", "_") for law in LAWS]
    return SharedLibrary(emitted_arm(lwr_dyn.load("lwr4plus"), names), tmp_path_factory.mktemp("laws"))


def arguments_of(form, state, memory):
    """The arrays of a call, in order."""
    kept = [memory, np.array([H])] if form.memory else []
    return [
        *(np.ascontiguousarray(x) for x in state),
        *kept,
        *(np.array(x, float).ravel() for x in form.values().values()),
    ]


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
    assert {f"{STEP}{law.replace('-', '_')}" for law in LAWS} == {
        name for name in EMITTED.names if name.startswith(STEP)
    }


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_the_step_in_c_is_the_controller(library, law):
    controller = make_controller(law, library.arm)
    form, name = law_form(controller, library.arm), STEP + law.replace("-", "_")

    def call(given):
        out = np.zeros(library.arm.n + form.memory)
        library.call(name, *given, out, kind=None)
        return out

    assert worst(form, controller, library.arm, call) < CLOSE


@pytest.mark.slow
def test_other_gains_are_arguments_of_the_same_function(library):
    arm = library.arm
    law = PID(900.0, 40.0, arm.effort, 300.0, lwr_dyn.dynamics_of(arm), tracking_time=0.2)
    form = law_form(law, arm)

    def call(given):
        out = np.zeros(2 * arm.n)
        library.call("step_pid", *given, out, kind=None)
        return out

    assert worst(form, law, arm, call) < CLOSE


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pid+friction", "inverse-dynamics+friction-measured"])
def test_friction_around_a_law_in_javascript(law, tmp_path):
    arm = lwr_dyn.load("wam7")
    controller = make_controller(law, arm)
    form, function = law_form(controller, arm), step_function(controller, arm)
    assert [a.name for a in function.arguments][-2:] == ["law_friction", "law_friction_width"]
    rows = [arguments_of(form, state, 0.1 + form.start()) for sequence in states_of(arm) for state in sequence]
    text = javascript_source([function], "robot")
    calls = json.dumps([[x.tolist() for x in row] for row in rows])
    (tmp_path / "law.js").write_text(f"{text}\nconsole.log(JSON.stringify({calls}.map(a => [...robot.step(...a)])));\n")
    made = subprocess.run([program("node"), "law.js"], cwd=tmp_path, capture_output=True, text=True, check=True)
    found = np.array(json.loads(made.stdout))
    expected = np.array([np.array(function.symbolic(*row)).ravel() for row in rows])
    assert np.abs(found - expected).max() < CLOSE * np.abs(expected).max()

    def call(given):
        return np.array(function.symbolic(*given)).ravel()

    assert worst(form, controller, arm, call) < CLOSE


def test_text_says_the_tuned_gains_and_the_memory():
    arm = lwr_dyn.load("lwr4plus")
    function = step_function(make_controller("pid", arm), arm, "pid")
    assert function.shape == (14,)
    assert "starts at 0" in function.text
    assert "law_effort = 176, 176, 100, 100, 100, 38, 38" in function.text
    assert "Kp = 2500; Kd = 100" in step_function(make_controller("inverse-dynamics", arm), arm).text


@pytest.mark.slow
def test_controllers_without_form_and_arms_without_masses_are_refused():
    arm = lwr_dyn.load("lwr4plus")
    with pytest.raises(NoKernelFormError):
        step_function(make_controller("joint-impedance", arm), arm)
    with pytest.raises(MissingDataError):
        emitted_arm(lwr_dyn.load("lwr4"), ["step_pid"])
    assert "step_motor_pd" in dict(emitted_arm(lwr_dyn.load("wam7")).left_out)
