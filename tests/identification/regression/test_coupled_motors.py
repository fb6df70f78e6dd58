"""Motors that turn several joints: their columns, which of both forms a log asks for, and what is written of them."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.fitted import fitted_values
from lwr_dyn.identification.fitted_files import write_fitted
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.payload.identify_load import identify_load
from lwr_dyn.identification.payload.possible_load import load_document
from lwr_dyn.identification.regression.coupled_motors import at_motors, has_coupled_motors, motors_or_joints
from lwr_dyn.identification.regression.joints_alone import between_words
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.transmission import Transmission
from tests.identification.coupled_study import LOAD, MOTORS, coupled_arm, coupled_log, identified, misses, with_load
from tests.identification.plants import inside, perturbed_plant, random_motion, rms, simulated_log

UNCOUPLED = MotionRule(coupled=False)


@pytest.fixture(scope="module")
def tx40():
    return identified("tx40", 0)


@pytest.fixture(scope="module")
def joints_log():
    """Of a TX40 whose friction and rotors are those of the joints."""
    arm, rng = lwr_dyn.load("tx40"), np.random.default_rng(5)
    plant = perturbed_plant(TorqueColumns(arm.chain, "directions"), arm, rng, 0.1)
    return simulated_log(plant, random_motion(arm, 6.0, rng, rate=250.0), 0.05, rng, 1e-5)


@pytest.fixture(scope="module")
def of_joints(joints_log):
    return identify_motion([joints_log], lwr_dyn.load("tx40"))


@pytest.mark.parametrize("name", list(MOTORS))
def test_columns_give_the_torques_of_bodies_and_of_one_motor_after_the_other(name):
    truth = coupled_arm(name, 0)
    motion = random_motion(truth.arm, 2.0, np.random.default_rng(1))
    motors = truth.arm.transmission.at_joints()
    columns = TorqueColumns(truth.arm.chain, "directions", transmission=motors)
    wanted = truth.torque(motion)
    found = columns(motion.q, motion.dq, motion.ddq) @ truth.parameters
    still = (motion.dq @ motors.matrix.T == 0.0).any(axis=1)  # no friction at rest
    assert found[~still] == pytest.approx(wanted[~still], abs=1e-11 * np.abs(wanted).max())


def test_the_log_asks_for_the_motors_and_gives_their_rotors_and_friction(tx40):
    truth, found = tx40
    assert found.columns.transmission is not None
    z = (found.information.values - found.base.of(truth.parameters)) / found.information.sigma
    assert np.abs(z).max() < 4.0
    fit = found.consistent
    assert np.abs((fit.parameters - truth.parameters) / fit.sigma)[found.columns.bodies :].max() < 4.0
    noise, log = found.information.residual_noise, coupled_log(truth, 0)
    assert noise[4:].max() < 0.06
    assert identify_motion([log], truth.arm, UNCOUPLED).information.residual_noise[4:].min() > 5.0 * noise[4:].max()
    assert found.validated_on([log])[4].held_out < 0.06


def test_a_log_of_friction_at_the_joints_asks_for_the_joints(joints_log, of_joints):
    arm = lwr_dyn.load("tx40")
    forced = identify_motion([joints_log], arm, UNCOUPLED)
    assert of_joints.columns.transmission is None
    assert np.array_equal(of_joints.consistent.parameters, forced.consistent.parameters)
    assert np.array_equal(of_joints.information.precision, forced.information.precision)
    assert identify_motion([joints_log], arm, MotionRule(gains=0.1)).columns.transmission is None


def test_motors_in_another_order_than_the_joints_are_not_tried(joints_log):
    """Motors 5 and 6 exchanged: motor 5 would turn joint 6 too, motor 6 joint 5 alone."""
    arm = lwr_dyn.load("tx40")
    exchanged = Transmission(arm.transmission.matrix[[0, 1, 2, 3, 5, 4]])
    other = replace(arm, transmission=exchanged)
    assert exchanged.coupled.any()
    assert not has_coupled_motors(other, SampleRule())
    with pytest.raises(OptionError, match="coupled motors: asked for of tx40"):
        at_motors(SampleRule(), other)
    assert motors_or_joints(SampleRule(), [joints_log], other, "directions").transmission is None


def test_the_report_says_which_motor_turns_what_and_nothing_is_left_out(tx40, of_joints):
    here, left_out = (
        "motor 6 turns with joints 5 and 6: rotors and friction are those of motors, each",
        "left out: a rotor",
    )
    for found, coupled in ((tx40[1], True), (of_joints, False)):
        document = motion_document(found)
        text = document.text()
        assert (here in text, left_out in text, document.record()["coupled"]) == (coupled, not coupled, coupled)
    assert "left out: a rotor that turns with joint_5 and joint_6" in text
    assert "turns with joints" not in text


def alone(at_motor):
    """What joints 5 and 6 of a TX40 show, each moving alone: motor 6 turns with both."""
    return [*at_motor[:4], at_motor[4] + at_motor[5], at_motor[5]]


def test_a_written_model_has_what_each_joint_shows_alone(tx40, tmp_path):
    _, found = tx40
    values, fit = fitted_values(found), found.consistent
    J, at = fit.parameters[found.columns.rotor_indices], found.columns.rotor_indices
    assert values.armature.value == pytest.approx(alone(J), rel=1e-12)
    spread = fit.covariance[np.ix_(at[4:], at[4:])].sum() ** 0.5
    assert values.armature.sigma[4:] == pytest.approx([spread, fit.sigma[at[5]]])
    own = fit.parameters[found.columns.bodies :].reshape(6, 5)
    for k, side in ((1, "positive"), (3, "negative")):
        for more, name in enumerate(("coulomb", "viscous")):
            shown = [getattr(getattr(model, side), name) for model in values.friction]
            assert shown == pytest.approx(alone(own[:, k + more]))
    write_fitted(tmp_path / "arm.toml", found, load_with_paper("tx40")[1])
    arm = lwr_dyn.load(tmp_path / "arm.toml")
    assert f"adds {J[5]:.3g} kg m^2 between them" in arm.caveat()
    raw = tomllib.loads((tmp_path / "arm.toml").read_text(encoding="utf-8"))
    said = f"motor 6 turns with joints 5 and 6: {J[5]:.3g} kg m^2 between joints 5 and 6, and friction where several of"
    assert said in raw["document"]["fit"]
    assert between_words(found.columns.transmission, J).startswith(said)
    again = TorqueColumns(arm.chain, "directions", transmission=arm.transmission.at_joints()).own(arm)
    assert again[60:] == pytest.approx(fit.parameters[60:], abs=1e-12)


def test_directions_of_a_motor_that_turns_against_a_joint_are_exchanged():
    """WAM: motor 2 turns by -dq_3/1.68, motor 3 by 1.68 dq_2: joint 3 moving up rubs motor 2 downwards."""
    truth = coupled_arm("wam7", 1)
    found = identify_motion([coupled_log(truth, 1)], truth.arm, MotionRule(coupled=True))
    values = fitted_values(found)
    J, up, slope, down, _ = found.consistent.parameters[70:].reshape(7, 5).T
    second, third = values.friction[1], values.friction[2]
    assert (third.positive.coulomb, third.negative.coulomb, second.positive.coulomb) == pytest.approx(
        (up[2] + down[1] / 1.68, down[2] + up[1] / 1.68, up[1] + 1.68 * up[2])
    )
    assert values.armature.value[1] == pytest.approx(J[1] + 1.68**2 * J[2])
    assert second.positive.viscous == pytest.approx(slope[1] + 1.68**2 * slope[2])
    pulleys = np.hypot(1.0, [1.0 / 1.68, 1.68])  # a motor is slow where its joints at the usual speed leave it so
    assert found.rule.samples.slowest == pytest.approx([0.05, *(0.05 * pulleys), 0.05, *[0.05 * 2**0.5] * 2, 0.05])


def test_the_command_has_both_forms(lwr_dyn_command, joints_log, tmp_path):
    path = tmp_path / "log.csv"
    write_log(path, replace(joints_log, source=str(path)))
    command = ("identify", "motion", "tx40", str(path))
    for option, coupled in (("--coupled", True), ("--uncoupled", False)):
        code, out, _ = lwr_dyn_command(*command, option, "--json", "--as-logged")
        assert (code, json.loads(out)["coupled"], "left out: a rotor" in out) == (0, coupled, not coupled)
    code, _, err = lwr_dyn_command(*command, "--coupled", "--motor-side")
    assert (code, "--coupled: would do nothing here; allowed: without --motor-side" in err) == (2, True)


def test_a_load_is_found_beside_the_friction_of_the_motors():
    """With the arm fitted too, so that its table plays no part; columns of the joints have twice the errors."""
    truth = coupled_arm("wam7", 2)
    log, empty = coupled_log(with_load(truth), 2), coupled_log(truth, 3)
    found = identify_load([log], truth.arm, unloaded=[empty])
    assert found.noise.max() < 0.06
    assert np.abs((found.parameters - LOAD) / found.sigma).max() < 4.0
    joints = identify_load([log], replace(truth.arm, transmission=None), unloaded=[empty])
    assert (found.sigma < joints.sigma / 2.0)[:4].all()
    text = load_document(found).text()
    assert "motor 2 turns with joints 2 and 3, motor 3 turns with joints 2 and 3" in text
    assert "turns with" not in load_document(joints).text()


def test_a_load_is_said_with_what_its_fit_leaves_out(lwr_dyn_command, joints_log, tmp_path):
    truth, paths = coupled_arm("tx40", 2), [tmp_path / "motors.csv", tmp_path / "joints.csv"]
    for path, log in zip(paths, (coupled_log(with_load(truth), 2), joints_log), strict=True):
        write_log(path, replace(log, source=str(path)))
    motors, joints = (lwr_dyn_command("identify", "payload", "tx40", str(path))[1] for path in paths)
    assert "motor 6 turns with joints 5 and 6: rotors and friction are those of motors" in motors
    assert motors.startswith("tx40 (body): inertias estimated\n")
    assert joints.startswith("tx40 (body): inertias estimated; left out: a rotor that turns with joint_5 and joint_6")
    assert "those of motors" not in joints


@pytest.mark.slow
@pytest.mark.parametrize("name", list(MOTORS))
def test_parameters_of_twenty_logs_lie_within_three_sigma(name):
    for z in misses(name, range(20)):
        assert inside(z) > 0.99
        assert rms(z) < 1.1
