"""The label of a controller: one label, one behaviour, over every variant that the registry can make."""

from dataclasses import replace
from inspect import signature
from itertools import product

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.checks.sensitivity.study_tasks import JOINT_MOVE, controller_of, study_tasks
from lwr_dyn.control.controllers import CONTROLLERS, make_controller
from lwr_dyn.control.protocol import (
    WithMemory,
    Wrapped,
    describe,
    filter_pole,
    label_of,
    layers_of,
    positive_gains,
    reset,
    saturate,
    saturating,
)
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.foundation.registry import options_of
from lwr_dyn.model.transmission import JointElasticity

STIFF = JointElasticity(np.full(7, 1e4), np.full(7, 10.0))
ARM = replace(lwr_dyn.load("wam7"), elasticity=STIFF)  # its file gives gains: every option can be tried
B = np.linspace(2.0, 0.1, ARM.n)
"""[kg m^2] Any inertias: the same gains for every controller that draws its own."""
STATES = np.random.default_rng(3).uniform(-1.0, 1.0, (3, 5, ARM.n))


def behaviour(controller):
    """Its torques at some states, from a fresh start, to nine digits."""
    getattr(controller, "reset", lambda: None)()
    torques = [controller(0.1 * i, *state) for i, state in enumerate(STATES)]
    return tuple(np.round(np.ravel(torques), 9))


def variants():
    """Every row of the registry under every choice of its switches."""
    for name in CONTROLLERS.rows:
        switches = [key for key, option in options_of(CONTROLLERS.load(name)).items() if option.kind is bool]
        for values in product([False, True], repeat=len(switches)):
            known = {"inertia": B} if "inertia" in signature(CONTROLLERS.load(name)).parameters else {}
            yield make_controller(name, ARM, **known, **dict(zip(switches, values, strict=True)))


def study_controllers():
    """Every controller of the package's studies, on one arm."""
    for task in (*study_tasks().values(), JOINT_MOVE):
        for choice in task.controllers:
            yield controller_of(ARM, choice, B)


@pytest.mark.parametrize("source", [variants, study_controllers])
def test_one_label_one_behaviour(source):
    pairs = {(label_of(controller), behaviour(controller)) for controller in source()}
    labels, behaviours = zip(*pairs, strict=True)
    assert len(pairs) == len(set(labels)) == len(set(behaviours))


def test_a_function_is_called_by_its_name_and_a_lambda_what_it_is():
    def brake(t, q, dq, q_ref, dq_ref, ddq_ref):
        return -dq

    law = lambda *state: brake(*state)  # noqa: E731
    names = [describe(brake), describe(law)]
    assert names == [{"name": x, "label": x, "parameters": {}} for x in ("brake", "own controller")]
    run = lwr_dyn.simulate(ARM, law, lwr_dyn.reference("hold", ARM, q=np.zeros(ARM.n), duration=0.01))
    assert "lambda" not in str(run.meta)
    reset(brake)


def test_torques_are_cut_at_the_limits_wherever_they_are_written():
    tau, effort = np.array([3.0, -9.0, 7.0, -2.0]), np.array([5.0, 4.0, 6.0, np.inf])
    wanted = [3.0, -4.0, 6.0, -2.0]
    out, other = np.empty(4), np.empty(4)
    assert saturate(tau, effort).tolist() == saturate(tau, effort, out).tolist() == out.tolist() == wanted
    saturating(effort)(tau, other)
    assert other.tolist() == wanted
    assert tau.tolist() == [3.0, -9.0, 7.0, -2.0]


def test_the_pole_of_a_velocity_filter_and_gains_that_are_one_number_or_one_a_joint():
    assert filter_pole(100.0, 1000.0) == pytest.approx(np.exp(-0.2 * np.pi), rel=1e-15)
    assert filter_pole(499.999, 1000.0) < filter_pole(1e-3, 1000.0) < 1.0
    assert filter_pole(0.1, 0.5) == pytest.approx(np.exp(-0.4 * np.pi), rel=1e-15)
    gains = positive_gains("Kp", [1.0, 2.0], 2)
    assert (positive_gains("Kp", 2.0, 3).tolist(), gains.tolist(), gains.flags.writeable) == ([2.0] * 3, [1, 2], False)


CUT_OFF = "cut-off of the velocity filter: {}; allowed: above 0 and below 500 Hz"


@pytest.mark.parametrize(
    ("made", "arguments", "words"),
    [
        *((filter_pole, (cutoff, 1000.0), CUT_OFF.format(cutoff)) for cutoff in (500.0, 0.0, -1.0, np.nan)),
        *((filter_pole, (1.0, rate), f"rate: {rate}; allowed: a number above 0, in Hz") for rate in (0.0, np.inf)),
        (positive_gains, ("Kp", [1.0, 0.0], 2), "Kp: [1.0, 0.0]; allowed: numbers above 0"),
        *((positive_gains, ("Kp", x, 2), f"Kp: shape {np.shape(x)}; allowed: one number, or shape (2,)")
          for x in ([1.0], [[1.0, 2.0]], [1.0, 2.0, 3.0])),
    ],
)  # fmt: skip
def test_poles_and_gains_that_cannot_be(made, arguments, words):
    with pytest.raises((OptionError, ShapeError)) as fault:
        made(*arguments)
    assert str(fault.value) == words


def test_a_wrapper_adds_to_the_torque_and_passes_memory_and_layers_on():
    class Added(Wrapped):
        word, label_word = "more", "with more"

        def added(self, q, dq, q_ref, dq_ref, ddq_ref):
            return 2.0 * q - dq_ref

    law = make_controller("pid", ARM, inertia=B)
    outer, memory = Added(Added(law)), np.linspace(1.0, 2.0, 7)
    (q, dq, q_ref, dq_ref, ddq_ref), n = STATES[0], ARM.n
    more = 2.0 * q - dq_ref
    torque, rate = outer.torque_and_rate(memory, q, dq, q_ref, dq_ref, ddq_ref)
    inner = law.torque_and_rate(memory, q, dq, q_ref, dq_ref, ddq_ref)
    np.testing.assert_allclose(torque, inner[0] + 2.0 * more)
    np.testing.assert_array_equal(rate, inner[1])
    np.testing.assert_allclose(outer(0.0, *STATES[0]), law(0.0, *STATES[0]) + 2.0 * more)
    assert (outer.memory_size, outer.name, outer.label) == (n, "pid+more+more", f"{law.label}, with more, with more")
    assert outer.parameters == law.parameters
    assert list(layers_of(outer)) == [outer, outer.inner, law]
    assert isinstance(outer, WithMemory)
    assert not isinstance(Added(lambda *_: 0.0), WithMemory)
    assert outer.Kp is law.Kp
    with pytest.raises(AttributeError):
        _ = outer.nothing
