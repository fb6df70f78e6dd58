"""The call in which the cursor stands, its parameters; who calls a routine, and whom it calls."""

import pytest

from lwr_dyn.krl.editor.calls import callees, callers, open_call
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import line_context
from tests.krl.small_backup import CLOSE, FILES, MAIN, place_of, write_backup


@pytest.fixture
def project(tmp_path):
    return EditedProject(write_backup(tmp_path))


def call_in(project, written):
    lines = FILES[MAIN].split("\n")
    at = lines.index("GOTO again")
    project.set_text(MAIN, "\n".join([*lines[:at], written, *lines[at:]]))
    return open_call(line_context(project.program(MAIN), project.project.file(MAIN), at), len(written))


@pytest.mark.parametrize(
    ("written", "label", "at"),
    [
        ("close_it (", "close_it(GRIP_T g:OUT, INT n:IN)", 0),
        ("close_it (grip, ", "close_it(GRIP_T g:OUT, INT n:IN)", 1),
        ("close_it (grip[f(1, 2), 3], 1 + (2", "close_it(GRIP_T g:OUT, INT n:IN)", 1),
        ("close_it ({state #OPEN, force 1}, ", "close_it(GRIP_T g:OUT, INT n:IN)", 1),
        ("x = ABS(sqrt(", "sqrt(REAL value:IN)", 0),
        ("x = ABS(sqrt(2), ", "ABS(REAL value:IN)", 1),
    ],
)
def test_the_innermost_open_call_has_its_parameters(project, written, label, at):
    found = call_in(project, written)
    assert (found.label, found.at) == (label, at)


@pytest.mark.parametrize(
    "written", ["", "close_it", "x = (1", "close_it (grip)", 'close_it ("', "close_it ( ;", "nix ("]
)
def test_elsewhere_there_is_none(project, written):
    assert call_in(project, written) is None


def test_an_external_subprogram_has_the_parameters_of_its_declaration(project):
    text = FILES[MAIN].replace("DECL INT i\n", "EXT far(INT:IN, REAL VALUE:OUT)\nDECL INT i\n", 1)
    text = text.replace("GOTO again\n", "far(1, \nGOTO again\n")
    project.set_text(MAIN, text)
    at = text.split("\n").index("far(1, ")
    found = open_call(line_context(project.program(MAIN), project.project.file(MAIN), at), len("far(1, "))
    assert (found.label, found.at) == ("far(INT:IN, REAL VALUE:OUT)", 1)


def test_a_parameter_without_a_mode_is_out_and_without_a_declaration_has_no_type(project):
    project.set_text(CLOSE, FILES[CLOSE].replace("g:OUT", "g").replace("DECL INT n\n", ""))
    assert call_in(project, "close_it (").label == "close_it(GRIP_T g:OUT, n:IN)"


def test_callers_and_callees_are_those_of_all_files(project):
    close = project.at(CLOSE, *place_of(CLOSE, "DEF close_it", word="close_it"))[2]
    (caller,) = callers(project, close)
    assert (caller.routine.head.name, caller.file) == ("main", MAIN)
    assert [x.line for x in caller.places] == [13]
    main = project.at(MAIN, *place_of(MAIN, "DEF main", word="main"))[2]
    called = callees(project, MAIN, main.declared)
    assert [(x.routine.head.name, x.file, len(x.places)) for x in called] == [
        ("close_it", CLOSE, 1),
        ("helper", MAIN, 1),
    ]
    assert callers(project, main) == []
