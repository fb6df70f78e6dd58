"""The matrices of elastic loops: their table, against the simulated plant, and against differences by road B."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import LinearFeedback, diagonal
from lwr_dyn.control.protocol import JointReadings, WithJointSensors, reset
from lwr_dyn.design.elastic_loop import ElasticArm, ElasticShares, continuous_poles, elastic_shares, elastic_table
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.run import Motion
from lwr_dyn.simulation.elastic.exponential import HeldExponential
from lwr_dyn.simulation.elastic.plant import ElasticDynamics
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.simulate import simulate
from tests.design.margin_cases import arm, dynamics, largest, law, springs


def test_a_row_for_every_law_on_every_stiffness():
    laws = [(law("pd-gravity"), "link"), (law("motor-pd"), "motor")]
    reference = lwr_dyn.reference("ist", arm())
    table = elastic_table(arm(), laws, [1e4, 3e4], reference, 5.0, poses=40)
    assert [(*row[:2], row[3], row[4]) for row in table.cells] == [
        ("10000", "pd-gravity", "+58.8", "all (above 91.2 %)"),
        ("10000", "motor-pd", "-23.2", "0 (below 8.8 %)"),
        ("30000", "pd-gravity", "-27.0", table.cells[2][4]),
        ("30000", "motor-pd", "-26.9", "0 (below 8.8 %)"),
    ]
    late = elastic_table(arm(), laws[1:], ["file"], reference, 5.0, Sampling(1000.0, 1), poses=40)
    assert late.cells[0][5] == "all (above 91.2 %)"
    assert "late by 1 sample" in late.columns[5].title
    with pytest.raises(MissingDataError, match="stiffness"):
        elastic_table(lwr_dyn.load("wam7"), laws[:1], ["file"], reference, 5.0)


def test_shares_count_each_pose_on_both_roads_and_their_interval_holds_them():
    """One by one as all at once; damping on light rotors is unstable only when it is sampled."""
    q = np.random.default_rng(1).uniform(arm().lower, arm().upper, (30, 7))
    plant = ElasticArm.of(arm(), 3e4, "link")
    found = elastic_shares(plant, law("pd-gravity"), q)
    one_by_one = [elastic_shares(plant, law("pd-gravity"), pose[None]) for pose in q]
    for total in ("continuous", "sampled"):
        assert getattr(found, total) == sum(getattr(each, total) for each in one_by_one)
    for largest_of in ("growth", "radius"):
        assert getattr(found, largest_of) == pytest.approx(max(getattr(each, largest_of) for each in one_by_one))
    damper = SimpleNamespace(linear_feedback=lambda q: LinearFeedback(*(diagonal(np.full(7, 400.0), len(q)),) * 2))
    motor = elastic_shares(ElasticArm.of(arm(), 3e4, "motor"), damper, q)
    assert (motor.continuous, motor.sampled) == (0, 30)
    assert motor.radius > 1.2

    for low, high in ElasticShares(200, 20, 0, 5.0, 0.9).intervals:
        assert 0.0 <= low < high
    assert ElasticShares(200, 20, 0, 5.0, 0.9).intervals[0] == pytest.approx((0.0657, 0.1494), abs=1e-3)


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
@pytest.mark.parametrize(
    ("name", "side"), [("motor-pd", "motor"), ("pd-gravity", "link"), ("inverse-dynamics", "link")]
)
def test_the_step_matrix_is_the_derivative_of_the_simulated_step(name, side):
    poses = np.random.default_rng(5).uniform(arm().lower, arm().upper, (4, 7))
    maps = ElasticArm(dynamics(), springs(1e4), arm().armature, side).loop(law(name), poses)
    for pose, expected in zip(poses, maps.step_matrices(Sampling(1 / T)), strict=True):
        theta = pose + dynamics().gravity_vector(pose) / springs(1e4).stiffness
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
    options = options | ({} if name.startswith("inverse") else {"inertia": largest("physical")})
    controller = lwr_dyn.controller(name, arm(), **options)
    run = simulate(arm(), controller, reference, elasticity=springs(1e4), duration=1.0, position_limits=False)
    assert metrics(run, arm()).tip_rms_mm == pytest.approx(tip_mm, rel=0.02)


def test_a_loop_with_poles_outside_swings_within_its_torque_limits():
    """PD on the link side: the map grows, the simulated run is bounded, and its torque is cut most of the time."""
    reference, controller = lwr_dyn.reference("ist", arm()), law("pd-gravity")
    pose = reference.sample(np.zeros(1)).q
    grows = ElasticArm(dynamics(), springs(1e4), arm().armature, "link").loop(controller, pose)
    assert grows.radius(Sampling(1 / T))[0] > GROWS
    run = simulate(arm(), controller, reference, elasticity=springs(1e4), encoders="link", duration=1.0)
    assert (run.tau_command != run.tau_applied).any(axis=1).mean() > 0.5
    assert np.abs(run.q - run.q_ref).max() < 0.2


RNG = np.random.default_rng(28)
q, dq, ddq = RNG.uniform(-1, 1, (3, 7))
MOTION = Motion(np.zeros(1), q[None], dq[None], ddq[None])
LINKS = lwr_dyn.dynamics_of(arm(), "newton-euler", rotors="none")
SPRINGS, ROTOR = springs(100.0, 0.1), arm().armature  # soft, so that no term is small beside them


def rates(z, u):
    """dz/dt of z = (q, theta, dq, dtheta) under the motors' torques u."""
    x, theta, v, dtheta = z.reshape(4, 7)
    gear = SPRINGS.stiffness * (theta - x) + SPRINGS.damping * (dtheta - v)
    return np.concatenate([v, dtheta, LINKS.forward_dynamics(x, v, gear), (u - gear) / ROTOR])


