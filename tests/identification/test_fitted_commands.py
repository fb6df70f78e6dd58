"""Every command takes a fitted arm; a share of the count of such models."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.cli.main import main
from lwr_dyn.identification.fitted import write_fitted
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.model_study import study
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

pytestmark = pytest.mark.slow

NOISE = 0.1


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With moves.csv, arm.toml and arm.urdf."""
    place = tmp_path_factory.mktemp("fitted")
    arm, paper = load_with_paper("lwr4plus", "physical")
    rng = np.random.default_rng(1)
    plant = perturbed_plant(TorqueColumns(arm.chain, "directions"), arm, rng)
    log = simulated_log(plant, random_motion(arm, 8.0, rng, rate=250.0), NOISE, rng, 1e-5, str(place / "moves.csv"))
    write_log(log.source, log)
    result = identify_motion([log], arm)
    write_fitted(place / "arm.toml", result, paper)
    write_fitted(place / "arm.urdf", result, paper)
    return place


def run(*arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    return stop.value.code


HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")


@pytest.mark.parametrize(
    "line",
    [
        ("check", "arm.toml"),
        ("check", "arm.urdf"),
        ("lint", "arm.toml"),
        ("simulate", "arm.toml", *HOLD),
        ("simulate", "arm.urdf", *HOLD),
        ("urdf", "arm.toml", "--out", "from_toml.urdf"),
        ("sensitivity", "arm.toml", "arm.urdf", "--task", "joint-move", "--rate", "100", "--poses", "5"),
    ],
    ids=lambda line: " ".join(line[:2]),
)
def test_commands_take_it(line, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert run(*line) == 0
    assert capsys.readouterr().out


def test_identify_motion_writes_it(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    common = ("identify", "motion", "moves.csv", "--robot", "lwr4plus", "--reading", "physical", "--out")
    assert run(*common, "out.toml") == 0
    assert "wrote out.toml; next: lwr-dyn check out.toml" in capsys.readouterr().out
    assert lwr_dyn.load("out.toml").reading == "fitted"
    assert run("identify", "motion", "moves.csv", "--robot", "lwr4", "--out", "bare.toml") == 2
    assert "masses and inertias" in capsys.readouterr().err
    assert run(*common, "none/out.toml") == 2
    assert run(*common, "out.sdf") == 2
    assert "out.sdf: ends in '.sdf'; allowed: a path in .toml or .urdf" in capsys.readouterr().err


@pytest.mark.parametrize(("robot", "reading"), [("lwr4plus", "physical"), ("wam7", None)])
def test_a_share_of_the_count_of_models(robot, reading, tmp_path):
    """`scripts/soak.py fitted_models` takes 60 plants of each."""
    arm, paper = load_with_paper(robot, reading)
    case = study(arm, paper, 7, 6.0, 200.0, NOISE, tmp_path)
    assert case.off < 1e-11
    assert case.physical
    assert case.seen < case.unseen < 1.6
    assert np.abs(case.promises - 1.0).max() < 0.15


def test_a_drawn_arm_whose_masses_are_estimates(tmp_path):
    """The KR 30 HA: solids, a mastering pose, no rotors; its base's mass was what the estimated links left."""
    arm, paper = load_with_paper("kr30ha")
    case = study(arm, paper, 3, 4.0, 200.0, NOISE, tmp_path)
    assert case.off < 1e-11
    fitted = lwr_dyn.load(tmp_path / "arm.toml")
    assert fitted.drawing == arm.drawing
    assert fitted.mastering == arm.mastering
    assert fitted.ratings.base_mass is None
    assert run("check", tmp_path / "arm.toml") == 0
