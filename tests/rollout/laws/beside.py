"""A kernel form beside its controller: torque after torque, with the gains of the controller and with others."""

from collections.abc import Mapping
from functools import cache

import numpy as np

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.rollout.laws.check import differences, form_function, states_of
from lwr_dyn.simulation.plant import arm_with_payload

ARM = lwr_dyn.load("lwr4plus")
MODEL = lwr_dyn.dynamics_of(ARM)
OTHER = arm_with_payload(ARM, 2.0, (0.03, -0.02, 0.1))
"""The arm as another run's law knows it."""
STATES = states_of(ARM)
SAME = 1e-13
"""Of the largest torque at a sample: a hundred roundings."""


INERTIA = (2.9, 2.9, 0.5, 0.5, 0.01, 0.005, 0.002)
"""[kg m^2] For the gains of laws that would search it over the joint box."""
SEARCHING = ("pd-gravity", "pid", "motor-pd", "joint-impedance")


@cache
def made(name, arm=None, **options):
    """A controller of `ARM`, or of another arm."""
    given = {"inertia": INERTIA} if name.partition("+")[0] in SEARCHING else {}
    return make_controller(name, ARM if arm is None else arm, "pinocchio", **given, **options)


def other_values(form, **given):
    """The values of a form, each number changed by up to 20 %, and `given` in place of some."""
    rng = np.random.default_rng(3)
    drawn = {name: value * rng.uniform(0.8, 1.2, np.shape(value)) for name, value in form.values().items()}
    return {name: np.broadcast_to(given.get(name, value), np.shape(value)) for name, value in drawn.items()}


def check_beside(form, law, *cases: Mapping[str, object], arm=ARM, knows_arm=True):
    """The form gives the controller's torques; of other values and another arm, those of the controller that it makes.

    `cases`: values that are given in place of those drawn.
    """
    values = form.values()
    assert {name: np.shape(value) for name, value in values.items()} == dict(form.parameters)
    assert form.start().shape == (form.memory,)
    assert form.name == law.name
    states = STATES if arm is ARM else states_of(arm)
    step = form_function(form, arm)
    assert differences(step, values, form.start(), law, states)[1] < SAME
    again = form.controller(arm, values)
    assert again.label == law.label
    assert differences(step, values, form.start(), again, states)[1] < SAME
    other = OTHER if arm is ARM else arm_with_payload(arm, 1.0)
    step = form_function(form, other)
    for case in ({}, *cases):
        values = other_values(form, **case)
        made = form.controller(other, values)
        assert differences(step, values, form.start(), made, states)[1] < SAME
    assert (differences(step, form.values(), form.start(), law, states)[1] > 1e-3) == knows_arm
