"""`krl format`: a second pass changes nothing; statements, comments, strings, `&` lines and inline forms stay."""

import random

import pytest

from lwr_dyn.krl.language.layout import changed_lines, formatted, spaced
from lwr_dyn.krl.language.lexer import tokens_of
from lwr_dyn.krl.language.source import parse_bytes, parse_text
from tests.krl.mutations import PROGRAMS, SOURCES, mutated
from tests.krl.random_programs import Writer

SEEDS = 150


def meanings(file):
    return [(x.statement, x.comment) for x in file.lines if (x.statement, x.comment) != (None, None)]


def strings(file):
    lines = [x.text() for x in file.lines if x.readable and not x.text().lstrip().startswith("&")]
    return [token.text for text in lines for token in tokens_of(text)[0] if token.kind == "STRING"]


def samples():
    for path in sorted(PROGRAMS.iterdir()):
        yield path.name, path.read_bytes()
    for seed in range(SEEDS):
        rng = random.Random(seed)
        yield "a.src", Writer(seed).file().to_bytes().replace(b" ", b" " * rng.choice([1, 1, 3]))
        yield rng.choice(["a.src", "a.dat"]), mutated(rng.choice(SOURCES).read_bytes(), rng)


@pytest.mark.slow
def test_the_meaning_stays_and_a_second_pass_changes_nothing():
    changed = 0
    for name, data in samples():
        before, _ = parse_bytes(data, name)
        once = formatted(before).to_bytes()
        after, _ = parse_bytes(once, name)
        assert meanings(after) == meanings(before), data
        assert strings(after) == strings(before), data
        assert formatted(after).to_bytes() == once, data
        unread = [x.text() for x in before.lines if not x.readable or x.text().lstrip().startswith("&")]
        assert [x.text() for x in after.lines if not x.readable or x.text().lstrip().startswith("&")] == unread
        changed += once != data
    assert changed > SEEDS


BEFORE = (
    b"&ACCESS  RVP\r\n"
    b"def  work ( n:in )\r\n"
    b'decl  int I ; \xe4 "x"  \r\n'
    b"\r\n"
    b";FOLD PTP  P1 Vel=100 %;%{PE}%R 8.3\r\n"
    b"$BWDSTART=FALSE\r\n"
    b"PTP   XP1 C_PTP\r\n"
    b";ENDFOLD\r\n"
    b"switch n\n"
    b"case 1 ,2\n"
    b'msg ( "two  words",, -1 )\n'
    b"default\n"
    b"  if NOT(a==-b)and(x<1) then;why\n"
    b"P={E6POS:X  -1.50,A[2] -5}\n"
    b"endif\n"
    b"endswitch\n"
    b"PTP {X  1\n"
    b"again :\n"
    b"step=n*STEP\n"
    b"end   ;  over"
)
AFTER = (
    b"&ACCESS  RVP\r\n"
    b"DEF work(n:IN)\r\n"
    b'  DECL INT I ; \xe4 "x"  \r\n'
    b"\r\n"
    b";FOLD PTP  P1 Vel=100 %;%{PE}%R 8.3\r\n"
    b"$BWDSTART=FALSE\r\n"
    b"PTP   XP1 C_PTP\r\n"
    b";ENDFOLD\r\n"
    b"  SWITCH n\n"
    b"    CASE 1, 2\n"
    b'      msg("two  words",, -1)\n'
    b"    DEFAULT\n"
    b"      IF NOT (a == -b) AND (x < 1) THEN ;why\n"
    b"        P = {E6POS: X -1.50, A[2] -5}\n"
    b"      ENDIF\n"
    b"  ENDSWITCH\n"
    b"PTP {X  1\n"
    b"  again:\n"
    b"  step = n * STEP\n"
    b"END   ;  over"
)


def test_a_program_line_by_line():
    file, _ = parse_bytes(BEFORE, "work.src")
    assert formatted(file).to_bytes() == AFTER
    assert changed_lines(file, formatted(file)) == [2, 3, 9, 10, 11, 12, 13, 14, 15, 16, 18, 19, 20]


