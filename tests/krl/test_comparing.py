"""`krl diff`: points moved by how much, values, logic, configuration; layout, comments and case do not count."""

import json
import math

import pytest

from lwr_dyn.krl.comparing import compare, meaning_of
from tests.json_schemas import faults

SRC = (
    "DEF work( )\n; a comment\nDECL INT i\nPTP HOME\nFOR i = 1 TO 3\n  LIN P1 C_DIS\nENDFOR\n$OUT[3] = TRUE\nEND\n"
    'DEF other( )\nmsg("Go")\nEND\n'
)
DAT = (
    "DEFDAT work\n"
    "DECL E6POS P1={X 1000.0,Y 0.0,Z 500.0,A 0.0,B 90.0,C 0.0,S 2,T 10,E1 0.0}\n"
    "DECL E6AXIS HOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n"
    "DECL INT n=3\nDECL REAL speed=1.50\nENDDAT\n"
)
CONFIG = "DEFDAT $CONFIG\nTOOL_DATA[1]={X 0.0,Y 0.0,Z 100.0,A 0.0,B 0.0,C 0.0}\nSIGNAL grip $OUT[5]\nENDDAT\n"


@pytest.fixture
def backups(tmp_path):
    for name in ("old", "new"):
        for file, text in (("Program/work.src", SRC), ("Program/work.dat", DAT), ("System/$config.dat", CONFIG)):
            (tmp_path / name / "R1" / file).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name / "R1" / file).write_text(text)
    return tmp_path


def edit(backups, file, *changes):
    path = backups / "new" / "R1" / file
    text = path.read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path.write_text(text)


def changed(backups):
    return {x.name: x for x in compare(backups / "old", backups / "new") if x.kind != "same"}


def test_points_move_by_millimetres_and_degrees(backups):
    edit(backups, "Program/work.dat", ("X 1000.0,Y 0.0", "X 1003.0,Y -4.0"), ("A 0.0,B 90.0", "A 10.0,B 80.0"),
         ("S 2", "S 6"), ("A2 -90.0", "A2 -92.5"))  # fmt: skip
    (file,) = changed(backups).values()
    p1, home = file.points
    # from B 90 the turn by A and that by B are about different axes: cos(a/2) = cos(5 deg)^2
    turned = pytest.approx(2 * math.degrees(math.acos(math.cos(math.radians(5)) ** 2)), abs=1e-6)
    assert (p1.name, p1.line, p1.moved_mm, p1.turned_deg) == ("P1", 2, pytest.approx(5.0), turned)
    assert p1.others == ("S 2 -> 6",)
    assert (home.moved_mm, [(x.axis, x.change) for x in home.axes_deg]) == (None, [("A2", pytest.approx(-2.5))])
    assert not file.values
    assert not file.configuration
    edit(backups, "Program/work.dat", ("A 10.0,B 80.0", "A 0.0,B 87.0"))  # about one axis alone
    assert changed(backups)["R1/Program/work.dat"].points[0].turned_deg == pytest.approx(3.0)


def test_values_and_the_configuration(backups):
    edit(backups, "Program/work.dat", ("INT n=3", "INT n=4"), ("DECL REAL speed=1.50\n", "DECL BOOL go=TRUE\n"))
    edit(backups, "System/$config.dat", ("Z 100.0", "Z 101.0"), ("$OUT[5]", "$OUT[6]"))
    files = changed(backups)
    values = [(v.name, v.before, v.after) for v in files["R1/Program/work.dat"].values]
    assert values == [("n", "3", "4"), ("go", None, "TRUE"), ("speed", "1.5", None)]
    config = files["R1/System/$config.dat"]
    assert config.configuration
    assert [(p.name, p.moved_mm) for p in config.points] == [("TOOL_DATA[1]", pytest.approx(1.0))]
    assert [(v.name, v.after) for v in config.values] == [("grip", "SIGNAL grip $OUT[6]")]


def test_logic_by_routine_with_its_lines(backups):
    edit(backups, "Program/work.src", ("LIN P1 C_DIS", "LIN P1"), ("$OUT[3] = TRUE\n", ""), ("DEF other", "DEF third"))
    work, third, other = changed(backups)["R1/Program/work.src"].routines
    assert [(r.routine, r.kind) for r in (work, third, other)] == [
        ("WORK", "changed"), ("THIRD", "added"), ("OTHER", "removed"),
    ]  # fmt: skip
    pieces = [([(x.line, x.text) for x in old], [(x.line, x.text) for x in new]) for old, new in work.pieces]
    assert pieces == [([(6, "LIN P1 C_DIS")], [(6, "LIN P1")]), ([(8, "$OUT[3] = TRUE")], [])]


