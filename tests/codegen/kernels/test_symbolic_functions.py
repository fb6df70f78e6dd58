"""Every function of a batch against Pinocchio and the hand-written recursion, on the papers' arms and on others.

Kernels are run by Python; `test_kernel_source` compares machine code with that.
"""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.checks.arm.model_laws import gravity_identity, mass_matrix_identities, random_states, velocity_identities
from lwr_dyn.checks.arm.run_checks import roads_agree
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS
from lwr_dyn.codegen.kernels.symbolic_functions import EXPRESSIONS
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from scripts.benchmarks.kernel_peers import pinocchio_answers, relative_difference
from tests.codegen.kernels.evaluate import evaluated, states
from tests.random_arms import random_arm
from tests.tolerances import EXACT

pytestmark = pytest.mark.usefixtures("by_python")

ROBOTS = [robot for robot in studied() if lwr_dyn.load(robot).chain.bodies is not None]
SINGLE = 2e-5
"""Relative, float32: its rounding of 6e-8 through some hundred operations and, forward, the condition of B."""


def test_every_function_has_an_expression():
    assert EXPRESSIONS.keys() == FUNCTIONS.keys()


@pytest.mark.slow
@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("robot", ROBOTS)
def test_a_function_is_pinocchios(robot, function):
    arm = lwr_dyn.load(robot)
    x = states(arm.n, 60)
    result = evaluated(lwr_dyn.batch_dynamics(arm), function, *x)
    arguments = [row for row, _ in zip(x, FUNCTIONS[function].states, strict=False)]
    expected = np.array([pinocchio_answers_of(arm)[function](*row) for row in zip(*arguments, strict=True)])
    if function == "potential_energy":
        result, expected = result - result[0], expected - expected[0]
    assert result.shape == expected.shape
    assert relative_difference(result, expected) < EXACT


_ANSWERS = {}


def pinocchio_answers_of(arm):
    if arm.name not in _ANSWERS:
        _ANSWERS[arm.name] = pinocchio_answers(arm)
    return _ANSWERS[arm.name]


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "joints"), [(3, "RPR"), (5, "R"), (6, "P")])
def test_random_arms_agree(seed, joints):
    arm = random_arm(seed, joints)
    x, answers, batch = states(arm.n, 19), pinocchio_answers(arm), lwr_dyn.batch_dynamics(arm)
    for function in (
        "forward_dynamics",
        "flange_pose",
        "jacobian",
        "torque_regressor",
        "inverse_dynamics_derivatives",
        "coriolis_matrix",
    ):
        arguments = x[: len(FUNCTIONS[function].states)]
        expected = np.array([answers[function](*row) for row in zip(*arguments, strict=True)])
        scale = max(1.0, np.abs(expected).max())
        result = evaluated(batch, function, *x)
        assert np.abs(result - expected.reshape(result.shape)).max() < EXACT * scale, function


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
def test_the_engine_passes_the_laws_and_agrees_with_road_b(robot):
    arm = lwr_dyn.load(robot)
    x, kernels, road_b = (
        random_states(arm, 200, seed=4),
        lwr_dyn.dynamics_of(arm, "kernels"),
        newton_euler_dynamics(arm.chain),
    )
    verdicts = [
        *mass_matrix_identities(kernels, x),
        *velocity_identities(kernels, road_b.ungated, x),
        gravity_identity(kernels, road_b.ungated, x),
        *roads_agree(kernels, road_b, x),
    ]
    assert [v for v in verdicts if not v.holds] == []


@pytest.mark.slow
@pytest.mark.parametrize("rotors", ["full", "none"])
def test_rotors_enter_as_in_the_recursion(rotors):
    arm, x = lwr_dyn.load("lwr4plus"), states(7, 30)
    kernels = lwr_dyn.dynamics_of(arm, "kernels", rotors=rotors)
    road_b = lwr_dyn.dynamics_of(arm, "newton-euler", rotors=rotors)
    assert relative_difference(kernels.inverse_dynamics(*x), road_b.inverse_dynamics(*x)) < EXACT


@pytest.mark.slow
def test_a_loop_may_call_the_engine_without_its_gate():
    arm, x = lwr_dyn.load("lwr4plus"), states(7, 3)
    kernels, road_b = lwr_dyn.dynamics_of(arm, "kernels"), lwr_dyn.dynamics_of(arm, "newton-euler")
    for q, dq, ddq in zip(*x, strict=True):
        single = kernels.ungated
        assert np.abs(single.inverse_dynamics(q, dq, ddq) - road_b.inverse_dynamics(q, dq, ddq)).max() < 1e-12
        assert (
            np.abs(single.inverse_dynamics(q + 2e7 * np.pi, dq, ddq) - road_b.inverse_dynamics(q, dq, ddq)).max() < 1e-5
        )
        energy = dq @ road_b.mass_matrix(q) @ dq / 2 + road_b.potential_energy(q)
        assert abs(single.mechanical_energy(q, dq) - energy) < 1e-12
    assert np.isnan(kernels.ungated.gravity_vector(np.full(7, np.nan))).any()


@pytest.mark.slow
@pytest.mark.parametrize("function", ["inverse_dynamics", "mass_matrix", "forward_dynamics", "flange_pose"])
def test_float32_is_right_to_its_digits(function):
    arm, x = lwr_dyn.load("lwr4plus"), states(7, 1000)
    exact = evaluated(lwr_dyn.batch_dynamics(arm), function, *x)
    result = evaluated(lwr_dyn.batch_dynamics(arm, dtype="float32"), function, *x.astype(np.float32))
    assert result.dtype == np.float32
    assert relative_difference(result, exact) < SINGLE
