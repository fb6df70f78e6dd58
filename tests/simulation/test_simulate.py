"""What a run holds: what made it, saturation, mismatch, payload, sensors, progress."""

import json
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

import lwr_dyn
from lwr_dyn.control.paper_laws import PID, InverseDynamics
from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.audit import ENERGY_TOLERANCE, audit
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import CASES, free_swing, run_setup, simulate
from lwr_dyn.trajectory.references.ist import ist_reference
from tests.simulation.sample_runs import (
    MIDDLE,
    WORST_CASE,
    Sinusoids,
    controllers,
    joint_waves,
    lwr,
    lwr_dynamics,
    with_limits,
)


def test_saturation_is_kept_and_logged():
    arm, law = with_limits(lwr(), effort=20.0), controllers()["pd-gravity"]
    run, free = (simulate(arm, law, joint_waves(0.5), q0=MIDDLE + 0.05, saturate=cut) for cut in (True, False))
    assert (np.abs(run.tau_command) > 20.0).any()
    np.testing.assert_array_equal(run.tau_applied, np.clip(run.tau_command, -20.0, 20.0))
    np.testing.assert_array_equal(free.tau_applied, free.tau_command)
    assert not np.allclose(free.q, run.q)


def test_anti_windup_shortens_the_overshoot():
    """A step too large for the motors: with the limits known to the controller the integral does not run away."""
    arm = with_limits(lwr(), effort=30.0, lower=-9.0, upper=9.0)
    still = Sinusoids(MIDDLE, np.zeros(7), np.ones(7), 3.0)
    Kp, Kd = 2500 * WORST_CASE, 100 * WORST_CASE
    knowing, blind = (PID(Kp, Kd, limit, dynamics=lwr_dynamics()) for limit in (arm.effort, np.full(7, np.inf)))
    start = MIDDLE - 0.4 * np.eye(7)[0]
    overshoot = [simulate(arm, controller, still, q0=start).q[:, 0].max() for controller in (knowing, blind)]
    assert overshoot[0] < 0.5 * overshoot[1]


@pytest.mark.slow
def test_a_heavier_plant_and_a_payload_are_felt():
    wave, load = joint_waves(2.0), {"payload": 3.0, "payload_com": (0.0, 0.0, 0.05)}

    def tip_error(controller, **options):
        return metrics(simulate(lwr(), controller, wave, **options), lwr()).tip_max_mm

    law = controllers()["inverse-dynamics"]
    exact, heavy, unknown = (
        tip_error(law),
        tip_error(law, plant=arm_with_scaled_inertia(lwr(), 1.1)),
        tip_error(law, **load),
    )
    assert 100 * exact < heavy < unknown
    carrying = arm_with_payload(lwr(), 3.0, (0.0, 0.0, 0.05))
    known = simulate(lwr(), InverseDynamics(lwr_dyn.dynamics_of(carrying), 2500, 100), wave, **load)
    assert metrics(known, lwr()).tip_max_mm == pytest.approx(exact, rel=0.2)
    assert audit(known, lwr_dyn.dynamics_of(carrying, "newton-euler")).is_closed()


def test_the_run_file_records_its_origin(tmp_path):
    other = lwr_dyn.load("lwr4plus", "physical")
    made = simulate(
        lwr(), controllers()["pid"], joint_waves(0.05), plant=other, payload=1.5, encoder=Encoder.of_bits(16), seed=7,
        meta={"task": "waves"}, rate=500.0,
    )  # fmt: skip
    made.save(tmp_path / "run.npz")
    run = Run.load(tmp_path / "run.npz")
    meta = run.meta
    assert json.loads(json.dumps(meta)) == meta
    wanted = {
        "robot": "lwr4plus", "reading": "computed", "digest": lwr().digest, "seed": 7, "note": {"task": "waves"},
        "payload": {"mass": 1.5, "com": [0.0, 0.0, 0.0], "inertia": None},
    }  # fmt: skip
    assert {name: meta[name] for name in wanted} == wanted
    assert (meta["plant"]["reading"], meta["options"]["rate"], meta["controller"]["name"]) == ("physical", 500.0, "pid")
    assert len(meta["controller"]["parameters"]["Ki"]) == 7
    assert meta["encoder"]["resolution"] == pytest.approx(2 * np.pi / 65536)
    assert set(meta["versions"]) == {"lwr_dyn", "numpy", "scipy", "pin"}
    assert meta["audit"]["residual"] <= 1e-9
    np.testing.assert_array_equal(run.q, made.q)


def test_a_setup_can_be_shown_run_again_and_stays_with_its_run(tmp_path):
    setup = prepare(
        lwr(), controllers()["pid"], joint_waves(0.05), Loop(payload=1.5, encoder=Encoder(1e-5, 1e-6), seed=2)
    )
    runs = [run_setup(setup), run_setup(setup)]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)
    assert runs[0].setup is setup
    assert setup.plant.arm.chain.bodies[6].mass > lwr().chain.bodies[6].mass + 1.49
    shown = json.loads(str(setup))
    computed = {"audit", "at_stop_s", "evaluations"}
    assert shown == {name: value for name, value in runs[0].meta.items() if name not in computed}
    runs[0].save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz").setup is None


def test_every_sample_has_its_torque_the_last_too():
    run = simulate(lwr(), controllers()["pd-gravity"], joint_waves(0.0105), rate=1000.0)
    np.testing.assert_array_equal(run.t, np.arange(12) / 1000)
    wanted, law = joint_waves().sample(run.t), controllers()["pd-gravity"]
    rows = zip(run.t, run.q, run.dq, wanted.q, wanted.dq, wanted.ddq, strict=True)
    np.testing.assert_allclose(run.tau_command, [law(*row) for row in rows], rtol=0, atol=1e-12)


