"""Every function of a batch against Pinocchio and the hand-written recursion, on the papers' arms and on others.

Kernels are run by Python; `test_kernel_source` compares machine code with that.
"""

from functools import cache

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


@cache
def answers_of(name):
    return pinocchio_answers(arm_of(name))


@cache
def arm_of(name):
    return random_arm(*RANDOM[name]) if name in RANDOM else lwr_dyn.load(name)


RANDOM = {"RPR": (3, "RPR"), "R": (5, "R"), "P": (6, "P")}


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("name", ["RPR", *(pytest.param(x, marks=pytest.mark.slow) for x in (*ROBOTS, "R", "P"))])
def test_a_function_is_pinocchios(name, function):
    arm = arm_of(name)
    x = states(arm.n, 60)
    result = evaluated(lwr_dyn.batch_dynamics(arm), function, *x)
    arguments = x[: len(FUNCTIONS[function].states)]
    expected = np.array([answers_of(name)[function](*row) for row in zip(*arguments, strict=True)])
    if function == "potential_energy":
        result, expected = result - result[0], expected - expected[0]
    assert result.shape == (60, *FUNCTIONS[function].result(arm.n))
    expected = expected.reshape(result.shape)
    assert np.abs(result - expected).max() < EXACT * max(np.abs(expected).max(), 1.0 if name in RANDOM else 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
def test_the_engine_passes_the_laws_and_agrees_with_road_b(robot):
    arm = lwr_dyn.load(robot)
    kernels, road_b = lwr_dyn.dynamics_of(arm, "kernels"), newton_euler_dynamics(arm.chain)
    x = random_states(arm, 200, seed=4)
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
@pytest.mark.parametrize("function", ["inverse_dynamics", "mass_matrix", "forward_dynamics", "flange_pose"])
def test_float32_is_right_to_its_digits(function):
    arm, x = lwr_dyn.load("lwr4plus"), states(7, 1000)
    exact = evaluated(lwr_dyn.batch_dynamics(arm), function, *x)
    result = evaluated(lwr_dyn.batch_dynamics(arm, dtype="float32"), function, *x.astype(np.float32))
    assert result.dtype == np.float32
    assert relative_difference(result, exact) < SINGLE
