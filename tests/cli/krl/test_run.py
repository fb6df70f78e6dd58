"""`lwr-dyn krl run`: what is unknown is said, and what is printed agrees with what is recorded."""

import numpy as np
import pytest

import lwr_dyn
from tests.json_schemas import faults

PROGRAM = """DEF a( )
BAS(#INITMOV, 0)
PTP {A1 0, A2 -90, A3 90, A4 0, A5 60, A6 0}
LIN_REL {Z -100}
$OUT[2] = TRUE
END
"""
SMALL = """name = "small"
TIRORO = { Z = 400 }
LENGTH_A = 25
LENGTH_B = 450
TX3P3 = { X = 420, Z = 35 }
TFLWP = { Z = 80 }
SOFTN_END = [-170, -190, -120, -185, -120, -350]
SOFTP_END = [170, 45, 156, 185, 120, 350]
speed = [360, 300, 360, 380, 390, 615]
"""


def test_torques_of_unknown_masses_are_null_and_a_dash(lwr_dyn_command, recorded, folder):
    (folder / "a.src").write_text(PROGRAM)
    (folder / "small.kuka.toml").write_text(SMALL)
    line = "krl", "run", "a.src", "--robot", "small.kuka.toml"
    record = recorded(*line)
    assert faults("krl run", record) == []
    assert record["peak_torque"] == record["peak_static_torque"] == [None] * 6
    code, out, _ = lwr_dyn_command(*line, "--out", "a.npz")
    rows = [row.split() for row in out.splitlines()]
    axes = [row for row in rows if len(row) == 5 and row[0] in {f"A{i}" for i in range(1, 7)}]
    assert (code, [row[3:] for row in axes]) == (0, [["-", "-"]] * 6)
    assert [float(row[1]) for row in axes] == [round(x, 1) for x in record["peak_speed_deg"]]
    assert rows[-1] == ["wrote", "a.npz"]


def test_a_motion_has_the_flange_at_its_end(lwr_dyn_command, recorded, folder):
    (folder / "a.src").write_text(PROGRAM)
    record = recorded("krl", "run", "a.src")
    first, second = record["motions"]
    assert (first["line"], second["line"], second["motion"]) == (3, 4, "LIN_REL")
    assert [round(b - a, 6) + 0.0 for a, b in zip(first["flange"], second["flange"], strict=True)][:3] == [0, 0, -100]
    assert (second["begin"], second["end"]) == (first["end"], record["duration"])
    assert record["cycle_time"] == record["duration"]
    assert [(x["line"], x["kind"], x["text"]) for x in record["events"]] == [(5, "output", "$OUT[2] = TRUE")]
    shown = lwr_dyn_command("krl", "run", "a.src")[1]
    assert f"a.src on kr30ha: {record['duration']:.3f} s\n" in shown
    assert "-0.00" not in shown


FRAMES = """DEF a( )
BAS(#INITMOV, 0)
$VEL.CP = 0.1
PTP {A1 0, A2 -90, A3 90, A4 0, A5 60, A6 0}
$TOOL = {X 0, Y 0, Z 200, A 0, B 0, C 0}
$BASE = {X 900, Y -300, Z 500, A 90, B 0, C 0}
LIN_REL {X 50}
END
"""


def test_poses_are_those_of_the_tool_in_the_active_base(lwr_dyn_command, recorded, folder):
    (folder / "a.src").write_text(FRAMES)
    first, second = recorded("krl", "run", "a.src")["motions"]
    assert first["tcp"] == first["flange"]  # no tool and no base yet
    # at B = 120 deg of the flange's z-axis: 200 mm along it, in a base that is turned by 90 deg about Z
    x, y, z = np.array(second["flange"][:3]) - [900, -300, 500] + 200 * kuka_axis(second["flange"][3:])
    assert second["tcp"][:3] == pytest.approx([y, -x, z], abs=1e-6)
    shown, flange = (lwr_dyn_command("krl", "run", "a.src", *more)[1] for more in ((), ("--flange",)))
    assert "X to C: the tool centre point in the active base" in shown
    assert f"{second['tcp'][0]:.3f}" in shown
    assert "X to C: the flange in the world" in flange
    assert f"{second['flange'][0]:.3f}" in flange


def kuka_axis(abc):
    """The z-axis of a frame of KUKA's A, B, C [deg]: Rz(A) Ry(B) Rx(C) z."""
    a, b, c = np.radians(abc)
    return np.array([
        np.cos(a) * np.sin(b) * np.cos(c) + np.sin(a) * np.sin(c),
        np.sin(a) * np.sin(b) * np.cos(c) - np.cos(a) * np.sin(c),
        np.cos(b) * np.cos(c),
    ])  # fmt: skip


def test_an_assumed_ramp_is_shown_with_what_others_would_make_of_it(lwr_dyn_command, recorded, folder):
    (folder / "a.src").write_text(PROGRAM.replace("END", "PTP {A1 20}\nEND"))
    record = recorded("krl", "run", "a.src")
    for other in record["other_ramps"]:
        given = recorded("krl", "run", "a.src", "--ramp", str(other["ramp"]))
        assert given["other_ramps"] == []
        assert given["duration"] == other["duration"] < record["duration"]
        assert f"{other['duration']:.3f} s with {other['ramp']:g}" in lwr_dyn_command("krl", "run", "a.src")[1]
    assert [x["ramp"] for x in record["other_ramps"]] == [0.1, 0.2]


def test_files_are_refused_before_the_run_by_their_endings(refused, folder):
    (folder / "a.src").write_text(PROGRAM)
    for option, name, ending in (("--out", "a.html", ".npz"), ("--html", "a.npz", ".html")):
        assert f"a path that ends in {ending}" in refused("krl", "run", "a.src", option, name)
    assert sorted(x.name for x in folder.iterdir()) == ["a.src"]


def test_the_run_and_its_page_are_written(lwr_dyn_command, folder):
    (folder / "a.src").write_text(PROGRAM)
    assert lwr_dyn_command("krl", "run", "a.src", "--out", "a.npz", "--html", "a.html")[0] == 0
    assert sorted(x.name for x in folder.iterdir()) == ["a.html", "a.npz", "a.src"]
    assert "LIN_REL {Z -100}" in (folder / "a.html").read_text(encoding="utf-8")
    run = lwr_dyn.Run.load("a.npz")
    assert np.degrees(run.q[0]) == pytest.approx([0, -90, 90, 0, 60, 0], abs=1e-6)
