"""Identification from any motion: what generated the log comes back, and what it cannot say is said."""

import json
from dataclasses import astuple
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, MissingDataError, OptionError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.identification.bodies.body_prior import ConstraintError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.identifiable import NOT_DETERMINED, cell_origins, parameter_states
from lwr_dyn.identification.motion.motion_fit import identify_motion, likeliest_samples
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.regression.information import normal_equations
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, student_factor
from lwr_dyn.identification.regression.samples import SampleRule, exact_samples, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.transmission import Transmission
from tests.identification.model_study import swing_of
from tests.identification.plants import inside, perturbed_plant, random_motion, rms, simulated_log, torques
from tests.identification.table_study import TableStudy
from tests.json_schemas import faults

NOISE = 0.1
ENCODER = 1e-5
COUPLED = SampleRule(transmission=Transmission(np.diag(np.full(6, 100.0)) + np.diag([0.0, 0.0, 0.0, 0.0, 20.0], -1)))


@pytest.fixture(scope="module")
def plant(lwr):
    return perturbed_plant(TorqueColumns(lwr.chain, "directions"), lwr, np.random.default_rng(1))


@pytest.fixture(scope="module")
def recorded(lwr, plant):
    def record(seconds=10.0, seed=2, source="log", noise=NOISE, encoder=ENCODER):
        rng = np.random.default_rng(seed)
        return simulated_log(plant, random_motion(lwr, seconds, rng, rate=500.0), noise, rng, encoder, source)

    return record


@pytest.fixture(scope="module")
def found(lwr, recorded):
    return identify_motion([recorded()], lwr)


def test_intervals_hold_what_generated_the_log(found, plant):
    gap = np.abs(found.information.values - plant.base)
    assert np.mean(gap < found.half_widths) > 0.98
    assert found.information.residual_noise == pytest.approx(NOISE, rel=0.1)
    assert found.condition < 200


def test_bodies_come_out_nearer_to_the_truth_than_the_table(found, plant, lwr):
    fit = found.consistent
    assert fit.physical.all()
    inertial = slice(0, 10 * lwr.n)
    away = np.abs(fit.parameters - plant.parameters)[inertial] / fit.sigma[inertial]
    assert np.mean(away < 4.0) > 0.9
    base = found.base
    scale = found.information.sigma
    own, mine = base.of(found.columns.own(lwr)), base.of(fit.parameters)
    assert np.linalg.norm((mine - plant.base) / scale) < 0.1 * np.linalg.norm((own - plant.base) / scale)


def test_unseen_torques_are_predicted_to_the_noise(found, recorded):
    for one in found.validation:
        assert NOISE * 0.85 < one.fitted < one.held_out < 1.3 * NOISE
        assert one.consistent < 1.2 * NOISE
        assert one.model > 10 * one.held_out
        assert 0.7 * NOISE < one.left_out < 1.4 * NOISE
    for one in found.validated_on([recorded(5.0, seed=7, source="other")]):
        assert one.held_out < 1.3 * NOISE
        assert one.consistent < 1.2 * NOISE
        assert np.isnan(one.fitted)
        assert sum(band.equations for band in one.by_speed) > 100


def about(value):
    return pytest.approx(value) if isinstance(value, float | list | np.ndarray) else value