def test_layout_comments_case_and_zeros_do_not_count(backups):
    edit(backups, "Program/work.src", ("  LIN P1 C_DIS", "lin p1  c_dis ; near"), ("; a comment", "; another"))
    edit(backups, "Program/work.dat", ("speed=1.50", "SPEED = 1.5"), ("X 1000.0", "X 1000"), ("Y 0.0", "Y -0.0"))
    assert {name: x.kind for name, x in changed(backups).items()} == {
        "R1/Program/work.src": "layout",
        "R1/Program/work.dat": "layout",
    }
    edit(backups, "Program/work.src", ('"Go"', '"go"'))
    assert changed(backups)["R1/Program/work.src"].kind == "changed"


def test_files_are_paired_by_path_then_by_name(backups):
    moved = backups / "new" / "R1" / "Program" / "Cell"
    moved.mkdir()
    (backups / "new" / "R1" / "Program" / "work.src").rename(moved / "Work.SRC")
    (backups / "new" / "R1" / "Program" / "work.dat").unlink()
    (moved / "more.src").write_text("DEF more( )\nEND\n")
    kinds = {x.name: x.kind for x in compare(backups / "old", backups / "new")}
    assert kinds == {
        "R1/Program/Cell/Work.SRC": "same", "R1/Program/Cell/more.src": "added", "R1/System/$config.dat": "same",
        "R1/Program/work.dat": "removed",
    }  # fmt: skip


def test_the_command(backups, lwr_dyn_command):
    old, new = (str(backups / name) for name in ("old", "new"))
    assert lwr_dyn_command("krl", "diff", old, new)[:2] == (0, "same 3\n")
    edit(backups, "Program/work.dat", ("Y 0.0", "Y 2.0"))
    edit(backups, "Program/work.src", ("LIN P1 C_DIS", "LIN P1"))
    code, out, err = lwr_dyn_command("krl", "diff", old, new)
    assert (code, err) == (1, "")
    assert out.splitlines() == [
        "R1/Program/work.dat: changed",
        "  P1, line 2: moved 2.000 mm, turned 0.000 deg",
        "R1/Program/work.src: changed",
        "  WORK: changed",
        "    - 6: LIN P1 C_DIS",
        "    + 6: LIN P1",
        "files changed 2, points moved 1, routines changed 1, same 1",
    ]
    edit(backups, "Program/work.dat", ("INT n=3", "INT n=4"), ("DECL REAL speed=1.50\n", "DECL BOOL go=TRUE\n"))
    edit(backups, "System/$config.dat", ("Z 100.0", "Z 101.0"), ("$OUT[5]", "$OUT[6]"))
    edit(backups, "Program/work.src", ("LIN P1", "LIN P1 C_DIS"), ("PTP HOME", "PTP  HOME ; first"))
    assert lwr_dyn_command("krl", "diff", old, new)[1].splitlines() == [
        "R1/Program/work.dat: changed",
        "  P1, line 2: moved 2.000 mm, turned 0.000 deg",
        "  n: 3 -> 4",
        "  go added: TRUE",
        "  speed removed: 1.5",
        "R1/Program/work.src: only comments and layout differ",
        "R1/System/$config.dat: changed (configuration)",
        "  TOOL_DATA[1], line 2: moved 1.000 mm, turned 0.000 deg",
        "  grip: SIGNAL grip $OUT[5] -> SIGNAL grip $OUT[6]",
        "files changed 2, in layout only 1, points moved 1, values changed 3, of the configuration 2",
    ]
    edit(backups, "Program/work.src", ("PTP  HOME ; first", "PTP HOME"), ("LIN P1 C_DIS", "LIN P1"))
    # a .src brings the .dat beside it
    files = [f"{folder}/R1/Program/work.src" for folder in (old, new)]
    code, out, _ = lwr_dyn_command("krl", "diff", *files, "--json")
    record = json.loads(out)
    assert faults("krl diff", record) == []
    assert (code, [x["file"] for x in record["files"]]) == (1, ["work.src", "work.dat"])


def test_bad_input_is_one_line(backups, refused):
    work = str(backups / "old" / "R1" / "Program" / "work.src")
    for after, message in (("none.src", "no such file"), ("new/R1/System", "a folder")):
        assert message in refused("krl", "diff", work, str(backups / after))


def test_meaning():
    assert meaning_of('ptp P1  c_ptp ; "x"') == meaning_of("PTP p1 C_PTP")
    assert meaning_of('x = "a"') != meaning_of('x = "A"')
    assert meaning_of("x = 1.50") == meaning_of("x=1.5E0")
    assert meaning_of(' x = "a ') == 'x = "a'  # what cannot be read, as it stands
