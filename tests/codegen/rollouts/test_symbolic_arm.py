"""Smooth friction on symbols and as tables, beside that of `simulate`; how stiff it may be."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import kernel_spec
from lwr_dyn.codegen.kernels.kernel_spec import friction_parameters, friction_table
from lwr_dyn.codegen.kernels.lean_recursion import Turn
from lwr_dyn.codegen.rollouts import symbolic_arm as ours
from lwr_dyn.codegen.rollouts.symbolic_arm import LARGEST, turned
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import Direction, JointFriction, smooth_friction
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED, chosen_friction
from lwr_dyn.simulation.plant import plant_of
from lwr_dyn.simulation.setup import Loop, friction_rate
from tests.slips import uncaught

WAM = lwr_dyn.load("wam7")
JOINTS = tuple(JointFriction(Direction(2.0 + i, 0.5), Direction(1.0, 0.2 + i), 0.3 * i) for i in range(3))
SPEEDS = np.random.default_rng(0).normal(0.0, 1.0, (50, 3)) * np.logspace(-6, 1, 50)[:, None]


def check_friction(module):
    table = friction_table((*JOINTS[:2], None))
    models = module.friction_models(table)
    assert models[:2] == JOINTS[:2]
    dq, flat, width = casadi.SX.sym("dq", 3), casadi.SX.sym("table", 15), casadi.SX.sym("width")
    function = casadi.Function("f", [dq, flat, width], [module.friction_column(dq, flat, width)])
    for w in (1e-3, 0.2):
        true = smooth_friction((*JOINTS[:2], None), w)
        numeric = smooth_friction(models, w)
        for v in (*SPEEDS, np.zeros(3)):
            np.testing.assert_allclose(np.array(function(v, table.ravel(), w)).ravel(), true(v), rtol=1e-14, atol=0)
            np.testing.assert_array_equal(numeric(v), true(v))
    check_stiffness(module)


def check_stiffness(module):
    """The rate is that of `simulate`, of each run; the first step that is too long is refused."""
    plant = plant_of(WAM, "pinocchio", chosen_friction(WAM, "smooth"))
    q = np.linspace(-0.5, 0.5, 7)
    table, B = friction_parameters(WAM), plant.ungated.mass_matrix(q)
    options = Loop(rate=1e6)
    rate = friction_rate(plant, q, options)
    tables = np.array([0.5 * table, table, 0.0 * table])
    rates = module.check_friction(B, tables, SMOOTH_SPEED, 1e6, 1)
    np.testing.assert_allclose(rates, [0.5 * rate, rate, 0.0], rtol=1e-9)
    np.testing.assert_allclose(
        module.check_friction(np.array([B, 2 * B]), table, SMOOTH_SPEED, 1e6, 1), [rate, rate / 2]
    )
    fine = int(np.ceil(rate / 1000.0 / 2.7))
    module.check_friction(B, tables, SMOOTH_SPEED, 1000.0, fine)
    assert f"allowed: substeps from {fine} on" in fault(module, B, tables, SMOOTH_SPEED, fine - 1)
    assert f"brakes at up to {rate:.4g} 1/s (run 1), too fast" in fault(module, B, tables, SMOOTH_SPEED, fine - 1)
    assert fault(module, B, tables, 0.0) == "friction_width: 0.0; allowed: a speed above 0"
    negative = np.where(np.arange(5)[:, None] == 2, -1.0, table)
    assert "a Coulomb level of -1; allowed: 0 or more" in fault(module, B, negative, SMOOTH_SPEED)


def fault(module, B, tables, width, substeps=1):
    """The words of the refusal; empty where it is taken."""
    try:
        module.check_friction(B, tables, width, 1000.0, substeps)
    except OptionError as error:
        return str(error)
    return ""


SLIPS = [
    ("forward = dq > 0", "forward = dq < 0"),
    ("level * casadi.tanh(dq / width)", "level * casadi.tanh(dq * width)"),
    ("return offset + level *", "return level *"),
    ("+ slope * dq", "+ slope"),
    ("forward, positive_viscous, negative_viscous", "forward, positive_viscous, positive_viscous"),
    ("smooth_friction(friction_models(table), width)", "smooth_friction(friction_models(table))"),
    ("viscous + coulomb / width", "coulomb / width"),
    ("rates[worst] * step > STABLE", "rates[worst] * step > 3"),
    ("1.0 / (rate * substeps)", "1.0 / rate"),
    ("int(np.argmax(rates))", "0"),
    ("ceil(rates[worst] / rate / STABLE)", "ceil(rates[worst] / rate)"),
    ("tables[..., i + 2, :]", "tables[..., i, :]"),
    ("(tables[..., (0, 2), :] < 0.0).any()", "False"),
]


def test_planted_slips_are_caught():
    assert not uncaught(ours.__name__, SLIPS, check_friction)


def check_table(module):
    """Both directions of each joint, Coulomb before viscous, then the offset; zero where it is unknown."""
    table = module.friction_table((*JOINTS[:2], None))
    np.testing.assert_array_equal(table[:, 1], [3.0, 0.5, 1.0, 1.2, 0.3])
    assert table.shape == (5, 3)
    assert not table[:, 2].any()
    np.testing.assert_array_equal(module.friction_table(WAM.friction_models()), module.friction_parameters(WAM))


def test_a_planted_slip_in_the_table_is_caught():
    slip = ("for x in (side.coulomb, side.viscous)", "for x in (side.viscous, side.coulomb)")
    assert not uncaught(kernel_spec.__name__, [slip], check_table)


def test_a_stribeck_curve_is_refused_by_name():
    falling = JointFriction(*(Direction(1.0, 0.1, 2.0, 0.05),) * 2)
    with pytest.raises(OptionError, match="friction of joint 2: a Stribeck curve"):
        friction_table((None, falling))
    with pytest.raises(OptionError, match=r"friction of joint 1: 0\.1 of the load; allowed: in kernels Coulomb"):
        friction_table((JointFriction(*(Direction(1.0, 0.1),) * 2, load=0.1), None))
    at_once = JointFriction(*(Direction(1.0, 0.1, 2.0),) * 2)  # static friction that drops at the first motion
    np.testing.assert_array_equal(friction_table((at_once,))[:, 0], [1.0, 0.1, 1.0, 0.1, 0.0])


def test_the_series_are_exact_up_to_the_largest_turn():
    angle, by = np.meshgrid(np.linspace(-7.0, 7.0, 29), np.linspace(-LARGEST, LARGEST, 41))
    found = turned(Turn(np.cos(angle), np.sin(angle)), by)
    assert np.abs(found.c - np.cos(angle + by)).max() < 2e-15
    assert np.abs(found.s - np.sin(angle + by)).max() < 2e-15
