"""A controller's text gives it the options that `simulate` has, and wrappers; anything else is one line."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS, NO_CODE, _value, controller_spec, faults_in
from lwr_dyn.control.gains import gravity_stiffness
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.control.protocol import reset
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.registry import Option, Quantity, Registry, Row


def test_options_and_wrappers_of_a_text_reach_the_factory_behind_those_that_are_tuned(arm):
    dynamics = lwr_dyn.dynamics_of(arm)
    made = controller_spec("pid:omega-n=20:velocity-error:ki=7").make(arm, dynamics)
    assert made.parameters == lwr_dyn.controller("pid", arm, omega_n=20.0, velocity_error=True, ki=7.0).parameters
    made = controller_spec("pd-gravity:omega-n=20").make(arm, dynamics, {"omega_n": 30.0})
    assert made.parameters == lwr_dyn.controller("pd-gravity", arm, omega_n=30.0).parameters
    spec = controller_spec("pid:omega-n=20+friction+observer")
    assert (spec.base, spec.wrappers, spec.name) == ("pid", ("friction", "observer"), "pid+friction+observer")


@pytest.mark.parametrize("name", CONTROLLERS.names)
def test_every_row_makes_a_law_that_bears_its_name(name, arm):
    assert "lwr_dyn" not in CONTROLLERS[name].about
    assert lwr_dyn.controller(name, arm).name == name


ROTORS = lwr_dyn.load("lwr4plus").armature
WORST = np.linspace(3.0, 0.2, 7)
"""[kg m^2] Given as the worst-case inertia of each joint."""
TUNED = {  # law and options: its label, and its numbers by the formulas of the laws' docstrings
    "pd-gravity:omega-n=20:xi=0.7": ("PD + gravity, damping on dq", {"Kp": 400 * WORST, "Kd": 28 * WORST}),
    "pd-gravity": ("PD + gravity, damping on dq", {"Kp": 2500 * WORST, "Kd": 100 * WORST, "velocity_error": False}),
    "pid:omega-n=20:xi=0.7:velocity-error": (
        "PID + gravity, damping on dq_ref - dq",
        {"Kp": 400 * WORST, "Kd": 28 * WORST, "Ki": 800 * WORST, "tracking_time": np.full(7, np.sqrt(28 / 800)),
         "velocity_error": True, "gravity": True},
    ),
    "pid:ki=3:no-gravity": ("PID, damping on dq", {"Ki": np.full(7, 3.0), "gravity": False, "velocity_error": False}),
    "inverse-dynamics:omega-n=20:xi=0.7": (
        "inverse dynamics with feed-forward",
        {"Kp": np.full(7, 400.0), "Kd": np.full(7, 28.0), "feedforward": True, "gravity": True},
    ),
    "inverse-dynamics:no-feedforward:no-gravity": (
        "inverse dynamics without feed-forward (ddq_ref := 0), without g",
        {"Kp": np.full(7, 2500.0), "Kd": np.full(7, 100.0), "feedforward": False, "gravity": False},
    ),
    "motor-pd:omega-n=20:xi=0.7": (
        "PD on the motor side, feed-forward",
        {"Kp": 400 * WORST, "Kd": 28 * WORST, "stiffness": [1e4] * 4 + [6e3] * 3, "feedforward": True, "lighter": 1.0},
    ),
    "motor-pd:lighter=4:no-feedforward:gear-stiffness=5000": (
        "PD on the motor side, gravity of q_ref, torque feedback (rotors 4 times lighter)",
        {"Kp": 2500 * (WORST - 0.75 * ROTORS), "Kd": 100 * (WORST - 0.75 * ROTORS),
         "stiffness": [5e3] * 4 + [3e3] * 3, "rotor": ROTORS, "lighter": 4.0},
    ),
    "joint-impedance:omega-n=20:xi=0.7": (
        "joint impedance", {"stiffness": 400 * WORST, "xi": 0.7, "feedforward": True}
    ),
    "joint-impedance:stiffness=80:no-feedforward": (
        "joint impedance without feed-forward", {"stiffness": np.full(7, 80.0), "xi": 1.0, "feedforward": False}
    ),
    "cartesian-impedance": (
        "Cartesian impedance",
        {"stiffness": [2000.0] * 3 + [200.0] * 3, "xi": 1.0, "posture": 15.0, "posture_damping": 30.0,
         "feedforward": True},
    ),
    "cartesian-impedance:stiffness=500:rotation=20:xi=0.7:posture=0:no-feedforward": (
        "Cartesian impedance without feed-forward and posture spring",
        {"stiffness": [500.0] * 3 + [20.0] * 3, "xi": 0.7, "posture": 0.0, "posture_damping": 30.0},
    ),
    "adaptive": (
        "adaptive (payload)",
        {"omega_n": 50.0, "gains": [10.0, 0.1, 0.1, 0.1, *[1e-3] * 6]},
    ),
    "adaptive:omega-n=20:adapt-gain=3": (
        "adaptive (payload)", {"omega_n": 20.0, "gains": [3.0, 0.03, 0.03, 0.03, *[3e-4] * 6]}
    ),
    "robust:omega-n=20:largest-load=4:layer=7": (
        "robust (passivity), layer 7",  # 2 kg are the middle, with 10 cm for moments; 1.2 more than the set needs
        {"omega_n": 20.0, "layer": 7.0, "scale": [2.0, 0.2, 0.2, 0.2, *[0.02] * 6]},
    ),
    "robust": (
        "robust (passivity), layer 30", {"omega_n": 50.0, "layer": 30.0, "scale": [3.5, *[0.35] * 3, *[0.035] * 6]}
    ),
    "hand-guiding": (
        "hand guiding, 80% of the friction compensated", {"fading": 1.0, "share": 0.8, "width": 0.02}
    ),
    "hand-guiding:fading=2:share=0:width=0.1": (
        "hand guiding, friction not compensated", {"fading": 2.0, "share": 0.0, "width": 0.1}
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def rubbed():
    """An arm with friction, and its dynamics."""
    arm = arm_with_friction(lwr_dyn.load("lwr4plus"), 0.05)
    return arm, lwr_dyn.dynamics_of(arm)


@pytest.mark.parametrize("text", TUNED)
def test_laws_are_tuned_by_the_formulas_that_they_state(text, rubbed):
    label, numbers = TUNED[text]
    takes = text.startswith(("pd", "pid", "motor", "joint"))
    made = controller_spec(text).make(*rubbed, {"inertia": WORST} if takes else {})
    assert made.label == label
    for name, value in numbers.items():
        np.testing.assert_allclose(made.parameters[name], value, rtol=1e-14, err_msg=name)


@pytest.mark.parametrize(
    "text", [*(x for x in TUNED if "lighter" not in x and "adaptive" not in x), "pid+friction-measured", "pid+observer"]
)
def test_the_linear_form_of_a_law_at_rest_is_its_slope(text, rubbed):
    """Central differences of the torque over q and dq; a model's gravity changes with q too."""
    spec, (arm, dynamics) = controller_spec(text), rubbed
    made = spec.make(arm, dynamics)
    poses, still, h = np.random.default_rng(8).uniform(-1.0, 1.0, (2, 7)), np.zeros(7), 1e-6
    form = made.linear_feedback(poses)
    for k, q0 in enumerate(poses):

        def torque(x, v, q0=q0):
            reset(made)
            return made(0.0, q0 + x, v, q0, still, still)

        by_q = np.array([torque(d, still) - torque(-d, still) for d in h * np.eye(7)]).T / (2 * h)
        by_dq = np.array([torque(still, d) - torque(still, -d) for d in h * np.eye(7)]).T / (2 * h)
        carried = np.zeros((7, 7)) if form.gravity is None else gravity_stiffness(form.gravity, poses)[k]
        scale = max(1.0, np.abs(form.position[k]).max(), np.abs(form.velocity[k]).max())
        np.testing.assert_allclose(carried - by_q, form.position[k], atol=2e-6 * scale)
        np.testing.assert_allclose(-by_dq, form.velocity[k], atol=2e-6 * scale)


