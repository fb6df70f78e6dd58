"""What a name refers to in a backup: its declaration, its uses, and equal names that mean other things."""

import pytest

from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import hover_text
from tests.krl.small_backup import CLOSE, CONFIG, MAIN, place_of, write_backup


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return EditedProject(write_backup(tmp_path_factory.mktemp("backup")))


def found_at(project, name, text, nth=0, word=""):
    return project.at(name, *place_of(name, text, nth, word))


DECLARED = {
    "own data": (MAIN, "LIN pick", "pick", "variable", ("KRC/R1/Program/main.dat", 2)),
    "global of a public .dat": (
        MAIN,
        "shared_count = ",
        "shared_count",
        "variable",
        ("KRC/R1/Program/close_it.dat", 2),
    ),
    "of the controller": (MAIN, "PTP XHOME", "XHOME", "variable", (CONFIG, 4)),
    "of this robot": (MAIN, "SPEED = i", "SPEED", "variable", (CONFIG, 8)),
    "local": (MAIN, "FOR i", "i", "variable", (MAIN, 3)),
    "local of another routine": (MAIN, "SPEED = i", "= i", "variable", (MAIN, 23)),
    "parameter": (CLOSE, "g.force = 1.5 * n", "g", "variable", (CLOSE, 1)),
    "subprogram of another file": (MAIN, "close_it (", "close_it", "routine", (CLOSE, 1)),
    "subprogram of this file": (MAIN, "helper ( )", "helper", "routine", (MAIN, 22)),
    "structure": (MAIN, "DECL GRIP_T grip", "GRIP_T", "type", (CONFIG, 3)),
    "component": (MAIN, "grip.state", "state", "component", (CONFIG, 3)),
    "constant": (MAIN, "#OPEN", "#OPEN", "constant", (CONFIG, 2)),
    "label": (MAIN, "GOTO again", "again", "label", (MAIN, 9)),
}


@pytest.mark.parametrize("what", DECLARED)
def test_a_name_is_found_where_it_is_declared(project, what):
    name, text, word, meaning, (file, line) = DECLARED[what]
    column = 2 if word == "= i" else 0
    at, start = place_of(name, text, 0, word)
    _, _, found = project.at(name, at, start + column)
    assert found.meaning == meaning
    assert (found.position.file, found.position.line) == (file, line)


@pytest.mark.parametrize(("text", "word"), [("BAS (#INITMOV", "BAS"), ("$TOOL = ", "$TOOL")])
def test_a_name_of_every_controller_has_no_place(project, text, word):
    assert found_at(project, MAIN, text, 0, word)[2].position is None


@pytest.mark.parametrize(
    ("text", "word"), [("FOR i", "FOR"), ("FOR i = 1", "1"), (";FOLD INI", "INI"), ("&ACCESS", "ACC")]
)
def test_what_is_no_name_refers_to_nothing(project, text, word):
    assert found_at(project, MAIN, text, 0, word) is None


def lines_of(project, name, text, word=""):
    found = found_at(project, name, text, 0, word)[2]
    return sorted((x.file.split("/")[-1], x.line) for x in project.uses(found))


def test_uses_are_those_of_the_same_thing_and_not_of_the_same_word(project):
    assert lines_of(project, MAIN, "LIN pick", "pick") == [("main.dat", 2), ("main.src", 11)]
    assert lines_of(project, "KRC/R1/Program/close_it.dat", "INT pick", "pick") == [("close_it.dat", 3)]
    assert lines_of(project, MAIN, "FOR i", "i") == [("main.src", line) for line in (3, 10, 13, 17)]
    assert lines_of(project, MAIN, "i = 2", "i") == [("main.src", line) for line in (23, 24, 25)]
    assert lines_of(project, "KRC/STEU/$config.dat", "SPEED") == [("$config.dat", 2)]


def test_uses_of_what_other_files_declare(project):
    counted = [("close_it.dat", 2), ("close_it.src", 6), ("main.src", 17), ("main.src", 17)]
    assert lines_of(project, MAIN, "shared_count = ", "shared_count") == counted
    assert lines_of(project, CLOSE, "close_it(") == [
        ("close_it.dat", 1),
        ("close_it.src", 1),
        ("main.src", 13),
    ]
    assert lines_of(project, CONFIG, "GRIP_T") == [("$config.dat", 3), ("close_it.src", 2), ("main.src", 4)]
    assert lines_of(project, MAIN, "grip.state", "state") == [("$config.dat", 3), ("close_it.src", 4), ("main.src", 12)]
    assert lines_of(project, MAIN, "GOTO again", "again") == [("main.src", 9), ("main.src", 19)]


TEXTS = {
    "position": (MAIN, "LIN pick", "pick", ["DECL E6POS pick", "pick = {X 100.0, Y 0.0, Z 900.0", "main.dat, line 2"]),
    "element": (MAIN, "TOOL_DATA[2]", "TOOL_DATA", ["FRAME[] TOOL_DATA", "TOOL_DATA[2] = {X 0.0, Y 0.0, Z 200.0"]),
    "global": (MAIN, "shared_count = ", "shared_count", ["GLOBAL DECL INT shared_count", "shared_count = 7"]),
    "subprogram": (MAIN, "close_it (", "close_it", ["DEF close_it(g:OUT, n:IN)", "close_it.src, line 1"]),
    "structure": (MAIN, "DECL GRIP_T", "GRIP_T", ["STRUC GRIP_T STATE_E STATE, REAL FORCE"]),
    "component": (CLOSE, "g.force", "force", ["REAL force of GRIP_T"]),
    "constant": (MAIN, "#OPEN", "#OPEN", ["ENUM STATE_E OPEN, SHUT"]),
    "function": (MAIN, "BAS (#", "BAS", ["DEF BAS(BAS_COMMAND command:IN", "bas.src"]),
    "constant of a kernel type": (MAIN, "#INITMOV", "#INITMOV", ["ENUM BAS_COMMAND", "INITMOV"]),
    "system variable": (MAIN, "$TOOL", "$TOOL", ["FRAME $TOOL", "KSS"]),
}


@pytest.mark.parametrize("what", TEXTS)
def test_hover_has_declaration_value_and_place(project, what):
    name, text, word, expected = TEXTS[what]
    context, _, found = found_at(project, name, text, 0, word)
    shown = hover_text(context, found)
    for part in expected:
        assert part in shown
    assert ("TOOL_DATA[1]" in shown) is False
