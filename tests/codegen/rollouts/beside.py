"""A kernel form beside its controller: torque after torque, with the gains of the controller and with others."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np

import lwr_dyn
from lwr_dyn.codegen.rollouts.law_forms import differences, form_function, states_of
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.laws.motor_side import MotorSidePD
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.chain import first_links
from lwr_dyn.model.friction import Direction, JointFriction

WHOLE = lwr_dyn.load("lwr4plus", "computed")


def first_joints(joints):
    """The first joints of the LWR 4+ as an arm, with friction that differs by direction and joint."""
    levels = np.array([2.0, 2.0, 1.0, 1.0, 0.02, 0.01, 0.004])[:joints]
    friction = tuple(JointFriction(Direction(x, x / 2), Direction(1.5 * x, x / 5), x / 10) for x in levels.tolist())
    return replace(
        WHOLE, chain=first_links(WHOLE.chain, joints), limits=WHOLE.limits[:joints], friction=friction,
        transmission=None, elasticity=None, gains=None, mastering=(),
    )  # fmt: skip


ARM = first_joints(4)
"""Small, for speed."""
MODEL = lwr_dyn.dynamics_of(ARM)
OTHER = arm_with_payload(ARM, 2.0, (0.03, -0.02, 0.1))
"""The arm as another run's law knows it."""
STATES = states_of(ARM)
SAME = 1e-13
"""Of the largest torque at a sample: a hundred roundings."""


INERTIA = (2.9, 2.9, 0.5, 0.5, 0.01, 0.005, 0.002)
"""[kg m^2] For the gains of laws that would search it over the joint box."""


@cache
def made(name, arm=ARM, **options):
    """A controller of an arm; motor-side PD directly, as the gears of `ARM` have no stiffness."""
    if name == "motor-pd":
        inertia = np.array(INERTIA[: arm.n])
        return MotorSidePD(lwr_dyn.dynamics_of(arm), 400.0 * inertia, 40.0 * inertia, 1e4, arm.armature, **options)
    searches = name.partition("+")[0] in ("pd-gravity", "pid", "joint-impedance")
    given = {"inertia": INERTIA[: arm.n]} if searches else {}
    return make_controller(name, arm, **given, **options)


def other_values(form, **given):
    """The values of a form, each number changed by up to 20 %, and `given` in place of some."""
    rng = np.random.default_rng(3)
    drawn = {name: value * rng.uniform(0.8, 1.2, np.shape(value)) for name, value in form.values().items()}
    return {name: np.broadcast_to(given.get(name, value), np.shape(value)) for name, value in drawn.items()}


def words(label):
    """A label without the numbers in it."""
    return label.rstrip("0123456789.")


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
    other = OTHER if arm is ARM else arm_with_payload(arm, 1.0)
    step = form_function(form, other)
    for case in ({}, *cases):
        values = other_values(form, **case)
        again = form.controller(other, values)
        assert words(again.label) == words(law.label)
        assert differences(step, values, form.start(), again, states)[1] < SAME
    assert (differences(step, form.values(), form.start(), law, states)[1] > 1e-3) == knows_arm