def differences(function, at, step=1e-5):
    """The matrix of derivatives of a function of a vector."""
    return np.array([(function(at + step * e) - function(at - step * e)) / (2 * step) for e in np.eye(at.size)]).T


THETA = q + LINKS.inverse_dynamics(q, dq, ddq) / SPRINGS.stiffness
Z, STILL = np.concatenate([q, THETA, dq, dq]), np.zeros(7)


@cache
def of_the_plant():
    """A and B."""
    return differences(lambda x: rates(x, STILL), Z), differences(lambda u: rates(Z, u), STILL)


@cache
def of_the_loop(side):
    """A of the loop with PD."""
    seen = [1, 3] if side == "motor" else [0, 2]
    return differences(lambda x: rates(x, law("pd-gravity")(0.0, *x.reshape(4, 7)[seen], q, dq, ddq)), Z)


def test_the_loop_is_that_of_derivatives_of_the_plant_and_its_poles_those_by_hand():
    A, B = of_the_plant()
    any_z = np.arange(28.0)
    for side, first in (("motor", 7), ("link", 0)):
        elastic = ElasticArm(dynamics(), SPRINGS, ROTOR, side)
        plant = elastic.plant(MOTION)
        close(plant.A[0], A)
        close(plant.B[0], B)
        close(plant.position @ any_z, any_z[first : first + 7])
        close(plant.velocity @ any_z, any_z[first + 14 : first + 21])
        close(plant.torque[0] @ Z, SPRINGS.stiffness * (THETA - q))
        close(elastic.spring_side(MOTION)[0], THETA)
        found = elastic.frozen_poles(law("pd-gravity"), MOTION)[0]
        close(found, np.linalg.eigvals(of_the_loop(side)), any_order=True)
    gains = RNG.uniform(1, 9, (3, 1, 7, 7))
    form = LinearFeedback(*gains[:2], integral=np.arange(1.0, 8.0), torque=gains[2])
    back = gains[0, 0] @ plant.position + gains[1, 0] @ plant.velocity + gains[2, 0] @ plant.torque[0]
    by_hand = np.zeros((35, 35))
    by_hand[:28, :28], by_hand[:28, 28:] = plant.A[0] - plant.B[0] @ back, plant.B[0]
    by_hand[28:, :28] = -np.diag(form.integral) @ plant.position
    found = continuous_poles(RestingLoop(plant, form))[0]
    close(found, np.linalg.eigvals(by_hand), any_order=True)
    assert (np.diff(found.real) <= 0.0).all()
    reads = elastic.loop(law("motor-pd"), q[None])  # the motor side, whatever the encoders are
    close(reads.plant.position @ any_z, any_z[7:14])


def close(found, expected, any_order=False):
    if any_order:
        assert max(np.abs(expected - pole).min() for pole in found) <= 1e-5 * np.abs(expected).max()
        return
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())