def test_the_document_is_the_fit_number_by_number(found, recorded, lwr):
    unseen = found.validated_on([recorded(5.0, seed=7, source="other")])
    shown = motion_document(found, robot="lwr4plus", unseen=unseen, files="other.csv")
    record = json.loads(json_text(shown.record()))
    assert faults("identify motion", record) == []
    information, fit = found.information, found.consistent
    facts = {
        "robot": "lwr4plus", "equations": int(information.equations.sum()), "condition": found.condition,
        "base_parameters": 76, "identified": found.identified, "noise": information.residual_noise.tolist(),
        "inflation": information.inflation.tolist(), "chi2": information.chi2, "dof": found.equations - 76, "folds": 5,
        "stribeck_velocity": None, "stribeck_velocity_error": None,
    }  # fmt: skip
    assert {key: record[key] for key in facts} == {key: about(value) for key, value in facts.items()}
    rows = zip(found.base.statements(), information.values, information.sigma, found.half_widths, found.of_the_model,
               found.states, strict=True)  # fmt: skip
    columns = ("parameter", "value", "standard_error", "three_sigma", "of_the_model", "state", "identified")
    wanted = [[*map(about, row), row[-1] == IDENTIFIED] for row in rows]
    assert [[row[key] for key in columns] for row in record["parameters"]] == wanted
    names = ("joint", "measured", "held_out", "consistent", "model", "left_out")
    for table, joints in (("validation", found.validation), ("validated_on", unseen)):
        wanted = [[about(getattr(one, key)) for key in names] for one in joints]
        assert [[row[key] for key in names] for row in record[table]] == wanted
        bands = [[[*astuple(band)] for band in one.by_speed] for one in joints]
        assert [[[*band.values()] for band in row["by_speed"]] for row in record[table]] == bands
    assert [row["fitted"] for row in record["validated_on"]] == [None] * 7
    assert [row["white"] for row in record["whiteness"]] == [one.white for one in found.whiteness]
    near, table = record["consistent"], found.columns.own(lwr)
    facts = {
        "physical": [True] * 7, "scales": [*astuple(fit.scales)], "lifted": [*fit.lifted],
        "price_chi2": fit.price.chi2, "pull": fit.price.pull,
    }  # fmt: skip
    assert {key: near[key] for key in facts} == {key: about(value) for key, value in facts.items()}
    rows = zip(fit.parameters, table, found.shown_sigma, strict=True)
    assert [[row[key] for key in ("value", "of_the_model", "standard_error")] for row in near["parameters"]] == [
        [*map(about, row)] for row in rows
    ]
    assert [row["says"] == "table" for row in near["parameters"]] == [sigma is None for sigma in found.shown_sigma]
    text = shown.text()
    assert text.startswith(f"{found.identified} of 76 base parameters identified, from {found.equations} equations, ")
    for line in (
        "bodies near the table: 7 of 7 links are bodies", f"({'found from the logs' if fit.chosen else 'as given'})",
        "validation, RMS in N m (N): 5 parts of the motion, each kept from a fit in turn",
        "validation, RMS in N m (N): other.csv, which no fit has seen", "not identified yet; what would do it",
        "known only together (correlation above ", "table in place of a plus-minus: no torque shows the number",
        "residuals, white at 1% over ",
    ):  # fmt: skip
        assert line in text
    assert "[unseen" not in text  # a title, and no unit
    mass = text[text.index("centre of mass") :].splitlines()[2].split()
    assert float(mass[1]) == pytest.approx(fit.parameters[0], rel=1e-2)


def test_states_of_parameters_and_where_a_number_comes_from():
    values, sigma = np.array([1.0, -1.0, 0.1, 0.1, 0.1, 7.0]), np.array([*[0.1] * 5, np.inf])
    own, shown = np.array([0.0, 5.0, 0.2, 0.0, 2.0, 1.0]), np.isfinite(sigma)
    for dof, wanted in (
        (10**6, ["identified"] * 2 + ["not excited"] + ["0 within 3 sigma"] * 2),
        (0, ["no error known"] * 5),
    ):
        fit = SimpleNamespace(values=values, half_widths=sigma * student_factor(dof), determined=shown)
        assert parameter_states(fit, own) == (*wanted, NOT_DETERMINED)
    assert cell_origins(np.array([0.1, 0.5, 0.95, 1.0])) == ("log", "log and table", "table", "table")


def test_the_fit_of_a_fold_does_not_see_it(lwr, recorded):
    """Torque spoilt in one recording of three leaves the fits that predict it, but not their prediction."""
    logs = [recorded(5.0, seed=s, source=f"log {s}", noise=0.01, encoder=0.0) for s in (2, 3, 4)]
    tau = logs[1].tau.copy()
    tau[:, 6] += 3.0
    spoilt = [logs[0], JointLog("log 3", logs[1].joints, logs[1].t, logs[1].q, tau), logs[2]]
    rule = MotionRule(folds=3)
    good, bad = identify_motion(logs, lwr, rule), identify_motion(spoilt, lwr, rule)
    assert good.validation[6].held_out < 0.05
    rows = good.samples.recording == 1
    from_fold = bad.validation[6].held_out
    assert from_fold > 3.0 * np.sqrt(np.mean(rows)) * 0.9


