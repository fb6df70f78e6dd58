"""Stiffness, damping, rotors, friction and links from logs with both encoders."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.identification.elastic_joints import elastic_document, identify_elastic
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.transmission import JointElasticity
from tests.identification.elastic_plants import elastic_log, elastic_truth
from tests.identification.plants import perturbed_plant, random_motion
from tests.json_schemas import faults

ARM = lwr_dyn.load("lwr4plus", "physical")
GEARS = ARM.elasticity
ZERO = np.array([0.01, -0.02, 0.005, 0.0, 0.001, 0.002, -0.003])


@pytest.fixture(scope="module")
def plant():
    return perturbed_plant(TorqueColumns(ARM.chain), ARM, np.random.default_rng(1), 0.2)


@pytest.fixture(scope="module")
def logs(plant):
    """Two recordings of 10 s at 1 kHz: torques 0.1 N m, encoders 1e-5 rad."""
    rng = np.random.default_rng(2)
    return [
        elastic_log(plant, GEARS, random_motion(ARM, 10.0, rng, rate=1000.0), 0.1, rng, 1e-5, ZERO) for _ in range(2)
    ]


@pytest.mark.slow
def test_all_parameters_are_recovered_within_their_errors(plant, logs):
    """Recovery figure: every z within 4.5, their mean square 1, the six stiffnesses that bend within 1 per cent."""
    found = identify_elastic(logs, ARM)
    z = (found.values - elastic_truth(plant, GEARS, found.base, ZERO)) / found.sigma
    assert np.abs(z).max() < 4.5
    assert 0.6 < np.mean(z**2) < 1.5
    bends = found.of("stiffness", sigma=True) < 0.03 * GEARS.stiffness
    assert bends[:5].all()
    assert np.abs(found.of("stiffness") / GEARS.stiffness - 1.0)[:5].max() < 0.01
    assert found.noise[:7] == pytest.approx(0.1, rel=0.15)


def test_without_noise_stiffness_is_exact_to_a_part_in_ten_thousand(plant):
    motion = random_motion(ARM, 8.0, np.random.default_rng(3), rate=1000.0)
    log = elastic_log(plant, GEARS, motion, 0.0, np.random.default_rng(0), 0.0)
    found = identify_elastic([log], ARM)
    assert np.abs(found.of("stiffness") / GEARS.stiffness - 1.0).max() < 1e-4
    assert np.abs(found.of("damping") / GEARS.damping - 1.0).max() < 0.03
    assert np.abs(found.of("armature") / plant.parameters[plant.columns.rotor_indices] - 1.0).max() < 1e-3
    truth = elastic_truth(plant, GEARS, found.base)
    for k, name in enumerate(("coulomb", "viscous", "offset")):
        at = [found.names.index(f"{name}_{j}") for j in range(1, 8)]
        assert found.of(name) == pytest.approx(truth[at], abs=5e-3)
        of_models = [(m.positive.coulomb, m.positive.viscous, m.offset)[k] for m in found.friction]
        assert of_models == pytest.approx(found.of(name))
    assert found.links == pytest.approx(truth[: found.base.count], abs=5e-3)


def test_least_squares_would_take_noise_for_the_spring(logs):
    """The law behind the instruments: a wrist that bends by its encoder's noise still has an unbiased stiffness.

    The result is an elasticity that a simulation takes.
    """
    found = identify_elastic(logs, ARM)
    off = np.abs(found.of("stiffness") - GEARS.stiffness) / found.of("stiffness", sigma=True)
    assert off.max() < 4.0
    assert found.of("stiffness")[5:].min() > 0.0
    gears = found.elasticity(otherwise=GEARS)
    assert isinstance(gears, JointElasticity)
    assert (gears.damping >= 0.0).all()


def test_logs_without_motor_positions_and_joints_that_never_move_are_refused(logs):
    q, theta = logs[0].q.copy(), logs[0].motor_q.copy()
    q[:, 2], theta[:, 2] = 0.3, 0.3
    for change, words in (({"motor_q": None}, "qm1"), ({"q": q, "motor_q": theta}, "does not determine")):
        with pytest.raises(LogError, match=words):
            identify_elastic([replace(logs[0], **change)], ARM)


def test_a_joint_that_does_not_bend_is_named_and_takes_another_value(plant):
    rng = np.random.default_rng(5)
    short = elastic_log(plant, GEARS, random_motion(ARM, 3.0, rng, rate=1000.0), 0.3, rng, 5e-5)
    found = identify_elastic([short], ARM)
    assert not found.bends.all()
    joint = int(np.argmin(found.bends)) + 1
    document = elastic_document(found, ARM, "mine")
    assert f"stiffness of joint {joint} not identified" in document.text()
    assert (document.record()["robot"], document.record()["equations"]) == ("mine", found.equations)
    record = json.loads(json_text({"caveats": [], **document.record()}))
    assert faults("identify elastic", record) == []
    for j, row in enumerate(record["joints"]):
        noise = found.noise[j], found.noise[7 + j]
        assert [row[x] for x in ("joint", "bends", "torque_noise", "gear_noise")] == [j + 1, found.bends[j], *noise]
        for name, one in row["parameters"].items():
            assert (one["value"], one["standard_error"]) == (found.of(name)[j], found.of(name, sigma=True)[j])
    units = {name: one["unit"] for name, one in record["joints"][0]["parameters"].items()}
    assert (units["armature"], units["stiffness"], units["damping"]) == ("kg m^2", "N m/rad", "N m s/rad")
    rows = zip(found.base.statements(), found.links, found.sigma, strict=False)
    assert [tuple(row.values()) for row in record["links"]] == [*rows]
    lines = document.text().splitlines()
    count = f"{len(found.values)} parameters from {found.equations} equations, {found.base.count} of them the links'"
    assert lines[0] == count
    shown = lines[next(k for k, line in enumerate(lines) if line.startswith("1 ") or line.startswith("1  "))].split()
    assert float(shown[1]) == pytest.approx(found.of("stiffness")[0], rel=1e-3)
    with pytest.raises(OptionError, match=f"stiffness of joint {joint}"):
        found.elasticity()
    gears, own = found.elasticity(otherwise=GEARS), np.maximum(found.of("damping"), 0.0)
    assert gears.stiffness.tolist() == np.where(found.bends, found.of("stiffness"), GEARS.stiffness).tolist()
    assert gears.damping.tolist() == np.where(found.bends, own, GEARS.damping).tolist()


@pytest.mark.slow
def test_the_command_prints_a_row_a_joint(logs, tmp_path, lwr_dyn_command):
    path = tmp_path / "both.csv"
    line = ("identify", "elastic", "lwr4plus", str(path), "--reading", "physical")
    write_log(path, logs[0])
    code, out, err = lwr_dyn_command(*line)
    assert (code, err, [row.split()[0] for row in out.splitlines()[3:10]]) == (0, "", list("1234567"))
    write_log(path, replace(logs[0], motor_q=None))
    code, out, err = lwr_dyn_command(*line)
    assert (code, out, err.count("\n"), "qm1" in err) == (2, "", 1, True)
