"""The label of a controller: one label, one behaviour, over every variant that the registry can make."""

from dataclasses import replace
from inspect import signature
from itertools import product

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.checks.sensitivity.study_tasks import JOINT_MOVE, controller_of, study_tasks
from lwr_dyn.control.controllers import CONTROLLERS, make_controller
from lwr_dyn.control.protocol import describe, label_of
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


def test_a_label_names_controller_and_variant():
    labels = {label_of(controller) for controller in (*variants(), *study_controllers())}
    assert {
        "PD + gravity, damping on dq", "PD + gravity, damping on dq_ref - dq, gains of the arm's file",
        "PID, damping on dq", "inverse dynamics with feed-forward",
        "inverse dynamics without feed-forward (ddq_ref := 0), without g",
    } <= labels  # fmt: skip


def test_describe_holds_the_label_and_a_function_is_its_name():
    controller = make_controller("inverse-dynamics", ARM, feedforward=False)
    assert describe(controller)["label"] == "inverse dynamics without feed-forward (ddq_ref := 0)"
    assert label_of(len) == "len"


def test_a_lambda_is_called_what_it_is_alone_and_in_a_wrapper():
    law = lambda t, q, dq, q_ref, dq_ref, ddq_ref: -dq  # noqa: E731
    assert describe(law) == {"name": "own controller", "label": "own controller", "parameters": {}}
    run = lwr_dyn.simulate(ARM, law, lwr_dyn.reference("hold", ARM, q=np.zeros(ARM.n), duration=0.01))
    assert "lambda" not in str(run.meta)

    def brake(t, q, dq, q_ref, dq_ref, ddq_ref):
        return -dq

    assert label_of(brake) == "brake"