def test_runs_repeat_bit_by_bit_and_controllers_start_afresh():
    law, wave, encoder = controllers()["pid"], joint_waves(0.1), Encoder(1e-5, 1e-5)
    a, b, c = (simulate(lwr(), law, wave, encoder=encoder, seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(a.q, b.q)
    assert (a.q != c.q).any()


def measured(encoder, seed=0):
    """A run, and the positions and speeds that its law was given."""
    seen = []

    def watch(t, q, dq, *reference):
        seen.append((q.copy(), dq.copy()))
        return lwr_dynamics().gravity_vector(q)

    run = simulate(lwr(), watch, joint_waves(0.3), dq0=np.full(7, 0.2), encoder=encoder, seed=seed)
    return run, *np.array(seen).transpose(1, 0, 2)


def test_an_encoder_counts_and_its_noise_has_its_deviation_and_its_seed():
    run, q, _ = measured(Encoder(resolution=1e-3))
    np.testing.assert_allclose(q / 1e-3, np.round(q / 1e-3), atol=1e-9)
    assert 0.4e-3 < np.abs(q - run.q).max() <= 0.5e-3 + 1e-12
    run, q, _ = measured(Encoder(noise=1e-3), seed=5)
    assert (q - run.q).std() == pytest.approx(1e-3, rel=0.05)
    assert np.abs((q - run.q).mean()) < 1e-4
    np.testing.assert_array_equal(measured(Encoder(noise=1e-3), seed=5)[1], q)


def test_velocity_by_an_encoder_is_the_filtered_difference():
    run, q, dq = measured(Encoder(cutoff_hz=100.0))
    np.testing.assert_array_equal(q, run.q)
    pole = np.exp(-2 * np.pi * 0.1)
    bare = np.diff(q, axis=0) * 1000.0 * (1 - pole)
    expected = lfilter([1.0], [1.0, -pole], np.vstack([run.dq[:1], bare]), axis=0)
    np.testing.assert_allclose(dq, expected, rtol=0, atol=1e-10)
    assert np.abs(dq - run.dq).max() > 1e-4  # it lags


def test_a_loop_closed_through_an_encoder_still_balances_its_energy():
    controller = controllers()["inverse-dynamics"]
    run = simulate(lwr(), controller, joint_waves(0.5), encoder=Encoder.of_bits(20, 1e-6), seed=1)
    assert audit(run).is_closed()
    assert np.abs(run.q - run.q_ref).max() < 1e-3


DRIFT = 1e-8
"""[J] Energy error allowed to a torque-free swing of 2 s by the adaptive integrator."""


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_two_seconds_keep_their_energy(case):
    run = free_swing(lwr(), case, rate=100.0)
    assert audit(run, lwr_dynamics("newton-euler")).worst_energy <= DRIFT
    assert np.ptp(run.energy) <= DRIFT
    assert (run.tau_applied == 0.0).all()
    assert run.meta["note"]["equilibrium"] is (case == "rest")
    assert case == "rest" or np.abs(run.q[-1] - run.q[0]).max() > 0.1


def test_upright_at_rest_is_an_equilibrium_and_an_offset_grows():
    run = free_swing(lwr(), "rest", duration=0.5, rate=100.0)
    assert run.meta["note"]["equilibrium"] is True
    assert np.abs(run.q).max() < 1e-2  # B^-1 g is not quite zero: com columns are printed to 1e-8 m
    pull = np.linalg.solve(lwr_dynamics().mass_matrix(np.zeros(7)), -lwr_dynamics().gravity_vector(np.zeros(7)))
    assert run.meta["note"]["acceleration_at_rest"] == pytest.approx(np.abs(pull).max(), rel=1e-6)
    offset = free_swing(lwr(), "offset", duration=0.3, rate=100.0)
    assert np.abs(offset.q[0]).max() == pytest.approx(1e-3)
    assert np.abs(offset.q[-1]).max() > 2e-3
    own = free_swing(lwr(), "speed", q0=np.full(7, 0.3), dq0=np.zeros(7), duration=0.1, rate=100.0)
    assert (own.q[0].tolist(), own.dq[0].tolist()) == ([0.3] * 7, [0.0] * 7)
    with pytest.raises(UnknownNameError, match="rest"):
        free_swing(lwr(), "sideways")


@pytest.mark.slow
def test_rk4_with_stops_loses_only_what_the_stops_take():
    run = free_swing(lwr(), "speed", duration=2.0, method="rk4", substeps=8, position_limits=True)
    assert any(event.kind == "stop" for event in run.events)
    assert run.energy[-1] < run.energy[0] - 0.1
    assert audit(run).residual <= 1e-6
    assert metrics(run, lwr()).limit_margin.min() >= -1e-9


@cache
def ist():
    return ist_reference(lwr())


@pytest.mark.slow
@pytest.mark.parametrize("name", controllers())
def test_fourteen_seconds_of_the_papers_path_keep_the_limits_and_balance_their_energy(name):
    run = simulate(lwr(), controllers()[name], ist())
    result = audit(run, lwr_dynamics("newton-euler"))
    assert max(result.worst_energy, run.meta["audit"]["residual"]) <= ENERGY_TOLERANCE
    assert (len(run.t), run.events, metrics(run, lwr()).within_limits) == (14001, (), True)
    assert np.ptp(run.energy) > 1.0  # the arm was lifted and lowered


def test_feed_forward_on_the_exact_model_keeps_the_tip_within_a_hundredth_of_a_millimetre():
    run = simulate(lwr(), controllers()["inverse-dynamics"], ist())
    assert metrics(run, lwr()).tip_max_mm < 0.01
    assert run.meta["reference"]["about"]["task"] == "ist"
