"""The matrices of elastic loops against the simulated plant: one step of it at rest, and the motion on IST."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.protocol import JointReadings, WithJointSensors, reset
from lwr_dyn.design.elastic_loop import ElasticArm
from lwr_dyn.design.sampled_loop import GROWS, Sampling
from lwr_dyn.simulation.elastic.exponential import HeldExponential
from lwr_dyn.simulation.elastic.plant import ElasticDynamics
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.simulate import simulate
from tests.design.test_elastic_loop import B_MAX, arm, law, springs

T, STEP = 1e-3, 1e-4
"""[s], and [rad, rad/s] of central differences: with 1e-7 rounding would be 1e-5 of the poles."""
FREE = SimpleNamespace(friction=None, sides=np.zeros(14), at_rest=np.zeros(14, dtype=bool))


@cache
def plant():
    """The simulated plant, and what moves it by a sample."""
    model = ElasticDynamics(arm(), springs(1e4))
    return model, HeldExponential(model, FREE, T, substeps=4)


def step_of(controller, side, pose, theta, z):
    """The deviation (q, theta, dq, dtheta) a sample after z, in the simulated plant with its law."""
    model, held = plant()
    rest = np.concatenate([pose, theta])
    now, after, still = np.array([rest + z[:14], z[14:]]), np.zeros((2, 14)), np.zeros(7)
    reset(controller)
    if isinstance(controller, WithJointSensors):
        gear = model.gear_torque(*now)
        controller.sense(JointReadings(now[0, 7:], now[1, 7:], now[0, :7], now[1, :7], gear))
    seen = slice(7, 14) if side == "motor" else slice(0, 7)
    tau = controller(0.0, now[0, seen], now[1, seen], pose, still, still)
    held.step(0.0, now, np.concatenate([still, tau]), after)
    return np.concatenate([after[0] - rest, after[1]])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "side"), [("motor", "motor"), ("pd", "link"), ("id", "link")])
def test_the_step_matrix_is_the_derivative_of_the_simulated_step(name, side):
    dynamics = lwr_dyn.dynamics_of(arm())
    poses = np.random.default_rng(5).uniform(arm().lower, arm().upper, (4, 7))
    maps = ElasticArm(dynamics, springs(1e4), arm().armature, side).loop(law(name), poses)
    for pose, expected in zip(poses, maps.step_matrices(Sampling(1 / T)), strict=True):
        theta = pose + dynamics.gravity_vector(pose) / springs(1e4).stiffness
        ahead, behind = (
            np.array([step_of(law(name), side, pose, theta, sign * STEP * e) for e in np.eye(28)]) for sign in (1, -1)
        )
        found = (ahead - behind).T / (2 * STEP)
        assert np.abs(found - expected).max() <= 1e-7 * np.abs(expected).max()
        poles, their = np.linalg.eigvals(found), np.linalg.eigvals(expected)
        assert max(np.abs(their - pole).min() for pole in poles) <= 1e-7


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "options", "tip_mm"),
    [
        ("inverse-dynamics", {}, 2.639),
        ("inverse-dynamics+motor-side", {}, 0.0901),
        ("motor-pd", {"feedforward": False}, 0.1886),
        ("motor-pd", {}, 0.000695),
    ],
)
def test_errors_on_ist_are_those_of_what_a_law_knows_of_the_springs(name, options, tip_mm):
    """Tip RMS over the first second: deflection unknown, that of gravity taken off (twice), all of it fed forward."""
    reference = lwr_dyn.reference("ist", arm())
    options = options | ({} if name.startswith("inverse") else {"inertia": B_MAX})
    controller = lwr_dyn.controller(name, arm(), **options)
    run = simulate(arm(), controller, reference, elasticity=springs(1e4), duration=1.0, position_limits=False)
    assert metrics(run, arm()).tip_rms_mm == pytest.approx(tip_mm, rel=0.02)


def test_a_loop_with_poles_outside_swings_within_its_torque_limits():
    """PD on the link side: the map grows, the simulated run is bounded, and its torque is cut most of the time."""
    reference, controller = lwr_dyn.reference("ist", arm()), law("pd")
    pose = reference.sample(np.zeros(1)).q
    grows = ElasticArm(lwr_dyn.dynamics_of(arm()), springs(1e4), arm().armature, "link").loop(controller, pose)
    assert grows.radius(Sampling(1 / T))[0] > GROWS
    run = simulate(arm(), controller, reference, elasticity=springs(1e4), encoders="link", duration=1.0)
    assert (run.tau_command != run.tau_applied).any(axis=1).mean() > 0.5
    assert np.abs(run.q - run.q_ref).max() < 0.2
