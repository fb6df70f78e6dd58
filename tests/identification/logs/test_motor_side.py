"""Logs of motors through a coupled transmission."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, MissingDataError, OptionError, ShapeError
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.logs.motor_side import MotorMap, log_at_joints, motor_map
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import Plant, random_motion, torques

ARM = lwr_dyn.load("wam7")
T = ARM.transmission.matrix
CONSTANT = np.array([0.05, 0.05, 0.05, 0.05, 0.012, 0.012, 0.02])
HOME = np.array([3.0, -1.0, 2.0, 0.5, 0.0, 1.0, -4.0])
MOTORS = motor_map(ARM, CONSTANT, HOME)
RULE = SampleRule(slowest=0.05 * np.linalg.norm(T, axis=1), transmission=ARM.transmission)


def motor_plant():
    """The WAM with friction and rotors at its motors, shared by the joints of a differential."""
    columns = TorqueColumns(ARM.chain, transmission=ARM.transmission)
    parameters = columns.own(ARM)
    rng = np.random.default_rng(4)
    for j, gear in enumerate(np.abs(T).max(axis=1)):
        sizes = np.array([ARM.armature[j] / gear**2, 1.0 / gear, 0.5 / gear**2, 0.1 / gear])
        parameters[columns.of_joint(j)] = sizes * np.exp(0.3 * rng.normal(size=4))
    return Plant(columns, parameters)


@pytest.fixture(scope="module")
def plant():
    return motor_plant()


def motor_log(plant, motion, noise, encoder, rng):
    """Encoders and currents of the motors: [rad] at the motors, noise of the shafts' torques [N m]."""
    tau = torques(plant.columns, plant.parameters, motion)
    shaft = np.linalg.solve(T.T, tau.T).T
    shaft += rng.normal(size=tau.shape) * noise
    turned = motion.q @ T.T + HOME + rng.normal(size=tau.shape) * encoder
    blank = np.full_like(tau, np.nan)
    return JointLog("motors", tuple(range(1, 8)), motion.t, blank, blank, motor_q=turned, current=shaft / CONSTANT)


def of_motors(motor_q, current=None, tau=None):
    """A log of what motors read."""
    blank = np.full_like(motor_q, np.nan)
    t, tau = np.arange(float(len(blank))), blank if tau is None else tau
    return JointLog("m.csv", tuple(range(1, 8)), t, blank, tau, motor_q=motor_q, current=current)


def test_base_parameters_through_the_coupling_are_recovered(plant):
    """Recovery figure: bodies, rotors and friction of coupled motors, every z within 4.5 and their mean square 1.

    Without the transmission in the columns the residual is many times the noise.
    """
    rng = np.random.default_rng(5)
    motion = random_motion(ARM, 20.0, rng, rate=1000.0)
    log = log_at_joints(motor_log(plant, motion, 0.002 * np.ones(7), 1e-4, rng), MOTORS)
    found = information_of(samples_of([log], RULE), plant.columns)
    z = (found.values - plant.base) / found.sigma
    assert found.determined.all()
    assert np.abs(z).max() < 4.5
    assert 0.6 < np.mean(z**2) < 1.5
    exact = samples_of([log_at_joints(motor_log(plant, motion, 0.0, 0.0, rng), MOTORS)])
    coupled, apart = (information_of(exact, c).noise for c in (plant.columns, TorqueColumns(ARM.chain)))
    assert coupled[1:3].max() < 1e-3 * apart[1:3].min()


def test_what_goes_to_the_motors_and_back_is_the_joints_with_the_same_power():
    q, tau = np.random.default_rng(0).normal(size=(2, 5, 7))
    shaft = np.linalg.solve(T.T, tau.T).T
    turned = q @ T.T
    for log, motors in (
        (of_motors(turned + HOME, current=shaft / CONSTANT), MOTORS),
        (of_motors(turned + HOME, tau=shaft), motor_map(ARM, home=HOME)),
        (of_motors(turned, tau=shaft), motor_map(ARM)),
    ):
        back = log_at_joints(log, motors)
        assert back.q == pytest.approx(q, abs=1e-13)
        assert back.tau == pytest.approx(tau, abs=1e-13)
        assert (back.tau * back.q).sum(axis=1) == pytest.approx((shaft * turned).sum(axis=1))


def test_gears_stand_in_for_a_transmission_where_no_motors_are_coupled():
    arm = lwr_dyn.load("lwr4plus", "physical")
    ratios = [link.rotor.gear_ratio for link in arm.chain.links]
    assert np.array_equal(motor_map(arm).transmission.matrix, np.diag(ratios))


def test_bad_input_is_refused_with_what_is_needed():
    zero, one = np.zeros((3, 7)), np.ones((3, 7))
    for log, motors, words in (
        (replace(of_motors(zero), motor_q=None), MOTORS, r"m\.csv: columns qm1\.\.: none; needed: .*qm1\.\.qm7"),
        (of_motors(zero[:, :6]), MOTORS, r"columns qm1\.\.: 6; needed: the positions of 7 motors"),
        (of_motors(zero, tau=zero), MOTORS, r"columns i1\.\.: none; needed: currents, for the torque constants"),
        (of_motors(zero, current=one), motor_map(ARM), r"columns i1\.\.: currents alone; needed: torque constants"),
    ):
        with pytest.raises(LogError, match=words):
            log_at_joints(log, motors)
    for make, error, words in (
        (
            lambda: motor_map(ARM, [1.0, -1.0, 1, 1, 1, 1, 1]),
            OptionError,
            "torque constant of motor 2: -1; allowed: above",
        ),
        (lambda: MotorMap(ARM.transmission, np.ones(3)), ShapeError, "torque_constant"),
        (lambda: motor_map(replace(ARM, transmission=None)), MissingDataError, "gear ratio of joint_1"),
    ):
        with pytest.raises(error, match=words):
            make()


@pytest.mark.slow
def test_the_command_takes_logs_of_motors(plant, tmp_path, lwr_dyn_command):
    """`identify motion --motor-side`: base parameters as simulated, and what is missing is named in one line."""
    rng = np.random.default_rng(7)
    log = motor_log(plant, random_motion(ARM, 10.0, rng, rate=500.0), 0.002 * np.ones(7), 1e-4, rng)
    path = tmp_path / "motors.csv"
    write_log(path, log)
    numbers = (f"--torque-constant={','.join(map(str, CONSTANT))}", f"--motor-home={','.join(map(str, HOME))}")
    fit = ("identify", "motion", "wam7", str(path), "--fit-friction", "symmetric")
    code, out, _ = lwr_dyn_command(*fit, "--motor-side", *numbers, "--json")
    rows = json.loads(out)["parameters"]
    z = [(row["value"] - true) / row["standard_error"] for row, true in zip(rows, plant.base, strict=True)]
    assert code == 0
    assert np.abs(z).max() < 4.5
    for options, words in ((("--motor-side", numbers[1]), "tau1"), ((numbers[0],), "with --motor-side")):
        code, out, err = lwr_dyn_command(*fit, *options)
        assert (code, out, words in err) == (2, "", True)
