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


HOSTILE = {
    "a long sum": (["x = " + "1+" * 5_000_000 + "1"], ["long-line"]),
    "a long text": (['x = "' + "a" * 10_000_000 + '"'], ["long-line"]),
    "a long name": (["a" * 10_000_000 + " = 1"], ["long-line"]),
    "a long comment": (["HALT ;" + "a" * 10_000_000], []),
    "a structure in itself": (["STRUC S1 INT A, S1 B", "DECL S1 X", "X.B.B.B.A = 1"], ["recursive-type"]),
    "a large array": (["INT a[2000000000,2000000000]", "a[1,1] = 1"], []),
    "many constants": (
        ["ENUM E " + ",".join(f"C{i}" for i in range(700)), "DECL E v", "v = #C700"], ["no-constant"]),
    "many routines": (["END", "DEF b( )"] * 20_000, ["duplicate-name"] * MOST + ["more"]),
}  # fmt: skip


@pytest.mark.parametrize(("lines", "expected"), HOSTILE.values(), ids=HOSTILE)
def test_what_is_without_end_is_told_soon(lines, expected):
    assert codes(*lines) == expected


@pytest.mark.slow
def test_jumps_exits_labels_and_unknown_names_by_the_thousand():
    assert codes(*["l:"] * 20_000, "GOTO k").count("duplicate-name") == 100
    assert set(codes("LOOP", *["IF TRUE THEN"] * 190, *["EXIT"] * 20_000)) == {"missing-end", "more"}
    # 95 s before; 2 s on an idle core
    unknown = codes(*(f"REAL known_{i}" for i in range(500)), *(f"name_{i} = {i}" for i in range(13_000)))
    assert len(unknown) == MOST + 1


def test_a_parameter_is_declared_where_its_routine_begins_and_a_name_of_the_dat_is_told_there_too():
    program = parse_program("DEF a( )\nsub(1, 2)\nEND\nDEF sub(left :IN, n :IN)\nEND\n", name="a")
    names = scope_of(program, program.routines[1], []).own.variables
    assert {name: (x.position.line, x.position.column) for name, x in names.items()} == {"LEFT": (4, 9), "N": (4, 19)}
    found = check_program(program_of("n = k", data="DEFDAT a\nINT n=1\nINT m\nm=k\nENDDAT\n"))
    assert [(d.position.file, d.position.line) for d in found] == [("a.dat", 4), ("a.src", 2)]


def test_similar_names_are_looked_for_at_the_first_names_only():
    hints = [d.hint for d in check_program(program_of("REAL VALUE", *(f"VALU{i} = 1" for i in range(50))))]
    assert [x == "did you mean VALUE?" for x in hints] == [True] * NEAR_NAMES + [False] * (50 - NEAR_NAMES)


def test_bytes_and_text_are_the_same_program():
    text, data = "DEF a( )\n; \u00fc\nx = 1\nEND\n", "DEFDAT a\nDECL INT x = 2\nENDDAT\n"
    of_text, of_bytes = (parse_program(text.encode(code), data.encode(code), "a") if code else
                         parse_program(text, data, "a") for code in ("", "latin-1"))  # fmt: skip
    assert (of_bytes.source, of_bytes.data) == (of_text.source, of_text.data)
