"""The study of taught points, on a backup whose points our own arm wrote, one of them with another Turn."""

from collections import Counter

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.krl.project.program import load_project
from lwr_dyn.krl.robot.kuka_pose import kuka_pose, pose_of_matrix
from scripts.studies.krl_taught_points import AWAY, FITS, LEFT_OUT, OTHER_STATUS, OTHER_TURN, taught_points
from tests.krl.robot.test_machine_data import data

TOOL = "{X 10.0,Y 20.0,Z 300.0,A 0.0,B 90.0,C 0.0}"
T_TOOL = np.array([[0, 0, 1, 0.01], [0, 1, 0, 0.02], [-1, 0, 0, 0.3], [0, 0, 0, 1.0]])


def point(arm, q, s=0, t=0, x=0.0):
    """A point of the tool at the axes; `s` and `t` change its Status and Turn, `x` moves it [mm]."""
    flange, p = kuka_pose(arm, q), pose_of_matrix(lwr_dyn.forward_kinematics(arm, q) @ T_TOOL)
    numbers = zip("XYZABC", (p.x_mm + x, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg), strict=True)
    return ",".join([*(f"{k} {v:.6f}" for k, v in numbers), f"S {flange.s ^ s}", f"T {flange.t ^ t}"])


@pytest.fixture
def backup(tmp_path):
    def write(name, *lines):
        path = tmp_path / "R1" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join([f"DEFDAT {path.stem}", *lines, "ENDDAT", ""]))
        return path

    machine = write("Mada/$machine.dat")
    machine.write_text(data())
    write("System/$config.dat", "DECL FRAME TOOL_DATA[16]", "DECL FRAME BASE_DATA[32]", f"TOOL_DATA[1]={TOOL}")
    arm = lwr_dyn.load(machine)
    frame = "={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}"
    rng = np.random.default_rng(5)
    axes = rng.uniform(0.5 * arm.lower, 0.5 * arm.upper, (8, 6))
    good = [f"DECL E6POS XP{i}={{{point(arm, q)}}}\nDECL FDAT FP{i}{frame}" for i, q in enumerate(axes)]
    q = np.radians([10, -60, 70, 20, 50, 30])
    changed = {"T": point(arm, q, t=1), "S": point(arm, q, s=1), "A": point(arm, q, x=9000.0)}
    bad = [f"DECL E6POS X{k}={{{x}}}\nDECL FDAT F{k}{frame}" for k, x in changed.items()]
    write("Program/a.dat", *good, *bad, "DECL E6POS XN={X 1,Y 2,Z 3,A 0,B 0,C 0}", f"DECL FDAT FN{frame}")
    write("Program/b.dat", good[0])
    return tmp_path


def test_points_of_our_own_arm_fit_and_changed_ones_do_not(backup):
    verdicts = taught_points(load_project(backup))
    expected = {FITS: 8, OTHER_TURN: 1, OTHER_STATUS: 1, AWAY: 1, LEFT_OUT: 1}
    assert Counter(verdicts.values()) == expected
    assert [name.split()[-1] for (name, _), verdict in verdicts.items() if verdict == OTHER_TURN] == ["XT"]
