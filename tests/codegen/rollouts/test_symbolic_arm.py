"""Smooth friction on symbols and as tables, beside that of `simulate`; how stiff it may be."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import friction_parameters, friction_table
from lwr_dyn.codegen.kernels.lean_recursion import Turn
from lwr_dyn.codegen.rollouts.symbolic_arm import LARGEST, check_friction, friction_column, friction_models, turned
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import Direction, JointFriction, smooth_friction
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED, chosen_friction
from lwr_dyn.simulation.plant import plant_of
from lwr_dyn.simulation.setup import Loop, friction_rate

WAM = lwr_dyn.load("wam7")
JOINTS = (
    *(JointFriction(Direction(2.0 + i, 0.5), Direction(1.0, 0.2 + i), 0.3 * i) for i in range(2)), None
)  # fmt: skip
SPEEDS = np.random.default_rng(0).normal(0.0, 1.0, (50, 3)) * np.logspace(-6, 1, 50)[:, None]


@pytest.mark.parametrize("width", [1e-3, 0.2])
def test_smooth_friction_of_a_table_is_that_of_the_models(width):
    table = friction_table(JOINTS)
    models = friction_models(table)
    assert models[:2] == JOINTS[:2]
    dq, flat, w = casadi.SX.sym("dq", 3), casadi.SX.sym("table", 15), casadi.SX.sym("width")
    function = casadi.Function("f", [dq, flat, w], [friction_column(dq, flat, w)])
    true, numeric = smooth_friction(JOINTS, width), smooth_friction(models, width)
    for v in (*SPEEDS, np.zeros(3)):
        np.testing.assert_allclose(np.array(function(v, table.ravel(), width)).ravel(), true(v), rtol=1e-14, atol=0)
        np.testing.assert_array_equal(numeric(v), true(v))


def test_a_table_has_both_directions_coulomb_before_viscous_then_the_offset():
    at_once = JointFriction(*(Direction(1.0, 0.1, 2.0),) * 2)  # static friction that drops at the first motion
    rows = friction_table((*JOINTS, at_once)).T
    np.testing.assert_array_equal(rows, [[2, 0.5, 1, 0.2, 0], [3, 0.5, 1, 1.2, 0.3], [0] * 5, [1, 0.1, 1, 0.1, 0]])
    np.testing.assert_array_equal(friction_table(WAM.friction_models()), friction_parameters(WAM))


FALLING = JointFriction(*(Direction(1.0, 0.1, 2.0, 0.05),) * 2)
LOADED = JointFriction(*(Direction(1.0, 0.1),) * 2, load=0.1)


@pytest.mark.parametrize(
    ("joints", "words"),
    [
        ((None, FALLING), "friction of joint 2: a Stribeck curve"),
        ((LOADED, None), r"friction of joint 1: 0\.1 of the load; allowed: in kernels Coulomb"),
    ],
)
def test_friction_that_is_no_table_is_refused(joints, words):
    with pytest.raises(OptionError, match=words):
        friction_table(joints)


RATE = 1000.0


def test_each_runs_friction_brakes_at_the_rate_of_simulate_and_one_too_fast_is_refused():
    plant, q = plant_of(WAM, "pinocchio", chosen_friction(WAM, "smooth")), np.linspace(-0.5, 0.5, 7)
    table, B = friction_parameters(WAM), plant.ungated.mass_matrix(q)
    rate, tables = friction_rate(plant, q, Loop(rate=1e6)), np.array([0.5 * table, table, 0.0 * table])
    np.testing.assert_allclose(check_friction(B, tables, SMOOTH_SPEED, 1e6, 1), [0.5 * rate, rate, 0.0], rtol=1e-9)
    heavier = check_friction(np.array([B, 2 * B]), table, SMOOTH_SPEED, 1e6, 1)
    np.testing.assert_allclose(heavier, [rate, rate / 2])
    fine = int(np.ceil(rate / RATE / 2.7))
    check_friction(B, tables, SMOOTH_SPEED, RATE, fine)
    too_fast = rf"brakes at up to {rate:.4g} 1/s \(run 1\), too fast.*allowed: substeps from {fine} on"
    negative = np.where(np.arange(5)[:, None] == 2, -1.0, table)
    for rows, width, substeps, words in (
        (tables, SMOOTH_SPEED, fine - 1, too_fast),
        (tables, 0.0, 1, r"friction_width: 0\.0; allowed: a speed above 0"),
        (negative, SMOOTH_SPEED, 1, "a Coulomb level of -1; allowed: 0 or more"),
    ):
        with pytest.raises(OptionError, match=words.replace("+", r"\+")):
            check_friction(B, rows, width, RATE, substeps)


def test_the_series_are_exact_up_to_the_largest_turn():
    angle, by = np.meshgrid(np.linspace(-7.0, 7.0, 29), np.linspace(-LARGEST, LARGEST, 41))
    found = turned(Turn(np.cos(angle), np.sin(angle)), by)
    assert np.abs([found.c - np.cos(angle + by), found.s - np.sin(angle + by)]).max() < 2e-15