def test_residuals_are_white_where_the_noise_is_and_not_where_friction_is_missing(lwr, recorded, found):
    assert sum(w.white for w in found.whiteness) >= 6
    log = recorded()
    dq = np.gradient(log.q[:, 3], log.t)
    tau = log.tau.copy()
    tau[:, 3] += 1.5 * np.sign(dq) * np.exp(-np.square(dq / 0.3))
    stribeck = identify_motion([JointLog("log", log.joints, log.t, log.q, tau)], lwr)
    assert not stribeck.whiteness[3].white
    assert stribeck.whiteness[3].inflation > 1.3
    row = f"4      no     {stribeck.whiteness[3].autocorrelation[0]:+.2f}"
    assert row in motion_document(stribeck).text()
    assert stribeck.validation[3].held_out > 3 * found.validation[3].held_out


def test_the_filter_is_the_log_s_likeliest(lwr, recorded):
    """A clean log keeps the highest; positions in coarse steps ask for a lower one, or for the log's own speeds."""
    rule, log = MotionRule(cutoffs=(20.0, 10.0, 5.0)), recorded(encoder=0.0)
    assert likeliest_samples([log], lwr, rule).cutoff == 20.0
    q = np.round(log.q / 1e-3) * 1e-3
    coarse = JointLog("log", log.joints, log.t, q, log.tau)
    assert likeliest_samples([coarse], lwr, rule).cutoff < 20.0
    speeds = JointLog("log", log.joints, log.t, q, log.tau, np.gradient(log.q, log.t, axis=0))
    chosen = likeliest_samples([speeds], lwr, rule)
    assert chosen.own_speeds
    at = [samples_of([one], chosen) for one in (log, speeds)]
    assert np.abs(at[0].dq - at[1].dq).max() < 0.02 * np.abs(at[0].dq).max()
    assert np.abs(at[0].ddq - at[1].ddq).max() < 0.05 * np.abs(at[0].ddq).max()


def test_a_joint_that_never_moves_is_not_determined_and_the_table_speaks_for_it(lwr, recorded, found):
    """Parameters that are known only together are grouped, there and in the log where all move."""
    log = recorded()
    q = log.q.copy()
    q[:, 2] = 0.3
    held = identify_motion([JointLog("log", log.joints, log.t, q, log.tau)], lwr)
    states = dict(zip(held.base.statements(), held.states, strict=True))
    for name in ("coulomb+_3", "viscous+_3", "coulomb-_3", "viscous-_3"):
        assert states[name] == NOT_DETERMINED
    assert np.isinf(held.half_widths[held.base.statements().index("coulomb+_3")])
    assert held.consistent.physical.all()
    for fit in (held, found):
        check_groups(fit)
    names = found.base.statements()
    assert any("coulomb+_2" in {names[i] for i in group.members} for group in found.groups)
    rotor = held.columns.rotor_indices[2]
    assert held.origins[rotor] == "table"
    assert len(held.whiteness) == 6
    assert "this motion does not show it at all" in motion_document(held).text()


@pytest.mark.slow  # its bodies are sought to the last digit
def test_a_contradiction_by_a_log_without_noise_says_so_and_what_to_do(lwr, recorded):
    exact = identify_motion([recorded(5.0, noise=0.0, encoder=0.0)], lwr)
    assert not exact.has_noise
    assert "the log has no noise, so that sigma is rounding" in exact.contradiction
    missed = float(exact.contradiction.split("miss the log by ")[1].split()[0])
    assert missed == pytest.approx(np.nanmax(exact.consistent.price.rms), rel=0.5)
    assert exact.contradiction.endswith("give the torques a sensor's noise, or accept the bodies")


def test_a_contradiction_by_a_log_with_noise_does_not_speak_of_none(lwr, recorded, found):
    assert found.has_noise
    loud = identify_motion([recorded()], lwr, MotionRule(deviation=0.003))
    assert loud.contradiction
    assert "no noise" not in loud.contradiction