KINDS = Registry("colour", {"red": Row("nowhere:red", "red")})


@pytest.mark.parametrize(
    ("kind", "text", "wanted"),
    [
        (int, "3", 3), (float, "2.5", 2.5), (Quantity.ANGLE, "90", np.pi / 2), (str, "a", "a"), (KINDS, "red", "red"),
        (bool, "", False), (int, "2.5", "one: '2.5'; allowed: a whole number"),
        (float, "x", "one: 'x'; allowed: a number (Help)"), (KINDS, "rad", "no colour named 'rad'"),
        (str, "", "one: no value; allowed: name=VALUE (Help)"),
        (Quantity.ANGLES, "1,2", "one: '1,2'; allowed: a controller in a file, for values that are lists"),
        (bool, "1", "one: with the value '1'; allowed: name, without a value"),
    ],
)  # fmt: skip
def test_texts_become_values_of_the_kind_of_their_option_or_are_refused(kind, text, wanted):
    def value():
        found = _value("one", Option(kind, "Help.", default=kind is bool), "name", text)
        return found, type(found)

    if isinstance(wanted, str) and len(wanted) > 3:
        with pytest.raises(LwrDynError) as fault:
            value()
        assert wanted in str(fault.value)
    else:
        assert value() == (wanted, type(wanted))


