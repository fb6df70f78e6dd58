"""`lwr-dyn krl run`: what is unknown is said, and what is printed agrees with what is recorded."""

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


def test_files_are_refused_before_the_run_by_their_endings(refused, folder):
    (folder / "a.src").write_text(PROGRAM)
    for option, name, ending in (("--out", "a.html", ".npz"), ("--html", "a.npz", ".html")):
        assert f"a path that ends in {ending}" in refused("krl", "run", "a.src", option, name)
    assert sorted(x.name for x in folder.iterdir()) == ["a.src"]