def test_the_swing_that_is_named_promises_what_its_columns_say(lwr, recorded):
    """Sigma with 10 s of it at 100 Hz, as loud as the log, beside the log: of no more than half."""
    short = identify_motion([recorded(2.0, noise=0.5)], lwr)
    said = short.information
    for motion in short.missing_motions():
        m = swing_of(motion, 100.0)
        limit = 0.1 * np.abs(m.dq).max()
        samples = exact_samples(m.t, m.q, m.dq, m.ddq, np.zeros(m.q.shape), limit)
        more, _ = normal_equations(samples, said.columns, said.base).weighted(said.noise)
        sigma = np.sqrt(np.diag(np.linalg.inv(said.precision + more)))[list(motion.parameters)]
        assert motion.sigma == pytest.approx(sigma, rel=0.05)
        assert motion.before == pytest.approx(said.sigma[list(motion.parameters)])
        assert (sigma < 0.5 * 1.05 * np.array(motion.before)).all()
        reach = np.minimum(0.5, (lwr.upper - lwr.lower) / 4)
        speed = 2 * np.pi * np.array(motion.hertz) * motion.amplitudes
        joints = np.array(motion.joints) - 1
        assert (motion.amplitudes <= reach[joints] + 1e-12).all()
        assert (speed <= 0.8 * lwr.velocity[joints] + 1e-12).all()


@pytest.mark.slow
def test_the_swing_that_is_named_identifies_what_was_not(lwr, plant, recorded):
    """A log of the named swing is made, and its errors are those that were promised."""
    short = identify_motion([recorded(2.0, noise=0.5)], lwr)
    motion = short.missing_motions()[0]
    assert short.identified < 50
    swing = simulated_log(plant, swing_of(motion, 500.0), 0.5, np.random.default_rng(5), source="swing")
    both = identify_motion([recorded(2.0, noise=0.5), swing], lwr)
    then = both.information.sigma[list(motion.parameters)]
    assert then == pytest.approx(motion.sigma, rel=0.1)
    assert (then < 0.6 * np.array(motion.before)).all()


def check_groups(found):
    assert found.groups
    for group in found.groups:
        assert found.information.determined[list(group.members)].all()
        assert len(group.members) > 1
        assert 0.9 < abs(group.largest) <= 1.0
        block = found.information.covariance[np.ix_(group.members, group.members)]
        correlation = block / np.sqrt(np.outer(np.diag(block), np.diag(block)))
        assert np.abs(correlation - np.eye(len(correlation))).max() == pytest.approx(abs(group.largest))


@pytest.mark.slow
def test_a_wrong_geometry_shows_on_unseen_torques(wam, fourier):
    """The LWR's frames cannot explain the WAM's torques, and validation shows it."""
    wrong = identify_motion([fourier(wam, wam.friction)], lwr_dyn.load("lwr4plus"))
    right = identify_motion([fourier(wam, wam.friction)], wam)
    assert wrong.validation[1].held_out > 20 * right.validation[1].held_out


def test_a_log_of_too_few_rows_is_refused(wam, fourier):
    with pytest.raises(LogError, match=r"fourier: columns q1..q7: \d+ equations for 76 parameters of 7 joints; needed"):
        identify_motion([fourier(wam, wam.friction, seconds=0.3)], wam, MotionRule(samples=SampleRule(cutoff=40.0)))


@pytest.mark.slow
def test_an_arm_without_masses_has_base_parameters_and_no_bodies(fourier, wam):
    bare = lwr_dyn.load("lwr4")
    result = identify_motion([fourier(wam, wam.friction)], bare)
    assert result.consistent is None
    assert result.origins == ()
    assert IDENTIFIED in result.states


