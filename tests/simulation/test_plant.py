"""The plant: limits that are off or unknown are infinite, payloads and scaled masses, arms that cannot exist."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.foundation.errors import FileAccessError, NotPhysicalError, OptionError, RatingWarning, ShapeError
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.run import Run
from lwr_dyn.simulation import audit
from lwr_dyn.simulation.plant import Encoder, FilteredDifference, plant_of
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import Still, joint_waves, lwr, lwr_dynamics, one_joint


def slider(**options):
    arm = one_joint(lower=-1.0, upper=2.0, effort=9.0)
    return plant_of(arm, lwr_dyn.dynamics_of(arm), **options)


def test_limits_are_those_of_the_arm_or_infinite():
    free, inf = slider(position_limits=False, saturate=False), np.inf
    limits = [[x.lower[0], x.upper[0], x.effort[0]] for x in (slider(), free)]
    assert limits == [[-1.0, 2.0, 9.0], [-inf, inf, inf]]
    assert slider().friction.form == "none"


@pytest.mark.parametrize(
    ("q", "side", "beyond"), [(-1.1, -1, True), (-1.0, -1, False), (0.0, 0, False), (2.0, 1, False), (2.1, 1, True)]
)
def test_at_a_limit_is_not_yet_beyond_it(q, side, beyond):
    assert slider().at_limit(np.array([q])).tolist() == [side]
    assert slider().beyond(np.array([q])).tolist() == [beyond]


def test_a_payload_adds_its_mass_and_scaling_multiplies_all_inertia():
    q, dq, ddq = np.random.default_rng(0).uniform(-1, 1, (3, 7))
    plain = lwr_dyn.dynamics_of(lwr())
    heavy = lwr_dyn.dynamics_of(arm_with_payload(lwr(), 2.0))
    p = lwr_dyn.forward_kinematics(lwr(), q)[2, 3]
    added = heavy.potential_energy(q) - plain.potential_energy(q)
    assert added == pytest.approx(-2.0 * lwr().chain.gravity[2] * p, rel=1e-9)
    assert arm_with_payload(lwr(), 0.0).chain.links[-1].body.mass == lwr().chain.links[-1].body.mass
    arm = one_joint(lever=0.3, gravity=(0.0, -9.81, 0.0))
    one, three = (lwr_dyn.dynamics_of(x) for x in (arm, arm_with_scaled_inertia(arm, 3.0)))
    state = q[:1], dq[:1], ddq[:1]
    np.testing.assert_allclose(three.inverse_dynamics(*state), 3.0 * one.inverse_dynamics(*state), rtol=1e-12)


def test_what_cannot_be_carried_is_refused_and_an_overload_is_warned_of():
    with pytest.raises(OptionError, match=r"payload mass: -1\.0; allowed: a number >= 0"):
        arm_with_payload(lwr(), -1.0)
    for factor in (0.0, -1.0, np.nan):
        with pytest.raises(OptionError, match=f"mass factor: {factor}; allowed: a number above 0"):
            arm_with_scaled_inertia(lwr(), factor)
    arm = one_joint()
    rated = replace(arm, ratings=replace(arm.ratings, payload=3.0))
    with pytest.warns(RatingWarning, match="one: a payload of 4 kg is over the rated 3 kg"):
        arm_with_payload(rated, 4.0)


def test_an_inertia_that_no_body_has_is_refused_unless_it_is_allowed():
    arm = one_joint()
    bad = replace(arm, chain=with_bodies(arm.chain, [Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 3.0]))]))
    dynamics = lwr_dyn.dynamics_of(bad)
    with pytest.raises(NotPhysicalError, match=r"one \(none\)"):
        plant_of(bad, dynamics)
    assert plant_of(bad, dynamics, allow_unphysical=True).n == 1


LEVELS = np.array([8.0, -6.0, 4.0, 5.0, 1.0, -0.5, 0.1])
ROUNDING = 1e-12


def waves(t, q, dq):
    """A spring, a damper that is not symmetric, and a push that comes and goes: smooth in all."""
    return LEVELS * np.sin(9.0 * t) - 0.3 * np.sin(q) - 0.02 * np.roll(dq, 1)


def law():
    return InverseDynamics(lwr_dynamics(), 2500.0, 100.0)


def pushed(external=waves, controller=None, duration=0.4, **options):
    return simulate(lwr(), controller or law(), joint_waves(), duration=duration, external=external, **options)


def friction(level=2.0, static=2.5):
    one = Direction(coulomb=level, viscous=0.5, static=static)
    return [JointFriction(one, one)] * 7


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {}, {"substeps": 3}, {"method": "dop853"}, {"continuous": True, "substeps": 4}, {"friction": friction()},
        {"engine": "newton-euler", "duration": 0.1},
    ],
    ids=str,
)  # fmt: skip
def test_the_audit_closes_and_the_channel_is_not_empty(options):
    run = pushed(**options)
    assert run.audit["inverse_dynamics"] is not None
    assert run.audit["closed"], run.audit
    assert abs(run.work["external"][-1]) > 1e-3
    assert run.meta["external"]["name"] == "waves"
    np.testing.assert_array_equal(run.signals["tau_external"][37], waves(run.t[37], run.q[37], run.dq[37]))


def test_it_acts_as_the_same_torque_of_the_motors_would(monkeypatch):
    """Another road that forgets it does not close; without one nothing is recorded."""
    inner, level, options = law(), LEVELS / 4, {"saturate": False, "friction": friction()}
    by_motors = pushed(None, lambda *state: inner(*state) + level, **options)
    outside = pushed(lambda t, q, dq: level, inner, **options)
    np.testing.assert_allclose(outside.q, by_motors.q, rtol=0, atol=ROUNDING)
    by_hand = (outside.q - outside.q[0]) @ level  # of a constant torque
    np.testing.assert_allclose(outside.work["external"], by_hand, rtol=0, atol=1e-12)
    assert ("external" in by_motors.work, by_motors.meta["external"], dict(by_motors.signals)) == (False, None, {})
    monkeypatch.setattr(audit.Intervals, "external", lambda self, x, v, s: np.zeros_like(x))
    assert pushed().audit["inverse_dynamics"]["residual"] > 1.0


def test_a_push_that_grows_moves_joints_that_friction_held():
    start = np.zeros(7)
    weight = lwr_dynamics().gravity_vector(start)
    run = simulate(
        lwr(), lambda *_: weight, Still(start, 0.2), friction=friction(2.0, 3.0),
        external=lambda t, q, dq: np.eye(7)[0] * 40.0 * t,
    )  # fmt: skip
    slip = next(event for event in run.events if event.kind == "slip")
    assert (slip.joint, slip.t) == (0, pytest.approx(3.0 / 40.0, abs=1e-6))
    assert (run.q[run.t < 0.0749] == start).all()
    assert run.audit["closed"], run.audit


class Telling:
    """A law that tells a vector and a number of itself."""

    def __init__(self, change=False):
        self.law, self.calls, self.change = law(), 0, change

    def __call__(self, *state):
        self.calls += 1
        return self.law(*state)

    @property
    def signals(self):
        size = 3 if not self.change or self.calls < 5 else 2
        return {"pair": np.full(size, self.calls), "calls": self.calls}


def test_signals_are_kept_in_run_file_and_columns(tmp_path):
    run = simulate(lwr(), Telling(), joint_waves(), duration=0.02, external=waves)
    shapes = {name: x.shape for name, x in run.signals.items()}
    assert shapes == {"pair": (21, 3), "calls": (21, 1), "tau_external": (21, 7)}
    columns, count = run.to_columns(), np.arange(1, 22)
    np.testing.assert_array_equal([run.signals["calls"][:, 0], columns["calls"], columns["pair2"]], [count] * 3)
    assert "tau_external7" in columns
    run.save(tmp_path / "run.npz")
    again = Run.load(tmp_path / "run.npz")
    for name, values in run.signals.items():
        np.testing.assert_array_equal(again.signals[name], values)
    assert again.work["external"][-1] == run.work["external"][-1]
    with pytest.raises(ValueError, match="read-only"):
        run.signals["pair"][0] = 1.0


def test_a_signal_that_changes_its_length_is_refused_in_a_run_and_in_a_file(tmp_path):
    with pytest.raises(ShapeError, match="signal pair at sample 4"):
        simulate(lwr(), Telling(change=True), joint_waves(), duration=0.02)
    simulate(lwr(), law(), joint_waves(), duration=0.01, external=waves).save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as stored:
        arrays = dict(stored)
    arrays["signal_tau_external"] = arrays["signal_tau_external"][:-1]
    np.savez(tmp_path / "broken.npz", **arrays)
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(tmp_path / "broken.npz")


@pytest.mark.parametrize(
    ("external", "error", "words"),
    [(3.0, OptionError, "a function"),
     (lambda t, q, dq: np.zeros(6), ShapeError, r"external torque at t = 0 s: shape \(6,\)"),
     (lambda t, q, dq: "push", ShapeError, "not an array of numbers"),
     (lambda t, q, dq: np.full(7, 0.0 if t < 0.005 else np.nan), OptionError, "external torque at t = 0.005 s"),
     (lambda t, q, dq: np.zeros(7 if t < 0.005 else 6), ShapeError, "external torque at t = 0.005 s")],
)  # fmt: skip
@pytest.mark.parametrize("continuous", [False, True])
def test_bad_ones_are_refused_in_one_line(external, error, words, continuous):
    with pytest.raises(error, match=words) as caught:
        pushed(external, continuous=continuous)
    assert "\n" not in str(caught.value)


RATE = 1000.0


def answers(signal, cutoff_hz=50.0, **start):
    estimate = FilteredDifference(cutoff_hz, RATE)
    estimate.start(signal[:1], **start)
    return np.array([estimate(np.array([x]))[0] for x in signal[1:]])


def test_a_filtered_difference_rises_like_a_first_order_lag_or_starts_at_speed():
    t = np.arange(400) / RATE
    np.testing.assert_allclose(answers(3.0 * t), 3.0 * (1 - np.exp(-2 * np.pi * 50.0 * t[1:])), atol=1e-11)
    np.testing.assert_allclose(answers(2.0 * t, dq=[2.0]), 2.0, rtol=1e-12)
    pole = FilteredDifference(50.0, RATE).pole
    np.testing.assert_allclose(answers(np.array([0.0, 1e-3, 1e-3])), [1 - pole, (1 - pole) * pole], rtol=1e-12)
    with pytest.raises(ShapeError):
        FilteredDifference(10.0, RATE).start([0.0, 1.0], [0.0])


def test_an_encoder_reads_counts_of_what_noise_leaves_and_its_filter_begins_at_the_speed_of_the_start():
    true, dq0, T = np.array([[0.123, -0.456], [0.14, -0.4], [0.15, -0.41]]), np.array([0.7, -0.2]), 2e-3
    noise = np.random.default_rng(7).normal(0.0, 3e-3, (3, 2))
    for resolution in (0.01, 0.0):
        measure = Encoder(resolution, 3e-3, 50.0).sensor(true[0], dq0, 3, 1 / T, 7)
        read, speeds = zip(*[measure(q, 9.0 * dq0) for q in true], strict=True)
        wanted = np.round((true + noise) * 100.0) / 100.0 if resolution else true + noise
        np.testing.assert_allclose(read, wanted, atol=1e-15)
        expected, pole = [dq0], np.exp(-2 * np.pi * 50.0 * T)
        for step in np.diff(wanted, axis=0):
            expected.append(pole * expected[-1] + (1 - pole) * step / T)
        np.testing.assert_allclose(speeds, expected, rtol=1e-12)
    assert Encoder.of_bits(12, 1e-4, 30.0) == Encoder(2 * np.pi / 4096, 1e-4, 30.0)


def test_the_cut_off_is_three_decibels_down():
    cutoff = 20.0
    t = np.arange(4000) / RATE
    w = 2 * np.pi * cutoff
    out = answers(np.sin(w * t) / w, cutoff)[2000:]
    assert np.sqrt(2) * out.std() == pytest.approx(1 / np.sqrt(2), rel=0.005)
