"""Hostile files end soon, in a diagnosis or one clear line: pipes, lines of megabytes, structures without end."""

import os
import signal
import time

import pytest

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.project.program import load_program, load_project, parse_program
from lwr_dyn.krl.running.program_run import check_program

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
    program = parse_program("\n".join(["DEF a( )", *lines, "END", ""]), name="a")
    found = [d.code for d in check_program(program)]
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
