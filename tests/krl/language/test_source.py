"""What is written is read back the same; what was read and not changed is written back byte for byte."""

from dataclasses import replace

import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.line_parser import parse_line
from lwr_dyn.krl.language.source import SourceLine, data_beside, krl_files, parse_bytes, parse_text, read_source
from lwr_dyn.krl.language.unparse import expression_text, statement_text
from tests.krl.mutations import PROGRAMS
from tests.krl.random_programs import Writer

PROGRAM_COUNT = 1000


@pytest.mark.slow
def test_random_programs_survive_write_and_parse():
    for seed in range(PROGRAM_COUNT):
        file = Writer(seed).file()
        back, diagnostics = parse_text(file.text(), file.name)
        assert not diagnostics, (seed, diagnostics[0], file.text())
        assert back == file, (seed, next((a, b) for a, b in zip(file.lines, back.lines, strict=True) if a != b))


@pytest.mark.parametrize("path", sorted(PROGRAMS.iterdir()), ids=lambda p: p.name)
def test_unchanged_files_are_written_back_byte_for_byte(path):
    file, diagnostics = read_source(path)
    assert not diagnostics
    assert file.to_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xef\xbb\xbfDEF a( )\r\nEND",
        b"DEF a( )\n\tPTP  p ;\x85 \xfc\x0b\x0c\r\nEND\r\r\n \n",
        "DEF a( )\n; µ und ü in UTF-8\nEND\n".encode(),
        b"PTP {\x00\xff\n' \"\n",
    ],
)
def test_any_bytes_are_written_back_and_an_encoding_is_said_at_the_first_line(data):
    file, diagnostics = parse_bytes(data, "a.src")
    assert file.to_bytes() == data
    found = [str(one.position) for one in diagnostics if one.code == "encoding"]
    assert found == ["a.src:1:1"] * (max(data, default=0) > 127 and b"\x85" not in data)


def test_an_edit_changes_its_own_line_only():
    before = b"DEF  a ( )\r\n  PTP  p1   ;  go\r\n\tWAIT   SEC 1 ; rest\r\nEND\r\n"
    file, _ = parse_bytes(before)
    lines = list(file.lines)
    lines[2] = replace(lines[2], statement=s.Wait("SEC", e.Real(2.5)))
    assert replace(file, lines=tuple(lines)).to_bytes() == before.replace(
        b"\tWAIT   SEC 1 ; rest", b"WAIT SEC 2.5 ; rest"
    )


IDIOMS = [
    "GLOBAL E6AXIS g_pos={A1 0.0,A2 -4.4E-05}", "DECL GLOBAL mode_t mode=#KRL_PTP",
    'programs[1]={type #KRL_PTP,id[] "KRL",place {A1 1,A2 2}}', 'MsgNotify("changed to: %1", "Debug", ,text[], 1)',
    "ratio = 1.0*$RAT_MOT_AX[j].N/1.0*$RAT_MOT_AX[j].D", "global interrupt decl 15 when $flag[1]==false do reset_it()",
    "$timer_stop[1] = false  ; start", "deffct int get_it(position :out)", "return(far(1))",
    "IF (($PRO_STATE1==#P_ACTIVE) AND (state==#RUN)) THEN ; both", "code = code B_OR MASK",
    "HOME = {AXIS: A1 0, A2 -90, A3 90, A4 0, A5 90, A6 0} ; start", "err = set_it(axis,i,bound[i-1]);",
    "EXT  bas (BAS_COMMAND  :IN,REAL  :IN )",
]  # fmt: skip
BRACKETS = {
    "a + b * c": "a + b * c", "(a + b) * c": "(a + b) * c", "a - (b - c)": "a - (b - c)", "(a - b) - c": "a - b - c",
    "a : b : c * 2": "a : b : c * 2", "NOT (a AND b)": "NOT (a AND b)",
    "((a == 1)) AND (b < 2)": "(a == 1) AND (b < 2)", "- (-3)": "--3",
}  # fmt: skip


@pytest.mark.parametrize("line", [*IDIOMS, *(f"x = {text}" for text in BRACKETS)])
def test_idioms_of_public_programs_are_read_and_brackets_stand_where_they_are_needed(line):
    statement, _ = parse_line(line)
    assert parse_line(statement_text(statement))[0] == statement
    text = line.removeprefix("x = ")
    assert expression_text(statement.value) == BRACKETS[text] if text in BRACKETS else line in IDIOMS


def test_keywords_in_any_case_contextual_names_and_comparisons_that_bind_last_as_in_kukas_table():
    assert parse_line("ptp P1 c_ptp")[0] == parse_line("PTP P1 C_PTP")[0]
    assert parse_line("Path = STEP + sec")[0] == s.Assign(e.Name("Path"), e.Binary("+", e.Name("STEP"), e.Name("sec")))
    value = parse_line("x = a == b AND c")[0].value
    assert (value.operator, value.right.operator) == ("==", "AND")


def test_what_cannot_be_written_is_refused():
    with pytest.raises(OptionError):
        statement_text(s.Wait("SEC", e.Real(float("inf"))))
    with pytest.raises(OptionError):
        SourceLine(None, "two\nlines").text()


def test_files_are_listed_without_folders_that_begin_with_a_point(tmp_path):
    for name in ("b/x.SRC", "b/x.dat", "a.sub", ".git/y.src", "c/note.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert [x.relative_to(tmp_path).as_posix() for x in krl_files(tmp_path)] == ["a.sub", "b/x.SRC", "b/x.dat"]
    assert data_beside(tmp_path / "b/x.SRC") == tmp_path / "b/x.dat"
    assert data_beside(tmp_path / "a.sub") is None