def test_a_file_takes_options_of_its_own_may_have_dataclasses_and_is_not_run_where_that_is_forbidden(
    arm, tmp_path, monkeypatch
):
    file = tmp_path / "mine.py"
    file.write_text(
        "from __future__ import annotations\nfrom dataclasses import dataclass\n\n"
        "@dataclass\nclass Law:\n    gain: float\n    def __call__(self, *given): return given[1] + self.gain\n\n"
        "def make(arm, dynamics, gain=1.0, quiet=False, word=''):\n"
        "    return Law(gain * (quiet and word == 'a-b') * __file__.endswith('mine.py'))\n"
    )
    made = controller_spec(f"{file}:gain=3:quiet:word=a-b").make(arm, lwr_dyn.dynamics_of(arm))
    np.testing.assert_array_equal(made(0.0, np.zeros(7), *[np.zeros(7)] * 4), 3.0)  # it knows its own path
    assert [controller_spec(x).is_file for x in (str(file), "pid")] == [True, False]
    monkeypatch.setenv(NO_CODE, "1")
    with pytest.raises(LwrDynError, match=f"mine.py: Python that would run, against {NO_CODE}; allowed: controllers"):
        controller_spec(str(file)).make(arm, lwr_dyn.dynamics_of(arm))
    with pytest.raises(ZeroDivisionError), faults_in(str(file)):  # a fault of another file is not the controller's
        1 / 0  # noqa: B018


OPTIONS = "omega-n, xi, ki, velocity-error"
BAD = [
    ("pdi", "no controller named 'pdi' (did you mean pid?)"),
    ("pdi:omega-n=2", "no controller named 'pdi'"),
    (":omega-n=2", "no controller named ':omega-n=2'"),
    ("pid:omega=2", f"controller pid: option 'omega' (did you mean omega-n?); allowed: {OPTIONS}"),
    ("pid:omega-n", "controller pid: omega-n: no value; allowed: omega-n=VALUE (Natural frequency, rad/s)"),
    ("pid:omega-n=fast", "controller pid: omega-n: 'fast'; allowed: a number (Natural"),
    ("pid:velocity-error=yes", "velocity-error: with the value 'yes'; allowed: velocity-error, without a value"),
    ("pid:xi=1:xi=2", "xi twice; allowed: each option once"),
    ("pid+frition", "no controller wrapper named 'frition' (did you mean friction?)"),
    ("pid+friction:xi=1", "allowed: NAME:OPTION=VALUE:SWITCH+WRAPPER"),
]


@pytest.mark.parametrize(("text", "message"), BAD)
def test_bad_input_is_one_line_before_there_is_an_arm(text, message):
    with pytest.raises(LwrDynError) as fault:
        controller_spec(text)
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)


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
