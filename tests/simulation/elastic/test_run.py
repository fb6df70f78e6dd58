"""Elastic runs: against Radau, the rigid limit, energy, stick, stops, external torques, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import DivergenceError
from lwr_dyn.model.run import Run
from lwr_dyn.model.transmission import JointElasticity
from lwr_dyn.pages.replay.replay_page import run_record
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.simulation.audit import audit, uneventful
from lwr_dyn.simulation.elastic.plant import elastic_plant
from lwr_dyn.simulation.elastic.run import STAGES, TIMES, radau, second_road
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.simulate import simulate
from tests.json_schemas import faults
from tests.simulation.elastic.elastic_arms import FRICTION, law, physical, short_run
from tests.simulation.sample_runs import MIDDLE, Still, joint_waves


@pytest.mark.slow
@pytest.mark.parametrize("elasticity", [5e3, 1e4, 3e4])
def test_one_step_a_sample_against_radau_and_the_other_engine(elasticity):
    run, fine = short_run(elasticity=elasticity), short_run(elasticity=elasticity, method="radau", substeps=2)
    np.testing.assert_allclose([run.q, run.signals["theta"]], [fine.q, fine.signals["theta"]], rtol=0, atol=1e-8)
    found = [(x.meta["options"]["method"], x.audit["closed"]) for x in (run, fine)]
    assert found == [("exponential", True), ("radau", True)]
    other = short_run(elasticity=elasticity, duration=0.004, engine="newton-euler")
    assert np.abs(run.q[:5] - other.q).max() <= 1e-9
    road = other.audit["inverse_dynamics"]
    assert (road["engine"], other.audit["closed"]) == ("pinocchio and Radau IIA 5", True)


@pytest.mark.slow
def test_the_rigid_limit_has_order_one_and_costs_the_same():
    rigid = simulate(physical(), law(), joint_waves(), duration=0.1)
    runs = [short_run(elasticity=10.0**k) for k in range(4, 9)]
    gaps = np.array([np.abs(run.q - rigid.q).max() for run in runs])
    assert np.log10(gaps[1:-1] / gaps[2:]) == pytest.approx(1.0, abs=0.02)
    assert len({run.meta["evaluations"] for run in runs}) == 1
    assert all(run.audit["closed"] for run in runs)


def test_motors_stick_truly_and_slip_again_and_the_work_of_all_channels_is_the_change_of_energy():
    run = short_run(friction=FRICTION, duration=0.4)
    theta, dtheta = run.signals["theta"], run.signals["dtheta"]
    sticks = [event.joint for event in run.events if event.kind == "stick"]
    assert 0 <= min(sticks) <= max(sticks) < 7
    plain = uneventful(run, False)
    rests = (dtheta[plain + 1] == 0.0) & (dtheta[plain] == 0.0)
    assert rests.sum() > 20
    assert ((theta[plain + 1] - theta[plain])[rests] == 0.0).all()
    assert (run.dq[plain][rests] != 0.0).any()  # the link still swings on its spring
    assert set(run.work) == {"actuator", "friction", "stop", "damper"}
    audited, road = run.audit, run.audit["inverse_dynamics"]
    assert audited["residual"] <= 1e-7
    assert audited["channels"]["damper"] < -1e-4
    assert audited["channels"]["friction"] < -1e-2
    assert (road["closed"], road["engine"]) == (True, "newton-euler and Radau IIA 5")


@pytest.mark.slow
def test_a_link_stops_at_its_limit_while_its_motor_turns_on():
    limits, upper = list(physical().limits), float(MIDDLE[3]) + 0.002
    limits[3] = replace(limits[3], upper=upper)
    tight = replace(physical(), limits=tuple(limits))
    run = simulate(tight, law(), joint_waves(), elasticity="file", duration=0.5)
    assert ("stop", 3) in [(event.kind, event.joint) for event in run.events]
    assert run.q[:, 3].max() <= upper < run.signals["theta"][:, 3].max()
    assert run.meta["at_stop_s"][3] > 0.0
    assert run.audit["residual"] <= 1e-7
    assert run.work["stop"][-1] <= 0.0


def test_springs_far_stiffer_than_a_step_can_follow_explicitly_are_followed_by_radau():
    assert short_run(elasticity=1e9, method="radau", duration=0.002).audit["closed"]


def test_external_torques_act_on_the_links():
    torque = 5.0 * np.eye(7)[1]
    run, alone = (
        short_run(reference=Still(MIDDLE, 0.2), external=x, duration=0.2) for x in (lambda t, q, dq: torque, None)
    )
    assert run.audit["closed"]
    assert run.signals["tau_external"].tolist() == [torque.tolist()] * 201
    assert run.work["external"][-1] == pytest.approx(5.0 * (run.q[-1, 1] - run.q[0, 1]), rel=1e-6)
    assert run.q[-1, 1] > alone.q[-1, 1]


def test_at_rest_the_springs_carry_the_arm():
    still = {"reference": Still(MIDDLE, 0.02), "duration": 0.02}
    weight = short_run(**still).signals["torque_sensor"][0]
    run = short_run(lambda *_: weight, **still)
    assert np.abs(run.q - MIDDLE).max() <= 1e-12
    assert run.signals["theta"][0] - MIDDLE == pytest.approx(weight / physical().elasticity.stiffness, rel=1e-12)


def test_a_loop_that_only_the_torque_limits_bound_is_told_by_the_share_of_cut_torques_and_else_it_diverges():
    unstable, stable = (short_run(law("pd-gravity"), encoders=side, duration=0.5) for side in ("link", "motor"))
    assert np.isfinite(unstable.q).all()
    assert max(unstable.meta["cut_share"]) > 0.1
    assert max(stable.meta["cut_share"]) == 0.0
    with pytest.raises(DivergenceError) as fault:
        short_run(lambda t, q, dq, *rest: 1e9 * dq + 1.0, saturate=False)
    assert fault.value.run.meta["diverged"]["joint"] == fault.value.joint in physical().joint_names


def test_a_run_file_and_its_figures_keep_the_motors(tmp_path):
    run, elasticity = short_run(duration=0.01), physical().elasticity
    run.save(tmp_path / "run.npz")
    loaded = Run.load(tmp_path / "run.npz")
    assert np.array_equal(loaded.signals["theta"], run.signals["theta"])
    assert np.array_equal(loaded.work["damper"], run.work["damper"])
    kept = loaded.meta["elasticity"]
    assert (kept["stiffness"], kept["encoders"]) == (elasticity.stiffness.tolist(), "motor")
    assert metrics(run, physical()).caveat == "rigid links, elastic joints"
    assert run_record(replayed_runs([run], [physical()])[0])["tip_model"] == "rigid links, elastic joints"
    again = audit(replace(run, setup=None))
    assert (again.residual, again.actuator_gap, again.other_road) == (run.audit["residual"], None, None)
    assert judged(replace(run, q=np.tile(physical().upper, (run.t.size, 1)))) is None  # nothing is left to judge


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"continuous": True}, "continuous: with elastic joints; allowed: a sampled run"),
        ({"method": "dop853"}, "method: dop853 with elastic joints; allowed: rk4"),
        ({"elasticity": 0.0}, "stiffness: 0.0; allowed"),
        ({"encoders": "both"}, "encoders: 'both'; allowed: motor, link"),
        ({"elasticity": None, "encoders": "link"}, "encoders: would do nothing with rigid joints"),
        ({"elasticity": None, "method": "radau"}, "method: would do nothing with rigid joints; allowed: with elastic"),
        ({"elasticity": JointElasticity([1.0], [0.0])}, "joint stiffness: 1 number; allowed: 7"),
    ],
)
def test_what_means_nothing_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        short_run(**options)


HOLD = ("simulate", "lwr4plus", "--reading", "physical", "--task", "hold", "--from-deg", "0,30,0,-60,0,30,0")
SHORT = (*HOLD, "--duration", "0.02", "--controller", "inverse-dynamics")
WAM = ("simulate", "wam7", "--task", "hold", "--from-deg", "0,-60,0,90,0,0,0", "--duration", "0.01", "--own-gains")


@pytest.mark.slow
def test_a_run_of_the_command_and_its_record(lwr_dyn_command):
    code, out, err = lwr_dyn_command(*SHORT, "--elastic", "file")
    assert code == 0
    assert all(line.startswith("note: ") for line in err.splitlines())  # this law is unstable in some of the box
    for words in ("damper -", "inverse dynamics by newton-euler and Radau IIA 5 at", "plant elastic joints, motor enc"):
        assert words in out
    code, out, _ = lwr_dyn_command(*SHORT, "--elastic", "3e4", "--encoders", "link", "--substeps", "2", "--json")
    record = json.loads(out)
    meta = record["meta"]
    assert (code, faults("simulate", record), meta["audit"]["closed"]) == (0, [], True)
    assert max(meta["elasticity"]["stiffness"]) == pytest.approx(3e4)
    assert (meta["elasticity"]["encoders"], meta["options"]["method"]) == ("link", "exponential")
    assert (meta["note"]["plant"], meta["cut_share"]) == ("elastic joints of 3e4 N m/rad, link encoders", [0.0] * 7)
    assert lwr_dyn_command(*WAM, "--elastic", "2e4", "--friction", "none")[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "message"),
    [
        ((*SHORT, "--encoders", "link"), "--encoders: would do nothing here; allowed: with --elastic"),
        ((*SHORT, "--elastic", "1e4", "--reading", "computed"), "too light for elastic joints"),
        ((*WAM, "--elastic", "file"), "lwr-dyn: wam7: joint stiffness not given; needed for elastic joints\n"),
    ],
)
def test_what_the_command_refuses_is_one_line(line, message, lwr_dyn_command):
    code, out, err = lwr_dyn_command(*line)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err


@pytest.mark.slow
def test_steep_smooth_friction_is_followed():
    run = short_run(friction=lambda dq: 5.0 * np.tanh(dq / 0.01), duration=0.02, substeps=4)
    assert run.audit["residual"] <= 1e-7
    assert run.work["friction"][-1] < 0.0


def pendulum(t, y):
    return np.array([y[1], -np.sin(y[0])])


def test_its_tableau_integrates_polynomials_with_order_five_on_a_pendulum():
    for k in range(3):
        assert STAGES @ TIMES**k == pytest.approx(TIMES ** (k + 1) / (k + 1), rel=1e-13)
    assert [STAGES[2] @ TIMES**k for k in range(5)] == pytest.approx([1 / (k + 1) for k in range(5)], rel=1e-13)
    ends = [radau(2, 2**k)(pendulum, 0.0, np.array([1.0, 0.0]), 2.0)[0] for k in range(2, 8)]
    errors = np.abs(np.array(ends[:3]) - ends[-1])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(5.0, abs=0.3)


def test_work_is_summed_beside_the_motion_of_stiff_equations_and_what_rests_stays_to_the_last_bit():
    def swing(t, y):
        return np.array([y[1], -y[0], y[1] ** 2])

    def resting(t, y):
        q, rest, dq, still = y
        return np.array([dq, still, -1e4 * (q - rest) - 10.0 * dq, 0.0])

    for _ in range(2):  # the second time with slopes that are known
        end = radau(2, 16)(swing, 0.0, np.array([0.0, 1.0, 0.0]), 1.0)
        assert end[2] == pytest.approx(0.5 + np.sin(2.0) / 4, abs=1e-9)
    end = radau(1, 10)(lambda t, y: -1e7 * (y - np.cos(t)) - np.sin(t), 0.0, np.array([1.0]), 1.0)
    assert end[0] == pytest.approx(np.cos(1.0), abs=1e-9)
    end = radau(4, 3)(resting, 0.0, np.array([1.0, 0.3, 0.0, 0.0]), 0.01)
    assert (end[1], end[3]) == (0.3, 0.0)
    for fails in (lambda t, y: y / 0.0, lambda t, y: 1e30 * y**2):
        with np.errstate(all="ignore"):
            assert np.isnan(radau(1)(fails, 0.0, np.array([1.0]), 1.0)).all()


def judged(run):
    return second_road(run, elastic_plant(run.setup))


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"friction": FRICTION, "duration": 0.3}])
def test_a_true_run_is_closed(options):
    road = judged(short_run(**options))
    assert road.share <= 1.0
    assert road.judged > 20


@pytest.mark.slow
def test_what_does_not_fit_is_seen():
    run = short_run(friction=FRICTION, duration=0.15)
    bent = replace(run, tau_applied=run.tau_applied + np.eye(7)[4] * 1e-3)
    for changed in (
        replace(run, signals={**run.signals, "theta": run.signals["theta"] + np.eye(7)[2] * 1e-7}), bent,
        replace(run, tau_friction=run.tau_friction + 1e-3), replace(run, t=run.t * (1 + 1e-5)),
        replace(run, dq=run.dq * (1 + 1e-3)),
    ):  # fmt: skip
        assert judged(changed).share > 1.0
    assert judged(bent).joint == 4
