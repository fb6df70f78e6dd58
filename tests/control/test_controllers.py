"""A controller's text gives it the options that `simulate` has, and wrappers; anything else is one line."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import controller_spec
from lwr_dyn.foundation.errors import LwrDynError


def test_options_reach_the_factory_under_their_names_in_simulate(arm):
    spec = controller_spec("pid:omega-n=20:velocity-error:ki=7")
    made = spec.make(arm, lwr_dyn.dynamics_of(arm))
    same = lwr_dyn.controller("pid", arm, omega_n=20.0, velocity_error=True, ki=7.0)
    assert made.parameters == same.parameters
    assert not controller_spec("inverse-dynamics:no-feedforward").make(arm, lwr_dyn.dynamics_of(arm)).feedforward


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