@pytest.mark.slow
def test_what_is_known_of_the_bodies_holds_to_rounding_and_contradictions_are_named(lwr, recorded, plant):
    total, last = float(plant.parameters[0:70:10].sum()), float(plant.parameters[60])
    rule = MotionRule(known=(f"total mass = {total!r}", f"m_7 = {last!r}"))
    fit = identify_motion([recorded(3.0)], lwr, rule).consistent
    assert fit.physical.all()
    assert fit.parameters[0:70:10].sum() == pytest.approx(total, rel=1e-9)
    assert fit.parameters[60] == pytest.approx(last, rel=1e-9)
    assert fit.sigma[60] < 1e-9
    with pytest.raises(ConstraintError, match=r"total mass = 1; m_7 = 2 together"):
        identify_motion([recorded(3.0)], lwr, MotionRule(known=("total mass = 1", "m_7 = 2", "m_1 = 0.1")))
    with pytest.raises(MissingDataError, match="lwr4"):
        identify_motion([recorded(3.0)], lwr_dyn.load("lwr4"), MotionRule(known=("m_7 = 2",)))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"folds": 1}, "folds: 1; allowed: a number of at least 2"),
        *(({"gains": x}, f"gains: {x}; allowed: a share above 0 and up to 0.5, ") for x in (0.0, -0.1, 0.51, np.nan)),
        *(({"deviation": x}, f"deviation: {x}; allowed: a share above 0 and up to 10, ") for x in (0.0, 10.1, np.nan)),
        ({"samples": COUPLED, "gains": 0.1}, "gains: given for motors that turn joints together; allowed: motors with"),
        ({"samples": COUPLED, "load_friction": True}, "load friction: given for motors that turn joints together"),
    ],
)
def test_rules_that_cannot_be_are_refused(options, words):
    apart = SampleRule(transmission=Transmission(100.0 * np.eye(6)))
    for gains, load_friction in ((0.5, False), (None, True)):
        MotionRule(apart, folds=2, deviation=10.0, gains=gains, load_friction=load_friction)
    with pytest.raises(OptionError) as refused:
        MotionRule(**options)
    assert words in str(refused.value)


@pytest.mark.parametrize(
    ("robot", "options", "commanded", "words"),
    [
        ("ur10", {"coupled": True}, False, "coupled motors: asked for of ur10, whose torques have none"),
        ("tx40", {"coupled": True, "samples": SampleRule(link_side=True)}, False, "coupled motors: asked for of tx40"),
        ("tx40", {"coupled": True, "gains": 0.1}, False, "gains: given for motors that turn joints together"),
        ("tx40", {"coupled": True, "load_friction": True}, False, "load friction: given for motors that turn joints"),
        ("ur10", {"coupled": True}, True, "coupled motors: given; allowed: none with instruments"),
        ("ur10", {"load_friction": True}, True, "load friction: given; allowed: none with instruments"),
        ("ur10", {"gains": 0.1}, True, "gains: 0.1; allowed: none with instruments"),
    ],
)
def test_what_does_not_go_with_an_arm_or_with_instruments_is_refused(robot, options, commanded, words):
    log = JointLog("log", tuple(range(1, 7)), 0.01 * np.arange(10), *np.zeros((2, 10, 6)))
    with pytest.raises(OptionError) as refused:
        identify_motion([log], lwr_dyn.load(robot), MotionRule(**options), [log] * commanded)
    assert words in str(refused.value)


@pytest.mark.slow
def test_rotors_stay_the_tables_where_sensors_are_behind_the_gears():
    """Of the same log a fit that believes in rotors finds a tenth of them, or none."""
    study = TableStudy.of("lwr4plus")
    truth, rotors = study.truth("natural", np.random.default_rng(0)), study.columns.rotor_indices
    truth[rotors] = 0.0
    m, own = study.motions[0], study.columns.own(study.arm)
    tau = torques(study.columns, truth, m) + np.random.default_rng(1).normal(0.0, 0.1, m.q.shape)
    log = JointLog("sensors", tuple(range(1, 8)), m.t, m.q, tau)
    found = identify_motion([log], study.arm, MotionRule(SampleRule(link_side=True)))
    np.testing.assert_array_equal(found.consistent.parameters[rotors], own[rotors])
    assert not found.contradiction
    z = ((found.consistent.parameters - truth) / found.consistent.sigma)[: study.columns.bodies]
    assert inside(z) > 0.97
    spoilt = identify_motion([log], study.arm, MotionRule(SampleRule()))
    assert (spoilt.consistent.parameters[rotors] < 0.15 * own[rotors]).all()


@pytest.mark.slow
def test_large_rotors_of_an_arm_of_mujoco_are_found_and_gains_follow():
    """A road that shares no step of ours; the table of the arm has no rotors."""
    from tests.identification.mujoco_study import BIG_ROTORS, mujoco_fit

    fit = mujoco_fit("iiwa14", "rotors", 0)
    assert rms(fit.base) < 1.3
    assert np.abs(fit.base).max() < 4.5
    assert (np.abs(fit.rotors) < 3.0).all()
    assert np.abs(fit.armature / BIG_ROTORS - 1.0).max() < 0.1
    assert (fit.sigma < 0.2 * np.array(BIG_ROTORS)).all()
    assert np.abs(fit.gains - 1.0).max() < 0.2
    assert not fit.refused
