"""The command with paths and numbers as arguments, the logs of `tests.identification`, a small arm with a log."""

from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.identification.logs.joint_log import read_log, write_log
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.conftest import fourier, one_joint_at_a_time, wam
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

__all__ = ["fourier", "one_joint_at_a_time", "wam"]


@pytest.fixture
def lwr_dyn_command(lwr_dyn_command):
    return lambda *arguments: lwr_dyn_command(*map(str, arguments))


@pytest.fixture(scope="session")
def two(tmp_path_factory):
    """A file of an arm of two joints, the arm, its paper, and logs of an arm 1 % off: 3 s with noise of 0.01 N m."""
    folder, rng = tmp_path_factory.mktemp("two"), np.random.default_rng(1)
    (folder / "two.toml").write_text(template("two.toml", "two", "RR"), encoding="utf-8")
    arm, paper = load_with_paper(folder / "two.toml")
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, 0.01)
    paths = [folder / name for name in ("log.csv", "other.csv")]
    for path in paths:
        write_log(path, simulated_log(plant, random_motion(arm, 3.0, rng, rate=100.0), 0.01, rng, encoder=1e-6))
    logs = [read_log(path, {}, arm) for path in paths]
    return SimpleNamespace(file=folder / "two.toml", arm=arm, paper=paper, paths=paths, logs=logs)
