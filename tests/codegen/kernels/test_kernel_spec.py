"""Kernels with inertial parameters, payload, gravity and friction as inputs equal kernels with constants.

Kernels are run by Python; `test_kernel_source` compares machine code with that, with all inputs and without.
"""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import kernel_spec
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.model.chain import Body, with_bodies, with_payload
from lwr_dyn.model.friction import Direction, JointFriction, friction_torque
from scripts.benchmarks.kernel_peers import relative_difference
from tests.codegen.kernels.evaluate import evaluated, states
from tests.random_arms import random_arm, random_body
from tests.tolerances import EXACT

pytestmark = pytest.mark.usefixtures("by_python")

ARM = lwr_dyn.load("lwr4plus")
LIMITS = tuple(replace(limits, viscous=1.0 + i, coulomb=0.5 * i) for i, limits in enumerate(ARM.limits))
RUBBING = replace(ARM, limits=LIMITS)
OFFSET = replace(ARM, friction=(JointFriction(Direction(0.0, 0.0), Direction(0.0, 0.0), 0.3),) * 7)
CURVED = replace(ARM, friction=(JointFriction(Direction(1.0, 0.1, 1.5, 0.05), Direction(1.0, 0.1)),) * 7)
WITH_INPUTS = [name for name, shape in kernel_spec.FUNCTIONS.items() if shape.parameters]


@pytest.fixture(scope="module")
def family():
    return lwr_dyn.batch_dynamics(ARM, inputs=kernel_spec.INPUTS)


def own_values(arm):
    return {
        "inertia": kernel_spec.inertial_parameters(arm.chain),
        "payload": np.zeros(10),
        "gravity": np.array(arm.chain.gravity),
        "friction": kernel_spec.friction_parameters(arm),
    }


def given(function, values):
    return {name: values[name] for name in kernel_spec.FUNCTIONS[function].parameters}


@pytest.mark.slow
@pytest.mark.parametrize("function", WITH_INPUTS)
def test_the_arms_own_values_as_inputs_give_the_constants_result(family, function):
    x = states(7, 40)
    constant = lwr_dyn.batch_dynamics(RUBBING, friction="arm")
    result = evaluated(family, function, *x, **given(function, own_values(RUBBING)))
    assert relative_difference(result, evaluated(constant, function, *x)) < EXACT


@pytest.mark.slow
@pytest.mark.parametrize(
    "function", ["inverse_dynamics", "forward_dynamics", "mass_matrix", "coriolis_matrix", "potential_energy"]
)
def test_every_state_may_have_a_body_a_load_and_a_gravity_of_its_own(family, function):
    count, rng = 21, np.random.default_rng(5)
    x, gravity = states(7, count), rng.uniform(-10, 10, (count, 3))
    loads = [(rng.uniform(0, 5), rng.uniform(-0.2, 0.2, 3), np.diag(rng.uniform(0.01, 0.02, 3))) for _ in range(count)]
    bodies = [[random_body(rng) for _ in range(7)] for _ in range(count)]
    chains = [replace(with_bodies(ARM.chain, b), gravity=g) for b, g in zip(bodies, gravity, strict=True)]
    values = {
        "inertia": np.array([kernel_spec.inertial_parameters(c) for c in chains]),
        "payload": np.array([kernel_spec.payload_parameters(*load) for load in loads]),
        "gravity": gravity,
        "friction": np.zeros((5, 7)),
    }
    result, expected = evaluated(family, function, *x, **given(function, values)), []
    for chain, load, state in zip(chains, loads, np.swapaxes(x, 0, 1), strict=True):
        engine = lwr_dyn.dynamics_of(ARM.with_chain(with_payload(chain, *load)), "newton-euler")
        expected.append(getattr(engine, function)(*state[: len(kernel_spec.FUNCTIONS[function].states)]))
    assert relative_difference(result, np.array(expected)) < EXACT


