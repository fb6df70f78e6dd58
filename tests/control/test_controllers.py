"""A controller's text gives it the options that `simulate` has, and wrappers; anything else is one line."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS, controller_spec
from lwr_dyn.foundation.errors import LwrDynError


def test_options_reach_the_factory_under_their_names_in_simulate(arm):
    spec = controller_spec("pid:omega-n=20:velocity-error:ki=7")
    made = spec.make(arm, lwr_dyn.dynamics_of(arm))
    same = lwr_dyn.controller("pid", arm, omega_n=20.0, velocity_error=True, ki=7.0)
    assert made.parameters == same.parameters
    assert not controller_spec("inverse-dynamics:no-feedforward").make(arm, lwr_dyn.dynamics_of(arm)).feedforward


@pytest.mark.parametrize("name", CONTROLLERS.names)
def test_every_row_makes_a_law_that_bears_its_name(name, arm):
    assert "lwr_dyn" not in CONTROLLERS[name].about
    assert lwr_dyn.controller(name, arm).name == name


def test_tuned_options_go_before_those_of_the_text(arm):
    made = controller_spec("pd-gravity:omega-n=20").make(arm, lwr_dyn.dynamics_of(arm), {"omega_n": 30.0})
    assert made.parameters["Kp"] == lwr_dyn.controller("pd-gravity", arm, omega_n=30.0).parameters["Kp"]


def test_wrappers_follow_a_plus():
    spec = controller_spec("pid:omega-n=20+friction+friction-measured")
    assert (spec.base, spec.wrappers, spec.name) == (
        "pid",
        ("friction", "friction-measured"),
        "pid+friction+friction-measured",
    )


def test_a_file_takes_options_of_its_own(arm, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "def make(arm, dynamics, gain=1.0, quiet=False, word=''):\n"
        "    return lambda *given: given[1] * 0 + (gain if quiet and word == 'a-b' else 0.0)\n"
    )
    made = controller_spec(f"{file}:gain=3:quiet:word=a-b").make(arm, lwr_dyn.dynamics_of(arm))
    np.testing.assert_array_equal(made(0.0, np.zeros(7), *[np.zeros(7)] * 4), 3.0)


BAD = {
    "unknown": ("pdi", "no controller named 'pdi' (did you mean pid?)"),
    "unknown with options": ("pdi:omega-n=2", "no controller named 'pdi'"),
    "empty": (":omega-n=2", "no controller named ':omega-n=2'"),
    "unknown option": (
        "pid:omega=2",
        "controller pid: option 'omega' (did you mean omega-n?); allowed: omega-n, xi, ki, velocity-error",
    ),
    "no value": ("pid:omega-n", "controller pid: omega-n: no value; allowed: omega-n=VALUE (Natural frequency, rad/s)"),
    "no number": ("pid:omega-n=fast", "controller pid: omega-n: 'fast'; allowed: a number (Natural"),
    "a switch with a value": ("pid:velocity-error=yes", "with the value 'yes'; allowed: velocity-error, without a"),
    "twice": ("pid:xi=1:xi=2", "xi twice; allowed: each option once"),
    "negative": ("pid:omega-n=-2", "omega_n: -2.0; allowed: a number above 0"),
    "an unknown wrapper": ("pid+frition", "no controller wrapper named 'frition' (did you mean friction?)"),
    "an option after a wrapper": ("pid+friction:xi=1", "allowed: NAME:OPTION=VALUE:SWITCH+WRAPPER"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, arm):
    text, message = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        controller_spec(text).make(arm, lwr_dyn.dynamics_of(arm))
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)


def test_an_unknown_wrapper_is_refused_before_there_is_an_arm():
    with pytest.raises(LwrDynError, match="no controller wrapper named 'frition'"):
        controller_spec("pid+frition")


HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")
FUNCTION = "def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n    return {}\n"
FILE_BAD = {
    "not there": (None, "no such file or directory; allowed: a Python file with controller(t, q, dq,"),
    "not Python": ("def controller(:\n", "line 1: SyntaxError"),
    "fails when it is read": ("import numpy\n\nnumpy.nothing()\n", "line 3: AttributeError: module 'numpy' has no"),
    "ends the program": ("import sys\nsys.exit(3)\n", "line 2: SystemExit: 3"),
    "without a controller": ("Kp = 3\n", "no function of six arguments for a controller"),
    "of five arguments": ("def controller(t, q, dq, q_ref, dq_ref): ...\n", "no function of six arguments"),
    "make of one argument": ("def make(arm): ...\n", "make does not take two arguments"),
    "make returns nothing": ("def make(arm, dynamics): ...\n", "no function of six arguments"),
    "make fails": ("def make(arm, dynamics):\n    return arm.nothing\n", "line 2: AttributeError"),
    "fails when it runs": (FUNCTION.format("q[9]"), "line 2: IndexError"),
    "no torques": (FUNCTION.format("None"), "torque of the controller at sample 0: shape (); allowed: 7 numbers"),
}


@pytest.mark.parametrize("case", FILE_BAD)
def test_a_bad_file_is_one_line(case, lwr_dyn_command, tmp_path):
    text, message = FILE_BAD[case]
    path = tmp_path / "own.py"
    if text is not None:
        path.write_text(text)
    code, out, err = lwr_dyn_command("simulate", "lwr4plus", *HOLD, "--controller", str(path))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err


def test_a_function_and_a_factory_are_taken(lwr_dyn_command, tmp_path):
    own = tmp_path / "gentle.py"
    own.write_text(FUNCTION.format("400.0 * (q_ref - q) - 20.0 * dq"))
    record = json.loads(lwr_dyn_command("simulate", "lwr4plus", *HOLD, "--controller", str(own), "--json")[1])
    assert record["meta"]["controller"] == {"name": "gentle.py", "label": "gentle.py", "parameters": {}}
    own.write_text(
        "def make(arm, dynamics, gain=400.0):\n"
        "    def soft(t, q, dq, q_ref, dq_ref, ddq_ref):\n"
        "        return dynamics.inverse_dynamics(q, dq, gain * (q_ref - q) - 40.0 * dq)\n"
        "    soft.name, soft.parameters = 'soft', {'gain': gain}\n"
        "    return soft\n"
    )
    arm = lwr_dyn.load("lwr4plus")
    assert lwr_dyn.controller(str(own), arm, gain=9.0).parameters == {"gain": 9.0}
    with pytest.raises(LwrDynError, match=r"Kp: no option of make in .*gentle.py; allowed: gain"):
        lwr_dyn.controller(str(own), arm, Kp=1.0)
    assert lwr_dyn_command("simulate", "lwr4plus", *HOLD, "--controller", str(own))[0] == 0
    code, _, err = lwr_dyn_command("simulate", "lwr4plus", *HOLD, "--controller", str(own), "--xi", "2")
    assert code == 2
    assert "--xi: would do nothing here; allowed: with --controller pd-gravity, pid, inverse-dynamics" in err


def test_the_new_file_runs_and_follows(lwr_dyn_command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, _ = lwr_dyn_command("new", "controller", "mine.py")
    assert (code, out) == (
        0, "wrote mine.py; next: edit it, then  lwr-dyn simulate lwr4plus --controller mine.py\n"
    )  # fmt: skip
    assert "--controller mine.py" in (tmp_path / "mine.py").read_text()
    move = ("--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "9,40,0,-60,0,30,0")
    done = lwr_dyn_command("simulate", "lwr4plus", *move, "--controller", "mine.py", "--json")
    assert json.loads(done[1])["metrics"]["tip_max_mm"] < 0.1
    assert [p.name for p in tmp_path.iterdir()] == ["mine.py"]
    assert "exists already; allowed: a new file" in lwr_dyn_command("new", "controller", "mine.py")[2]
    assert "a path that ends in .py" in lwr_dyn_command("new", "controller", "mine.txt")[2]
