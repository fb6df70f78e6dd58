"""The robot of a backup: its `$machine.dat` is taken where no other robot is given; a run without masses."""

import json
from dataclasses import replace

import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import run_program
from lwr_dyn.krl.writing.sampled_path import path_of_motion
from lwr_dyn.model.run import Run
from tests.krl.robot.test_machine_data import data

PROGRAM = """DEF move( )
BAS(#INITMOV, 0)
BAS(#VEL_PTP, 100)
PTP XHOME
PTP_REL {A1 105}
END
"""


@pytest.fixture
def backup(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ramps = {f"RAISE_TIME[{i}]": str(200.0 * i) for i in range(1, 8)}
    for name, text in {
        "cell/R1/Program/move.src": PROGRAM,
        "cell/R1/Mada/$machine.dat": data(**ramps),
        "cell/STEU/Mada/$machine.dat": "DEFDAT $MACHINE PUBLIC\nENDDAT\n",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


def test_the_program_runs_on_the_robot_of_its_backup(backup, lwr_dyn_command, recorded):
    line = ("krl", "run", "cell/R1/Program/move.src", "--with", "cell")
    code, out, err = lwr_dyn_command(*line, "--json", "--out", "a.npz")
    record = json.loads(out)
    assert (code, err, record["robot"]) == (0, "", "kr30ha")
    assert record["peak_torque"] == record["peak_static_torque"] == [None] * 6
    # A1: 4500 rev/min over 1800/7 is 105 deg/s, reached in 0.2 s
    assert record["cycle_time"] == pytest.approx(1.0 + 0.2)
    assert record["motions"][0]["q_deg"] == pytest.approx([0, -90, 90, 0, 0, 0])
    assert ["home", "A2 -90, A3 90, all others 0"] in [[x["name"], x["value"]] for x in record["assumptions"]]
    assert recorded(*line, "--ramp", "1")["cycle_time"] == pytest.approx(2.0)
    run = Run.load(backup / "a.npz")
    assert run.meta["unknown"] == ["torques", "energy", "work"]
    assert lwr_dyn_command("replay", "a.npz", "--html", "a.html")[0] == 0
    text = lwr_dyn_command(*line)[1]
    assert "$RAISE_TIME of its machine data: 0.2, 0.4, 0.6, 0.8, 1, 1.2 s to rated speed; masses unknown" in text


def test_another_robot_that_is_given_goes_first(backup, lwr_dyn_command, refused):
    line = ("krl", "run", "cell/R1/Program/move.src", "--with", "cell", "--json", "--robot")
    assert None not in json.loads(lwr_dyn_command(*line, "kr30ha")[1])["peak_torque"]
    assert "$SOFTN_END[1]: missing" in refused(*line, "cell/STEU/Mada/$machine.dat")


def test_ramps_of_each_axis_reach_the_motions(backup):
    arm = lwr_dyn.load(backup / "cell/R1/Mada/$machine.dat")
    program = parse_program(PROGRAM, name="move")
    times = [run_program(program, arm, MachineData(ramps=x)).cycle_time for x in ((), (0.1,) * 6, (0.5,) * 6)]
    assert times == pytest.approx([1.4, 1.1, 1.5])


def test_write_takes_the_robot_of_the_run_or_refuses_another(backup, lwr_dyn_command, printed, refused):
    lwr_dyn_command("krl", "run", "cell/R1/Program/move.src", "--with", "cell", "--out", "a.npz")
    assert "run on kr30ha: 1.200 s" in printed("krl", "write", "a.npz")
    # A1's ramp is 0.2 s on this robot, 0.4 s is assumed of the shipped one, which has the same name
    assert "a.npz: a run of another kr30ha: " in refused("krl", "write", "a.npz", "--robot", "kr30ha", "--out", "b.src")
    other = Run.load(backup / "a.npz")
    with pytest.raises(OptionError, match=r"a run of kr6; allowed: a run of kr30ha, or --robot kr6"):
        path_of_motion(replace(other, meta={"robot": "kr6"}), lwr_dyn.load("kr30ha"))


def test_an_unknown_robot_is_told_what_files_can_be_one(refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.src").write_text("DEF a( )\nEND\n")
    assert "a path to a .toml, .urdf, .kuka.toml or $machine.dat" in refused("krl", "run", "a.src", "--robot", "kr30")
