"""The call in which the cursor stands, its parameters; who calls a routine, and whom it calls."""

import pytest

from lwr_dyn.krl.editor.calls import callees, callers, open_call
from tests.krl.small_backup import CLOSE, FILES, MAIN, place_of, put

CLOSE_IT = "close_it(GRIP_T g:OUT, INT n:IN)"
OPEN = {
    "close_it (": (CLOSE_IT, 0, "GRIP_T"),
    "close_it (grip, ": (CLOSE_IT, 1, "INT"),
    "close_it (grip, 1, ": (CLOSE_IT, 2, "None"),
    "close_it (grip[f(1, 2), 3], 1 + (2": (CLOSE_IT, 1, "INT"),
    "close_it ({state #OPEN, force 1}, ": (CLOSE_IT, 1, "INT"),
    "x = ABS(sqrt(": ("sqrt(REAL value:IN)", 0, "REAL"),
    "x = ABS(sqrt(2), ": ("ABS(REAL value:IN)", 1, "None"),
    "far(1, ": ("far(INT:IN, REAL:OUT)", 1, "REAL"),
    "CREAD(h, ": ("CREAD(? handle:IN, ? state:IN, ? mode:IN, ...)", 1, "?"),
}
SHUT = ["", "close_it", "x = (1", "close_it (grip)", 'close_it ("', "close_it ( ;", "nix ("]


@pytest.mark.parametrize("written", [*OPEN, *SHUT])
def test_the_innermost_open_call_has_its_parameters_and_elsewhere_there_is_none(project, written):
    put(project, "EXT far(INT:IN, REAL:OUT)", at=";FOLD INI")
    found = open_call(put(project, written), len(written))
    assert (found and (found.label, found.at, str(found.type))) == OPEN.get(written)


def test_a_parameter_without_a_mode_is_out_and_without_a_declaration_has_no_type(project):
    project.set_text(CLOSE, FILES[CLOSE].replace("g:OUT", "g").replace("DECL INT n\n", ""))
    assert open_call(put(project, "close_it ("), 10).label == "close_it(GRIP_T g:OUT, n:IN)"


def test_callers_and_callees_are_those_of_all_files(project):
    put(project, "  close_it (grip, 2)", at="SPEED = i")
    places = ((CLOSE, "close_it"), (MAIN, "main"), (MAIN, "helper"))
    close, main, helper = (project.at(name, *place_of(name, f"DEF {x}", word=x))[2] for name, x in places)

    def named(calls):
        return [(x.routine.head.name, x.file, [(p.line, p.column) for p in x.places]) for x in calls]

    of_main, of_helper = [(13, 5), (18, 1)], [(25, 3)]
    assert named(callers(project, close)) == [("main", MAIN, of_main[:1]), ("helper", MAIN, of_helper)]
    assert (named(callers(project, main)), named(callers(project, helper))) == ([], [("main", MAIN, of_main[1:])])
    assert named(callees(project, MAIN, helper.declared)) == [("close_it", CLOSE, of_helper)]
    assert named(callees(project, MAIN, main.declared)) == [
        ("close_it", CLOSE, of_main[:1]),
        ("helper", MAIN, of_main[1:]),
    ]
