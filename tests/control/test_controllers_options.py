"""What no law takes, of all laws and wrappers: one line each."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS, make_controller
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.model.friction import symmetric

NAN, INF = float("nan"), float("inf")
SOFT, LIGHT = {"stiffness": 100.0}, {"inertia": np.ones(7)}
RUBBED = {"friction": [symmetric(1.0, 0.5)] * 7}
ABOVE, NUMBERS, SEVEN = "allowed: a number above 0", "allowed: numbers above 0", "allowed: one number, or shape (7,)"
ONE = "stiffness: shape ({}); allowed: one number, or shape ({},)"
ONCE, OBSERVER, NONE = "allowed: friction compensated once", "inverse-dynamics+observer", "no option of controller"
INVERSE = "inverse-dynamics; allowed: omega_n, xi, feedforward, gravity"
BAD = [
    ("adaptive", {"adapt": "all"}, OptionError, "adapt: 'all'; allowed: payload, base"),
    ("adaptive", {"adapt_gain": 0.0}, OptionError, f"adapt_gain: 0.0; {ABOVE}"),
    ("adaptive", {"omega_n": -1.0}, OptionError, f"omega_n: -1.0; {ABOVE}"),
    ("adaptive", {"adapt_friction": True, "friction_gain": NAN}, OptionError, f"friction_gain: nan; {ABOVE}"),
    ("robust", {"largest_load": -1.0}, OptionError, "largest_load: -1.0; allowed: a mass above 0, in kg"),
    ("robust", {"layer": 0.0}, OptionError, f"layer: 0.0; {ABOVE}"),
    ("robust", {"omega_n": INF}, OptionError, f"omega_n: inf; {ABOVE}"),
    ("cartesian-impedance", {"stiffness": [1.0, 1.0, 0.0]}, OptionError, f"stiffness: [1.0, 1.0, 0.0]; {NUMBERS}"),
    ("cartesian-impedance", {"rotation": 0.0}, OptionError, f"rotation: 0.0; {NUMBERS}"),
    ("cartesian-impedance", {"xi": -1.0}, OptionError, f"xi: -1.0; {NUMBERS}"),
    ("cartesian-impedance", {"posture": -1.0}, OptionError, "posture: -1.0; allowed: a number, at least 0"),
    ("cartesian-impedance", {"posture": NAN}, OptionError, "posture: nan; allowed: a number, at least 0"),
    ("cartesian-impedance", {"posture_damping": 1.0}, OptionError,
     f"posture_damping: {NONE} cartesian-impedance; allowed: stiffness, rotation, xi, posture, feedforward"),
    ("cartesian-impedance", {"stiffness": [1.0, 2.0]}, ShapeError, ONE.format("2,", 3)),
    ("cartesian-impedance", {"stiffness": np.eye(3)}, ShapeError, ONE.format("3, 3", 3)),
    ("cartesian-impedance", {"stiffness": NAN}, ShapeError, "stiffness: nan; allowed: finite numbers"),
    ("joint-impedance", {"stiffness": [1.0] * 6 + [0.0]}, OptionError,
     f"stiffness: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0]; {NUMBERS}"),
    ("joint-impedance", {"stiffness": [100.0] * 6}, ShapeError, ONE.format("6,", 7)),
    ("joint-impedance", {"stiffness": np.eye(7)}, ShapeError, ONE.format("7, 7", 7)),
    ("joint-impedance", {"stiffness": "soft"}, ShapeError, "stiffness: not an array of numbers; allowed: real numbers"),
    ("joint-impedance", SOFT | {"xi": 0.0}, OptionError, f"xi: 0.0; {NUMBERS}"),
    ("joint-impedance", SOFT | {"omega_n": 20.0}, OptionError, "omega_n: would do nothing here; allowed: without stif"),
    ("motor-pd", LIGHT | {"lighter": 0.999}, OptionError, "lighter: 0.999; allowed: a number from 1 on"),
    ("motor-pd", LIGHT | {"lighter": NAN}, OptionError, "lighter: nan; allowed: a number from 1 on"),
    ("motor-pd", LIGHT | {"gear_stiffness": 0.0}, OptionError, f"gear_stiffness: 0; {ABOVE} in N m/rad"),
    ("motor-pd", LIGHT | {"omega_n": 0.0}, OptionError, f"omega_n: 0.0; {ABOVE}"),
    ("motor-pd", {"inertia": [1.0, 2.0]}, ShapeError, f"Kp: shape (2,); {SEVEN}"),
    ("inverse-dynamics+motor-side", {"gear_stiffness": 0.0}, OptionError, f"gear_stiffness: 0; {ABOVE} in N m/rad"),
    ("hand-guiding", {"fading": 0.0}, OptionError, f"fading: 0.0; {NUMBERS}"),
    ("hand-guiding", {"width": -1.0}, OptionError, f"width: -1.0; {NUMBERS}"),
    ("hand-guiding", {"share": 1.5}, OptionError, "share: 1.5; allowed: a number from 0 to 1"),
    ("hand-guiding", {"share": NAN}, OptionError, "share: nan; allowed: a number from 0 to 1"),
    ("hand-guiding", {"share": 0.5}, MissingDataError,
     "lwr4plus: friction not given; needed for hand-guiding with a share of it"),
    (OBSERVER, {"observer_gain": 0.0}, OptionError, f"observer gain: 0.0; {NUMBERS}"),
    (OBSERVER, {"observer_gain": [50.0, 50.0]}, ShapeError, f"observer gain: shape (2,); {SEVEN}"),
    (OBSERVER, {"observer_gain": NAN}, ShapeError, "observer gain: nan; allowed: finite numbers"),
    (OBSERVER, {"observer_threshold": [1.0] * 6}, ShapeError, f"observer threshold: shape (6,); {SEVEN}"),
    (OBSERVER, {"observer_threshold": -1.0}, OptionError, f"observer threshold: -1.0; {NUMBERS}"),
    (OBSERVER, {"observer_payload": -0.3}, OptionError, "payload mass: -0.3; allowed: a number >= 0, in kg"),
    (OBSERVER, {"observer_noise": -1e-5}, OptionError, "observer noise: -1e-05; allowed: a number >= 0, in rad or m"),
    (OBSERVER, {"observer_noise": NAN}, OptionError, "observer noise: nan; allowed: a number >= 0, in rad or m"),
    (OBSERVER, {"observer_speed": 3.0}, OptionError, f"observer_speed: {NONE} {INVERSE}"),
    ("inverse-dynamics", {"friction_width": 1.0}, OptionError, f"friction_width: {NONE} {INVERSE}"),
    ("inverse-dynamics+friction", {}, MissingDataError,
     "lwr4plus: friction of its joints not given; needed for its compensation (identify it, or give it)"),
    ("inverse-dynamics+friction", {"friction": RUBBED["friction"][:3]}, ShapeError,
     "friction: 3 joints; allowed: 7, one a joint, None where there is none"),
    ("inverse-dynamics+friction", RUBBED | {"friction_width": 0.0}, OptionError, "width: 0.0; allowed: a speed above"),
    ("inverse-dynamics+friction+friction", RUBBED, OptionError,
     f"controller: inverse-dynamics+friction with friction again; {ONCE}"),
    ("inverse-dynamics+friction-measured+observer+friction", RUBBED, OptionError,
     f"controller: inverse-dynamics+friction-measured+observer with friction again; {ONCE}"),
    ("adaptive+observer+friction", {"adapt_friction": True}, OptionError,
     f"controller: adaptive+observer with adapted friction, and friction again; {ONCE}"),
    ("pid+observer+observer", LIGHT, OptionError, "controller: pid+observer with observer again; allowed: one obs"),
    ("pid+observer+friction+observer", LIGHT | RUBBED, OptionError,
     "controller: pid+observer+friction with observer again; allowed: one observer"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "options", "error", "words"), BAD, ids=[f"{x[0]}, {x[3]}" for x in BAD])
def test_options_that_cannot_be(arm, name, options, error, words):
    with pytest.raises(error) as fault:
        make_controller(name, arm, **options)
    assert str(fault.value).startswith(words)
    assert "\n" not in str(fault.value)


LOCKED = {"lock": {"joint_3": 0.0, "joint_5": 0.0}}


@pytest.mark.parametrize(
    ("name", "robot", "options", "what"),
    [*((name, "lwr4", {}, "masses and inertias not given; needed for dynamics") for name in CONTROLLERS.names),
     ("motor-pd", "wam7", {}, "joint stiffness not given; needed for elastic joints"),
     ("inverse-dynamics+motor-side", "wam7", {}, "joint stiffness not given; needed for elastic joints"),
     ("cartesian-impedance", "lwr4plus", LOCKED, "six joints or more (it has 5) not given; needed for cartesian")],
)  # fmt: skip
def test_what_a_law_needs_and_the_arm_does_not_give(name, robot, options, what):
    with pytest.raises(MissingDataError) as fault:
        make_controller(name, lwr_dyn.load(robot, **options))
    assert str(fault.value).startswith(f"{robot}: {what}")
