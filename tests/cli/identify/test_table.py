"""`lwr-dyn identify table`: what it prints of tables with and without slips, and of bad input."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

pytestmark = pytest.mark.slow

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Two logs of an arm 1 % off the LWR's physical table: encoders of 1e-5 rad, torque noise of 0.1 N m."""
    arm, rng = lwr_dyn.load("lwr4plus", "physical"), np.random.default_rng(1)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, 0.01)
    folder = tmp_path_factory.mktemp("logs")
    for k in (0, 1):
        motion = random_motion(arm, 12.0, rng, rate=500.0)
        write_log(folder / f"log{k}.csv", simulated_log(plant, motion, 0.1, rng, encoder=1e-5))
    return [str(folder / f"log{k}.csv") for k in (0, 1)]


def test_a_right_table_meets_the_logs(printed, logs: list[str]) -> None:
    out = printed("identify", "table", "lwr4plus", *logs, "--reading", "physical")
    assert out.startswith("the table meets the log")
    assert "one effect on all motions: I1yy = rotor1, m2 = c2z, I2yy = rotor2, c3z = c4y, c5z = c6y" in out
    assert "no motion shows: m1, c1x, c1y, c1z, I1xx, I1xy, I1xz, I1yz, I1zz, c2y" in out


def test_logs_of_an_arm_on_a_wall(lwr_dyn_command: Command, tmp_path: Path) -> None:
    """With --mount the table meets them; without, gravity pulls another way."""
    arm, rng = lwr_dyn.load("lwr4plus", "physical", mount="wall"), np.random.default_rng(2)
    plant = perturbed_plant(TorqueColumns(arm.chain), arm, rng, 0.01)
    log = simulated_log(plant, random_motion(arm, 12.0, rng, rate=500.0), 0.1, rng, encoder=1e-5)
    write_log(tmp_path / "wall.csv", log)
    line = ("identify", "table", "lwr4plus", str(tmp_path / "wall.csv"), "--reading", "physical")
    code, out, err = lwr_dyn_command(*line, "--mount", "wall")
    assert (code, out.startswith("the table meets the log")) == (0, True), err
    assert lwr_dyn_command(*line)[0] != 0


def test_a_table_with_a_copied_cell_is_named(lwr_dyn_command: Command, logs: list[str], tmp_path: Path) -> None:
    source = Path(lwr_dyn.__file__).parent / "arms" / "papers" / "lwr4plus.toml"
    text = source.read_text(encoding="utf-8")
    reading = text[text.index("[reading.physical]") :]
    without = reading.replace('"table2-c5z", ', "")
    assert without != reading
    (tmp_path / "arm.toml").write_text(text.replace(reading, without), encoding="utf-8")
    line = ("identify", "table", str(tmp_path / "arm.toml"), *logs, "--reading", "physical")
    code, out, _ = lwr_dyn_command(*line, "--deviation", "2%")
    assert code == 1
    assert "it does with 1 repair:\n- c5z = -0.02" in out
    assert "which repeats c6z (erratum table2-c5z)\n  or c6y = " in out
    code, out, _ = lwr_dyn_command(*line, "--deviation", "0.02", "--json")
    record = json.loads(out)
    assert code == 1
    assert {c for e in record["explanations"] for r in e["repairs"] for c in r["cells"]} == {"c5z", "c6y"}
    assert record["deviation"] == 0.02
    assert len(record["cells"]) == 77


def test_a_urdf_has_cells_too(printed, logs: list[str], tmp_path: Path) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(lwr_dyn.urdf_text(lwr_dyn.load("lwr4plus", "physical")), encoding="utf-8")
    assert "c5z" in printed("identify", "table", str(urdf), *logs)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ("lwr4plus", "--deviation", "much"),
            "'--deviation': 'much' is not a share; allowed: a number such as 5% or 0.05",
        ),
        (("lwr4plus", "--deviation", "120%"), "deviation: 1.2"),
        (("lwr4",), "no mass"),
        (("wam7",), ""),
        (("lwr4plus", "--lock", "joint_3=0"), "--lock: given, which changes the arm; allowed: the arm as its table"),
        (("lwr4plus", "--tool", "mass=1"), "--tool: given, which changes the arm; allowed: the arm as its table"),
    ],
)
def test_bad_input_is_one_line(refused, logs: list[str], options: tuple[str, ...], said: str) -> None:
    file = "missing.csv" if options == ("wam7",) else logs[0]
    assert said in refused("identify", "table", options[0], file, *options[1:])
