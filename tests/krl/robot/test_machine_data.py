"""A robot from its machine data, also of a backup: robots that count or stand otherwise; one line for wrong data."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, OptionError, PaperError, UnknownNameError
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.robot.kuka_pose import has_kuka_axes, kuka_pose
from lwr_dyn.krl.robot.machine_data import MachineWords, load_machine_arm
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import run_program
from lwr_dyn.krl.writing.sampled_path import path_of_motion
from lwr_dyn.model.run import Run

RATIOS = {1: (1800, 7), 2: (2000, 11), 3: (1500, 7), 4: (1000, 7), 5: (800, 7), 6: (700, 11)}


def data(**changes):
    """Machine data with the lengths of the KR 30 HA; ratios and speeds are invented."""
    zero = "A 0.0,B 0.0,C 0.0}"
    given = {
        "TRAFONAME[]": '"#KR30HA"', "TIRORO": f"{{X 0.0,Y 0.0,Z 815.0,{zero}", "TFLWP": f"{{X 0.0,Y 0.0,Z 170.0,{zero}",
        "TX3P3": "{X 820.0,Y 0.0,Z 145.0,A 0.0,B 90.0,C 0.0}", "LENGTH_A": "350.0", "LENGTH_B": "850.0",
        "DH_4": "{DHART_A 0.0,DHART_D 0.0,DHART_ALPHA 90.0}", "DH_5": "{DHART_A 0.0,DHART_D 0.0,DHART_ALPHA -90.0}",
        "MAIN_AXIS": "#NR", "WRIST_AXIS": "#ZEH", "TRAFO_AXIS": "6",
    }  # fmt: skip
    lists = {
        "AXIS_DIR": [-1, 1, 1, -1, -1, -1, 0], "SOFTN_END": [-185, -135, -120, -350, -119, -350, 0],
        "SOFTP_END": [185, 35, 158, 350, 119, 350, 0], "VEL_AXIS_MA": [4500.0] * 6 + [0.0],
        "RAT_MOT_AX": [f"{{N -{n},D {d}}}" for n, d in RATIOS.values()],
    }  # fmt: skip
    given |= {f"{key}[{i}]": str(x) for key, values in lists.items() for i, x in enumerate(values, 1)}
    given |= changes
    lines = [f"REAL ${key}={x}" if "[" not in key else f"${key}={x}" for key, x in given.items() if x]
    return "\n".join(["DEFDAT $MACHINE PUBLIC", *lines, "ENDDAT", ""])


@pytest.fixture
def written(tmp_path):
    def write(**changes):
        path = tmp_path / "$machine.dat"
        path.write_text(data(**changes))
        return path

    return write


def test_the_machine_data_of_the_kr_30_are_the_paper_s_arm(written):
    arm, paper = lwr_dyn.load(written()), lwr_dyn.load("kr30ha")
    assert has_kuka_axes(arm)
    for q in np.random.default_rng(3).uniform(-3, 3, (20, 6)):
        np.testing.assert_allclose(lwr_dyn.forward_kinematics(arm, q), lwr_dyn.forward_kinematics(paper, q), atol=1e-14)
        assert kuka_pose(arm, q).s == kuka_pose(paper, q).s
    np.testing.assert_allclose(arm.lower, paper.lower, atol=1e-15)
    np.testing.assert_allclose(arm.upper, paper.upper, atol=1e-15)
    assert np.degrees(arm.velocity) == pytest.approx([4500 / 60 * d / n * 360 for n, d in RATIOS.values()])
    assert arm.chain.bodies is None
    words = MachineWords(written())
    lines = written().read_text(encoding="utf-8").splitlines()
    assert words.place("LENGTH_A") == f"$machine.dat, to line {lines.index('REAL $LENGTH_A=350.0') + 1}"
    assert words.place("SOFTN_END") == f"$machine.dat, to line {lines.index('$SOFTN_END[7]=0') + 1}"
    assert words.place("ANOTHER") == "$machine.dat"


Q = np.array([0.3, -1.2, 1.4, 0.2, 0.5, -0.1])


def test_a_robot_that_turns_the_other_way_or_hangs_reads_the_same_axes(written):
    plain = lwr_dyn.load(written())
    other = lwr_dyn.load(written(**{"AXIS_DIR[1]": "1"}))
    T = lwr_dyn.forward_kinematics(plain, Q)
    np.testing.assert_allclose(lwr_dyn.forward_kinematics(other, Q * [-1, 1, 1, 1, 1, 1]), T, atol=1e-14)
    hanging = lwr_dyn.load(written(ROBROOT="{X 100.0,Y 0.0,Z 3000.0,A 0.0,B 0.0,C 180.0}"))
    assert [has_kuka_axes(x) for x in (other, hanging)] == [False, True]
    assert kuka_pose(hanging, Q).s == kuka_pose(plain, Q).s
    assert lwr_dyn.forward_kinematics(hanging, Q)[2, 3] == pytest.approx(3.0 - T[2, 3])
    behind = np.radians([0, -170, 30, 0, 20, 0])
    assert [kuka_pose(x, behind).s & 1 for x in (plain, hanging)] == [1, 1]


def test_the_toml_form_is_the_same_robot(written, tmp_path):
    path = tmp_path / "kr30.kuka.toml"
    path.write_text(TOML)
    arm, of_data = lwr_dyn.load(path), lwr_dyn.load(written())
    np.testing.assert_allclose(lwr_dyn.forward_kinematics(arm, Q), lwr_dyn.forward_kinematics(of_data, Q), atol=1e-14)
    assert np.degrees(arm.velocity) == pytest.approx([140, 126, 140, 260, 245, 322])
    assert MachineWords(path).raise_time() == (0.4, 0.5, 0.4, 0.3, 0.3, 0.2)
    for text, words in ((TOML.replace("LENGTH_A", "LENGHT_A"), "LENGTH_A: missing"),
                        (TOML + "colour = 1\n", "colour: unknown field")):  # fmt: skip
        path.write_text(text)
        with pytest.raises(PaperError, match=words):
            lwr_dyn.load(path)


TOML = """
name = "KR 30 HA"
TIRORO = { Z = 815 }
LENGTH_A = 350
LENGTH_B = 850
TX3P3 = { X = 820, Z = 145 }
TFLWP = { Z = 170 }
SOFTN_END = [-185, -135, -120, -350, -119, -350]
SOFTP_END = [185, 35, 158, 350, 119, 350]
RAISE_TIME = [400, 500, 400, 300, 300, 200]
speed = [140, 126, 140, 260, 245, 322]
"""


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"LENGTH_A": ""}, r"\$LENGTH_A: missing; allowed: a finite number"),
        ({"LENGTH_A": "TRUE"}, r"\$LENGTH_A: True"),
        ({"MAIN_AXIS": "#SS"}, r"\$MAIN_AXIS: 'SS'; allowed: NR: other robots are not modelled"),
        ({"SOFTN_END[2]": ""}, r"\$SOFTN_END\[2\]: missing"),
        ({"SOFTN_END[2]": "40"}, r"allowed: less than \$SOFTP_END"),
        ({"AXIS_DIR[3]": "0"}, r"\$AXIS_DIR"),
        ({"RAT_MOT_AX[1]": "{N 0,D 1}"}, r"\$RAT_MOT_AX\[1\]: 0 to 1; allowed: a ratio that is not zero"),
        ({"RAT_MOT_AX[1]": "{N 1E-323,D 7}"}, r"\$RAT_MOT_AX\[1\]: .* to 7; allowed: a ratio that is not zero"),
        ({"TX3P3": "{X 820.0,Q 1.0}"}, r"\$TX3P3: .*; allowed: X, Y, Z, A, B, C"),
        ({"VEL_AXIS_MA[1]": "-1.0"}, "speed of the axes"),
    ],
)
def test_wrong_machine_data_are_one_line(written, change, message):
    with pytest.raises(PaperError, match=message) as caught:
        load_machine_arm(written(**change))
    assert "\n" not in str(caught.value)
    with pytest.raises(UnknownNameError):
        lwr_dyn.load(written(), reading="printed")
    with pytest.raises(FileAccessError):
        lwr_dyn.load("none.dat")


PROGRAM = "DEF move( )\nBAS(#INITMOV, 0)\nBAS(#VEL_PTP, 100)\nPTP XHOME\nPTP_REL {A1 105}\nEND\n"
IN_CELL = ("cell/R1/Program/move.src", "--with", "cell")


@pytest.fixture
def backup(folder):
    ramps = {f"RAISE_TIME[{i}]": str(200.0 * i) for i in range(1, 8)}
    for name, text in {
        "cell/R1/Program/move.src": PROGRAM,
        "cell/R1/Mada/$machine.dat": data(**ramps),
        "cell/STEU/Mada/$machine.dat": "DEFDAT $MACHINE PUBLIC\nENDDAT\n",
    }.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_the_program_runs_on_the_robot_of_its_backup(backup, lwr_dyn_command, recorded):
    line = ("krl", "run", *IN_CELL)
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


def test_the_programs_of_a_palletizer_are_checked_as_language(backup, lwr_dyn_command, refused):
    (backup / "cell/R1/Mada/$machine.dat").write_text(data(DEF_A4FIX="TRUE"))
    (backup / "cell/R1/Program/move.src").write_text(PROGRAM.replace("END", "WAIT SEC nothing\nEND"))
    code, out, _ = lwr_dyn_command("krl", "check", *IN_CELL)
    assert code == 1
    assert "motions are not checked: " in out
    assert "$DEF_A4FIX: True; allowed: False: other robots are not modelled" in out
    assert "error undeclared: nothing is not declared" in out
    assert "$DEF_A4FIX" in refused("krl", "check", *IN_CELL, "--robot", "cell/R1/Mada/$machine.dat")


def test_another_robot_that_is_given_goes_first_and_an_unknown_one_is_told_what_files_can_be_one(
    backup, lwr_dyn_command, refused
):
    line = ("krl", "run", *IN_CELL, "--json", "--robot")
    assert None not in json.loads(lwr_dyn_command(*line, "kr30ha")[1])["peak_torque"]
    assert "$SOFTN_END[1]: missing" in refused(*line, "cell/STEU/Mada/$machine.dat")
    assert "a path to a .toml, .urdf, .xml (MJCF), .kuka.toml or $machine.dat" in refused(*line, "kr30")


def test_ramps_of_each_axis_reach_the_motions(backup):
    arm = lwr_dyn.load(backup / "cell/R1/Mada/$machine.dat")
    program = parse_program(PROGRAM, name="move")
    times = [run_program(program, arm, MachineData(ramps=x)).cycle_time for x in ((), (0.1,) * 6, (0.5,) * 6)]
    assert times == pytest.approx([1.4, 1.1, 1.5])


def test_write_takes_the_robot_of_the_run_or_refuses_another(backup, lwr_dyn_command, printed, refused):
    lwr_dyn_command("krl", "run", *IN_CELL, "--out", "a.npz")
    assert "run on kr30ha: 1.200 s" in printed("krl", "write", "a.npz")
    # A1's ramp is 0.2 s on this robot, 0.4 s is assumed of the shipped one, which has the same name
    assert "a.npz: a run of another kr30ha: " in refused("krl", "write", "a.npz", "--robot", "kr30ha", "--out", "b.src")
    other = Run.load(backup / "a.npz")
    with pytest.raises(OptionError, match=r"a run of kr6; allowed: a run of kr30ha, or --robot kr6"):
        path_of_motion(replace(other, meta={"robot": "kr6"}), lwr_dyn.load("kr30ha"))