def laid_out(text, name="a.src"):
    return formatted(parse_text(text, name)[0]).text()


def test_comments_keep_their_column_where_the_code_leaves_room_and_values_of_a_dat_their_spaces():
    text = "DEF a()\n$OUT[1]=TRUE    ; one\n$OUT[10]=FALSE  ; two\nEND\n"
    assert laid_out(text) == "DEF a()\n  $OUT[1] = TRUE ; one\n  $OUT[10] = FALSE ; two\nEND\n"
    wide = laid_out(text.replace(";", "      ;")).splitlines()
    assert wide[1:3] == ["  $OUT[1] = TRUE      ; one", "  $OUT[10] = FALSE    ; two"]
    data = "defdat a\n  decl E6POS XP1={X 1.0,Y   2.0}   \nenddat\n"
    assert laid_out(data, "a.dat") == "DEFDAT a\nDECL E6POS XP1={X 1.0,Y   2.0}\nENDDAT\n"


SPACED = {
    "x=a[ 1 ]*( -b+{X  -1,Y 2} : f (c ,d))": "x = a[1] * (-b + {X -1, Y 2} : f(c, d))",
    "P={E6POS:X -1,J[2] -5,K[i-1] a-b,Z +3}": "P = {E6POS: X -1, J[2] -5, K[i - 1] a - b, Z +3}",
    "CIRC {X 1,Y -2},P2,CA -90 C_DIS": "CIRC {X 1, Y -2}, P2, CA -90 C_DIS",
    "EXT bas (BAS_COMMAND  :IN,REAL  :IN )": "EXT bas(BAS_COMMAND:IN, REAL:IN)",
    "FOR i=-1 TO -n STEP -1": "FOR i = -1 TO -n STEP -1", "x=A:B:INV_POS(C)": "x = A : B : INV_POS(C)",
    "TRIGGER WHEN DISTANCE=0 DELAY=-20 DO $OUT[1]=TRUE": "TRIGGER WHEN DISTANCE = 0 DELAY = -20 DO $OUT[1] = TRUE",
}  # fmt: skip


def test_one_space_where_one_belongs():
    assert {text: spaced(tokens_of(text)[0]) for text in SPACED} == SPACED


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "R1" / "Program").mkdir(parents=True)
    (tmp_path / "R1" / "Program" / "Work.SRC").write_bytes(BEFORE)
    (tmp_path / "R1" / "neat.dat").write_bytes(b"DEFDAT neat\nENDDAT\n")
    (tmp_path / "notes.txt").write_bytes(b"if x then\n")
    return tmp_path


def test_a_folder_is_checked_then_formatted(folder, lwr_dyn_command):
    work = folder / "R1" / "Program" / "Work.SRC"
    code, out, err = lwr_dyn_command("krl", "format", str(folder), "--check")
    assert (code, err) == (1, "")
    assert out == f"{work}: 13 lines would change\n2 files, 1 would change\n"
    assert work.read_bytes() == BEFORE
    assert lwr_dyn_command("krl", "format", str(folder))[:2] == (0, f"{work}: 13 lines changed\n2 files, 1 changed\n")
    assert work.read_bytes() == AFTER
    assert lwr_dyn_command("krl", "format", str(folder), "--check")[:2] == (0, "2 files, 0 would change\n")
    assert (folder / "notes.txt").read_bytes() == b"if x then\n"


def test_another_indentation_and_bad_input(folder, lwr_dyn_command, refused):
    work = folder / "R1" / "Program" / "Work.SRC"
    assert lwr_dyn_command("krl", "format", str(work), "--indent", "3")[0] == 0
    assert b"\n      CASE 1, 2\n         msg(" in work.read_bytes()
    (folder / "R1" / "Empty").mkdir()
    for path, message in (("none.src", "none.src: no such file"), ("notes.txt", "ends in '.txt'"),
                          ("R1/Empty", "without KRL files")):  # fmt: skip
        assert message in refused("krl", "format", str(folder / path))
