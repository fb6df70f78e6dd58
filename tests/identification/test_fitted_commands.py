"""Every command takes a fitted arm; a share of the count of such models."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.identification.fitted_files import write_fitted
from tests.identification.model_study import study
from tests.identification.test_fitted import NOISE, fit

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With moves.csv, arm.toml and arm.urdf."""
    place = tmp_path_factory.mktemp("fitted")
    result, paper = fit("lwr4plus", "physical", place)
    write_fitted(place / "arm.toml", result, paper)
    write_fitted(place / "arm.urdf", result, paper)
    return place


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
def test_commands_take_it(line, folder, monkeypatch, lwr_dyn_command):
    monkeypatch.chdir(folder)
    code, out, _ = lwr_dyn_command(*line)
    assert (code, bool(out)) == (0, True)


def test_identify_motion_writes_it(folder, monkeypatch, lwr_dyn_command):
    monkeypatch.chdir(folder)
    common = ("identify", "motion", "lwr4plus", "moves.csv", "--reading", "physical", "--out")
    code, out, _ = lwr_dyn_command(*common, "out.toml")
    assert code == 0
    assert "wrote out.toml; next: lwr-dyn check out.toml" in out
    assert lwr_dyn.load("out.toml").reading == "fitted"
    code, _, err = lwr_dyn_command("identify", "motion", "lwr4", "moves.csv", "--out", "bare.toml")
    assert code == 2
    assert "masses and inertias" in err
    assert lwr_dyn_command(*common, "none/out.toml")[0] == 2
    code, _, err = lwr_dyn_command(*common, "out.sdf")
    assert code == 2
    assert "out.sdf: ends in '.sdf'; allowed: a path in .toml or .urdf" in err


@pytest.mark.parametrize(("robot", "reading"), [("lwr4plus", "physical"), ("wam7", None)])
def test_a_share_of_the_count_of_models(robot, reading, tmp_path):
    """`scripts/soak.py fitted_models` takes 60 plants of each."""
    arm, paper = load_with_paper(robot, reading)
    case = study(arm, paper, 7, 6.0, 200.0, NOISE, tmp_path)
    assert case.off < 1e-11
    assert case.physical
    assert case.seen < case.unseen < 1.6
    assert np.abs(case.promises - 1.0).max() < 0.15


def test_a_drawn_arm_whose_masses_are_estimates(tmp_path, lwr_dyn_command):
    """The KR 30 HA: solids, a mastering pose, no rotors; its base's mass was what the estimated links left."""
    arm, paper = load_with_paper("kr30ha")
    case = study(arm, paper, 3, 4.0, 200.0, NOISE, tmp_path)
    assert case.off < 1e-11
    fitted = lwr_dyn.load(tmp_path / "arm.toml")
    assert fitted.drawing == arm.drawing
    assert fitted.mastering == arm.mastering
    assert fitted.ratings.base_mass is None
    assert lwr_dyn_command("check", str(tmp_path / "arm.toml"))[0] == 0
