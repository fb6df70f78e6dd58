"""`identify motion --instruments`: unfiltered logs with the motion that was commanded, and a bag of a ROS robot."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog, read_log, write_log
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.regression.instrumental import commanded_motion, instrumental_information
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.bags import write_bag
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

ARM = lwr_dyn.load("lwr4plus", "physical")
ENCODER, NOISE = 1e-5, 0.1


@pytest.fixture(scope="module")
def plant():
    return perturbed_plant(TorqueColumns(ARM.chain, "directions"), ARM, np.random.default_rng(1), 0.2)


@pytest.fixture(scope="module")
def motion():
    return random_motion(ARM, 10.0, np.random.default_rng(2), rate=1000.0)


@pytest.fixture(scope="module")
def command(motion):
    """What `excite` writes: times and positions at 100 Hz."""
    q = motion.q[::10]
    return JointLog("e.csv", tuple(range(1, 8)), motion.t[::10], q, np.full(q.shape, np.nan))


@pytest.fixture(scope="module")
def log(plant, motion):
    return simulated_log(plant, motion, NOISE, np.random.default_rng(3), ENCODER, source="log.csv")


@pytest.fixture
def files(tmp_path, log, command):
    write_log(tmp_path / "log.csv", log)
    write_log(tmp_path / "e.csv", replace(command, tau=np.zeros(command.q.shape)))
    return str(tmp_path / "log.csv"), str(tmp_path / "e.csv")


def test_the_truth_is_within_its_errors(plant, log, command):
    """Recovery: the command at 100 Hz is enough; bodies near the table come out of it too."""
    result = identify_motion([log], ARM, instruments=[command])
    z = (result.information.values - plant.base) / result.information.sigma
    assert (np.abs(z) < 3.0).mean() > 0.97
    assert 0.5 < np.mean(z**2) < 2.0
    assert result.consistent is not None
    assert result.consistent.physical.all()
    assert (result.validation, result.whiteness) == ((), ())
    unseen = random_motion(ARM, 10.0, np.random.default_rng(9), rate=1000.0)
    judged = result.validated_on([simulated_log(plant, unseen, NOISE, np.random.default_rng(4), ENCODER)])
    assert all(v.held_out < 1.3 * NOISE < v.model for v in judged[:4])


@pytest.mark.slow
def test_the_spline_is_the_motion_that_was_commanded(command, motion):
    inside = slice(100, -100)
    found = commanded_motion(command, motion.t)
    for name, bound in (("q", 1e-8), ("dq", 1e-6), ("ddq", 1e-3)):
        assert getattr(found, name)[inside] == pytest.approx(getattr(motion, name)[inside], abs=bound)


def test_a_command_that_ends_early_is_refused_by_name(log, command):
    short = replace(command, t=command.t[:500], q=command.q[:500], tau=command.tau[:500])
    with pytest.raises(LogError, match=r"e\.csv.*0 to 4\.99 s.*all times of the log"):
        identify_motion([log], ARM, instruments=[short])
    with pytest.raises(OptionError, match="1 for 2 logs"):
        instrumental_information([log, log], [command], TorqueColumns(ARM.chain), 0.05)


@pytest.mark.slow
def test_on_the_command_line(files, lwr_dyn_command):
    log, e = files
    line = ("identify", "motion", "lwr4plus", log, "--reading", "physical", "--instruments", e)
    code, out, _ = lwr_dyn_command(*line, "--json")
    found = json.loads(out)
    assert code == 0
    assert found["validation"] == found["whiteness"] == []
    assert found["identified"] > 55  # least squares with the filter on this log: 51
    code, out, _ = lwr_dyn_command(*line)
    heads = [text.split(":")[0] for text in out.splitlines()]
    assert (code, heads.count("instrumental variables on unfiltered rows")) == (0, 1)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--instruments", "{e}", "--stribeck"), "without --instruments"),
        (("--instruments", "{e}", "--instruments", "{e}"), "2 for 1 logs"),
        (("--instruments", "nothing.csv"), "nothing.csv"),
    ],
)
def test_bad_input_is_one_line(files, lwr_dyn_command, more, message):
    log, e = files
    robot = ("lwr4plus", "--reading", "physical")
    code, _, err = lwr_dyn_command("identify", "motion", *robot, log, *(m.format(e=e) for m in more))
    assert code == 2
    assert message in err
    assert err.count("\n") - err.count("warning:") == 1


def test_parameters_from_a_ros_bag(plant, motion, tmp_path):
    """Recovery figure: joint states at 250 Hz in a bag of a ROS 2 robot, with the filter."""
    every = slice(None, None, 4)
    log = simulated_log(plant, motion, NOISE, np.random.default_rng(5), ENCODER)
    mixed = [6, 2, 0, 1, 3, 5, 4]  # drivers publish joints in any order
    fields = {"position": log.q[every][:, mixed], "effort": log.tau[every][:, mixed]}
    names = [ARM.joint_names[j] for j in mixed]
    bag = write_bag(tmp_path / "bag", [("/joint_states", names, log.t[every], fields)])
    result = identify_motion([read_log(bag, arm=ARM)], ARM)
    z = (result.information.values - plant.base) / result.information.sigma
    assert (np.abs(z) < 3.0).mean() > 0.97
    assert result.identified > 40