@pytest.mark.slow
@pytest.mark.parametrize("arm", [ARM, random_arm(5, "RPR")], ids=["flange in its frame", "flange elsewhere"])
def test_a_payload_alone_can_be_the_input(arm):
    x, load = states(arm.n, 10), kernel_spec.payload_parameters(3.0, (0.01, 0.0, 0.05))
    result = lwr_dyn.batch_dynamics(arm, inputs=["payload"]).inverse_dynamics(*x, payload=load)
    loaded = arm.with_chain(with_payload(arm.chain, 3.0, (0.01, 0.0, 0.05)))
    expected = lwr_dyn.dynamics_of(loaded, "newton-euler").inverse_dynamics(*x)
    assert relative_difference(result, expected) < EXACT


@pytest.mark.slow
def test_parameters_without_mass_but_with_a_first_moment_work(family):
    """Base parameters from an identification look like that: no body can, the torque is linear all the same."""
    x, values = states(7, 10), own_values(ARM)
    values["inertia"] = np.random.default_rng(1).normal(size=(7, 10))
    values["inertia"][:, 0] = 0.0
    Y = lwr_dyn.batch_dynamics(ARM).torque_regressor(*x)
    expected = Y @ values["inertia"].ravel() + ARM.armature * x[2]
    result = family.inverse_dynamics(*x, **values)
    assert relative_difference(result, expected) < EXACT


@pytest.mark.slow
@pytest.mark.parametrize("arm", [RUBBING, lwr_dyn.load("wam7"), OFFSET], ids=["both ways", "per direction", "offset"])
@pytest.mark.parametrize("is_given", [False, True])
def test_friction_is_that_of_the_arms_models(arm, is_given):
    """An offset is there at any speed."""
    q, dq, ddq = states(7, 30)
    dq[0] = 0.0
    rigid = lwr_dyn.batch_dynamics(arm).inverse_dynamics(q, dq, ddq)
    if is_given:
        table = kernel_spec.friction_parameters(arm)
        rubbing = lwr_dyn.batch_dynamics(arm, inputs=["friction"]).inverse_dynamics(q, dq, ddq, friction=table)
    else:
        rubbing = lwr_dyn.batch_dynamics(arm, friction="arm").inverse_dynamics(q, dq, ddq)
    assert np.abs(rubbing - rigid - friction_torque(arm.friction_models(), dq)).max() < 1e-12


def test_inertial_parameters_of_links_without_bodies_are_zero():
    bare = with_bodies(ARM.chain, [Body.massless()] * 7)
    assert not kernel_spec.inertial_parameters(bare).any()


@pytest.mark.parametrize(
    ("arm", "options", "error", "message"),
    [
        (ARM, {"inputs": ["colour"]}, OptionError, "inputs: 'colour'; allowed: inertia, payload, gravity, friction"),
        (ARM, {"dtype": "float16"}, OptionError, "dtype: 'float16'; allowed: float64, float32"),
        (ARM, {"friction": "some"}, OptionError, "friction: 'some'; allowed: none, arm"),
        (ARM, {"friction": "arm", "inputs": ["friction"]}, OptionError, "one of them"),
        (ARM, {"rotors": "half"}, OptionError, "rotors: 'half'"),
        *((ARM, {"threads": x}, OptionError, f"threads: {x}; allowed: a whole number above 0") for x in (0, True, 1.5)),
        (ARM, {"friction": "arm"}, MissingDataError, "lwr4plus: friction not given"),
        (
            CURVED,
            {"friction": "arm"},
            OptionError,
            "friction of joint_1: a Stribeck curve; allowed: in kernels Cou",
        ),
    ],
)
def test_choices_that_do_not_exist_are_refused(arm, options, error, message):
    with pytest.raises(error, match=message):
        lwr_dyn.batch_dynamics(arm, **options)


def test_inputs_must_be_given_in_their_shape_and_no_others(family):
    values, x = own_values(ARM), states(7, 3)
    with pytest.raises(OptionError, match="gravity: missing"):
        family.gravity_vector(x[0], inertia=values["inertia"], payload=values["payload"])
    with pytest.raises(OptionError, match="payload: given to gravity_vector; allowed: inputs of this family: none"):
        lwr_dyn.batch_dynamics(ARM).gravity_vector(x[0], payload=values["payload"])
    with pytest.raises(ShapeError, match=r"inertia: shape \(7, 9\); allowed: \(N, 7, 10\) or \(7, 10\)"):
        family.inverse_dynamics(*x, **values | {"inertia": np.zeros((7, 9))})
    assert kernel_spec.parameter_shape("payload", 7) == (10,)
