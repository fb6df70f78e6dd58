"""Hostile files end soon, in a diagnosis or one clear line; a name that nothing declares is told once."""

import os
import signal
import time

import pytest

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.diagnostics import MOST
from lwr_dyn.krl.project.program import NEAR_NAMES, load_program, load_project, parse_program, scope_of
from lwr_dyn.krl.running.program_run import check_program
from tests.krl.short_programs import program_of, told

PATIENCE = 20
"""[s] Each takes under one on an idle core; before, a line of 10 MB took 23 s and a pipe for ever."""


@pytest.fixture(autouse=True)
def _ended():
    def stop(number, frame):
        raise TimeoutError("it does not end")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(3 * PATIENCE)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def codes(*lines):
    start = time.perf_counter()
    found = [code for _, _, code in told(*lines)]
    assert time.perf_counter() - start < PATIENCE
    return found


def test_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "a.src")
    with pytest.raises(FileAccessError, match="a pipe or a device"):
        load_program(tmp_path / "a.src")
    os.mkfifo(tmp_path / "b.dat")
    (tmp_path / "b.src").write_text("DEF b( )\nEND\n")
    assert check_program(load_program(tmp_path / "b.src")) == ()
    assert [m.name for m in load_project(tmp_path).modules] == ["B"]


@pytest.mark.parametrize(
    "line", ["x = " + "1+" * 5_000_000 + "1", 'x = "' + "a" * 10_000_000 + '"', "a" * 10_000_000 + " = 1"]
)
def test_a_line_of_megabytes_is_one_fault(line):
    assert codes(line) == ["long-line"]


def test_a_comment_of_megabytes_is_none():
    assert codes("HALT ;" + "a" * 10_000_000) == []


def test_a_structure_in_itself_is_told_and_used():
    assert codes("STRUC S1 INT A, S1 B", "DECL S1 X", "X.B.B.B.A = 1") == ["recursive-type"]


def test_arrays_enumerations_and_routines_without_end():
    assert codes("INT a[2000000000,2000000000]", "a[1,1] = 1") == []
    assert codes("ENUM E " + ",".join(f"C{i}" for i in range(700)), "DECL E v", "v = #C700") == ["no-constant"]
    many = codes(*["END", "DEF b( )"] * 20_000)
    assert (many.count("duplicate-name"), many.count("more")) == (100, 1)


@pytest.mark.slow
def test_jumps_exits_and_labels_by_the_thousand():
    assert codes(*["l:"] * 20_000, "GOTO k").count("duplicate-name") == 100
    found = codes("LOOP", *["IF TRUE THEN"] * 190, *["EXIT"] * 20_000)
    assert set(found) == {"missing-end", "more"}


def diagnostics_of(*lines, data=None):
    return check_program(program_of(*lines, data=data))


def test_an_unknown_name_is_told_once_with_its_places():
    (only,) = diagnostics_of("x = 1", "X = x + 1", "WAIT SEC x")
    assert (only.position.line, only.position.column) == (2, 1)
    assert only.message == "x is not declared (4 places)"
    (call,) = diagnostics_of("foo(1)", "foo(2)")
    assert call.message == "the subprogram foo is not known (2 places)"
    (kind,) = diagnostics_of("DECL FRAMM p", "DECL FRAMM q")
    assert (kind.message, kind.hint) == ("FRAMM is no type (2 places)", "did you mean FRAME?")


def test_a_parameter_is_declared_where_its_routine_begins():
    program = parse_program("DEF a( )\nsub(1, 2)\nEND\nDEF sub(left :IN, n :IN)\nEND\n", name="a")
    names = scope_of(program, program.routines[1], []).own.variables
    assert {name: (x.position.line, x.position.column) for name, x in names.items()} == {"LEFT": (4, 9), "N": (4, 19)}


def test_a_name_of_the_data_file_is_told_there_too():
    found = diagnostics_of("n = k", data="DEFDAT a\nINT n=1\nINT m\nm=k\nENDDAT\n")
    assert [(d.position.file, d.position.line) for d in found] == [("a.dat", 4), ("a.src", 2)]


def test_similar_names_are_looked_for_at_the_first_names_only():
    found = diagnostics_of("REAL VALUE", *(f"VALU{i} = 1" for i in range(50)))
    hints = [d.hint for d in found]
    assert hints[:NEAR_NAMES] == ["did you mean VALUE?"] * NEAR_NAMES
    assert "did you mean VALUE?" not in hints[NEAR_NAMES:]
    assert len(hints) == 50


@pytest.mark.slow
def test_thirteen_thousand_unknown_names_take_no_minute():
    start = time.perf_counter()
    found = diagnostics_of(*(f"REAL known_{i}" for i in range(500)), *(f"name_{i} = {i}" for i in range(13_000)))
    assert time.perf_counter() - start < 20.0  # 95 s before; 2 s on an idle core
    assert len(found) == MOST + 1


def test_of_an_unknown_type_nothing_more_is_told():
    lines = [
        "DECL BOXES b",
        "DECL BOXES c[3]",
        "b.HIGH = TRUE",
        "c[1].LOW = b.HIGH + 1",
        "b = c[2]",
        "PTP b",
        "c[4] = b",
    ]
    found = [(d.position.line, d.code) for d in diagnostics_of(*lines)]
    assert found == [(2, "unknown-type"), (8, "index-range")]
    inside = diagnostics_of("STRUC S1 BOXES K", "DECL S1 s", "s.K.HIGH = 3", "PTP s.K")
    assert [(d.position.line, d.code) for d in inside] == [(2, "unknown-type")]
    taken = diagnostics_of("take(3)", "END", "DEF take(x :IN)", "DECL BOXES x")
    assert [(d.position.line, d.code) for d in taken] == [(5, "unknown-type")]


def test_an_unknown_system_name_may_be_a_subprogram():
    assert [d.code for d in diagnostics_of("$unheard( )")] == ["unknown-call"]
    assert [d.code for d in diagnostics_of("INT n", "n(3)", "$OV_PRO(3)")] == ["type", "type"]


def test_a_keyword_misspelt_before_a_bracket_is_no_unknown_subprogram():
    (fault,) = [d for d in diagnostics_of("RETRUN (3)") if d.position.line == 2]
    assert (fault.code, fault.hint) == ("unknown-keyword", "did you mean RETURN?")
