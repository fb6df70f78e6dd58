"""What a name refers to in a backup: its declaration, its uses, and equal names that mean other things."""

import pytest

from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import MOST_VALUES, hover_text
from tests.krl.small_backup import CLOSE, CONFIG, FILES, MAIN, place_of, put, write_backup

DATA, CLOSE_DATA, STEU = "KRC/R1/Program/main.dat", "KRC/R1/Program/close_it.dat", "KRC/STEU/$config.dat"


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return EditedProject(write_backup(tmp_path_factory.mktemp("backup")))


def found_at(project, name, text, word="", after=0):
    line, column = place_of(name, text, 0, word)
    return project.at(name, line, column + after)


DECLARED = {
    "own data": (MAIN, "LIN pick", "pick", "variable", (DATA, 2, 12)),
    "global of a public .dat": (MAIN, "shared_count = ", "shared_count", "variable", (CLOSE_DATA, 2, 17)),
    "of the controller": (MAIN, "PTP XHOME", "XHOME", "variable", (CONFIG, 4, 13)),
    "of this robot": (MAIN, "SPEED = i", "SPEED", "variable", (CONFIG, 8, 11)),
    "local": (MAIN, "FOR i", "i", "variable", (MAIN, 3, 10)),
    "local of another routine": (MAIN, "SPEED = i", "i", "variable", (MAIN, 23, 10)),
    "parameter": (CLOSE, "g.force = 1.5 * n", "g", "variable", (CLOSE, 1, 14)),
    "subprogram of another file": (MAIN, "close_it (", "close_it", "routine", (CLOSE, 1, 5)),
    "subprogram of this file": (MAIN, "helper ( )", "helper", "routine", (MAIN, 22, 5)),
    "structure": (MAIN, "DECL GRIP_T grip", "GRIP_T", "type", (CONFIG, 3, 7)),
    "component": (MAIN, "grip.state", "state", "component", (CONFIG, 3, 22)),
    "component in its structure": (CONFIG, "REAL force", "force", "component", (CONFIG, 3, 34)),
    "type of a component": (CONFIG, "STATE_E state", "STATE_E", "type", (CONFIG, 2, 6)),
    "constant": (MAIN, "#OPEN", "#OPEN", "constant", (CONFIG, 2, 14)),
    "constant in its enumeration": (CONFIG, "SHUT", "SHUT", "constant", (CONFIG, 2, 20)),
    "label": (MAIN, "GOTO again", "again", "label", (MAIN, 9, 1)),
    "function of every controller": (MAIN, "BAS (#INITMOV", "BAS", "routine", None),
    "variable of every controller": (MAIN, "$TOOL = ", "$TOOL", "variable", None),
    "component of every controller": (DATA, "X 100", "X", "component", None),
}


@pytest.mark.parametrize(("name", "text", "word", "meaning", "place"), DECLARED.values(), ids=DECLARED)
def test_a_name_is_found_where_it_is_declared(project, name, text, word, meaning, place):
    """From its first to its last letter, and behind it."""
    for after in {0, len(word)}:
        found = found_at(project, name, text, word, after)[2]
        assert found.meaning == meaning
        x = found.position
        assert (x and (x.file, x.line, x.column)) == place


@pytest.mark.parametrize(
    ("text", "word"), [("FOR i", "FOR"), ("FOR i = 1", "1"), (";FOLD INI", "INI"), ("&ACCESS", "ACC")]
)
def test_what_is_no_name_refers_to_nothing(project, text, word):
    assert found_at(project, MAIN, text, word) is None


USES = [
    (MAIN, "LIN pick", "pick", {"main.dat": [2], "main.src": [11]}),
    (CLOSE_DATA, "INT pick", "pick", {"close_it.dat": [3]}),
    (MAIN, "FOR i", "i", {"main.src": [3, 10, 13, 17]}),
    (MAIN, "i = 2", "i", {"main.src": [23, 24, 25]}),
    (STEU, "SPEED", "", {"$config.dat": [2]}),
    (MAIN, "shared_count = ", "shared_count", {"close_it.dat": [2], "close_it.src": [6], "main.src": [17, 17]}),
    (CLOSE, "close_it(", "", {"close_it.dat": [1], "close_it.src": [1], "main.src": [13]}),
    (CONFIG, "GRIP_T", "", {"$config.dat": [3], "close_it.src": [2], "main.src": [4]}),
    (MAIN, "grip.state", "state", {"$config.dat": [3], "close_it.src": [4], "main.src": [12]}),
    (MAIN, "#OPEN", "OPEN", {"$config.dat": [2], "main.src": [12]}),
    (MAIN, "GOTO again", "again", {"main.src": [9, 19]}),
]


@pytest.mark.parametrize(("name", "text", "word", "expected"), USES)
def test_uses_are_those_of_the_same_thing_and_not_of_the_same_word(project, name, text, word, expected):
    lines = {}
    for x in project.uses(found_at(project, name, text, word)[2]):
        lines.setdefault(x.file.split("/")[-1], []).append(x.line)
    assert lines == expected


ZEROS = "A 0.0, B 0.0, C 0.0}"
SHOWN = {
    "position": (MAIN, "LIN pick", "pick",
                 ["DECL E6POS pick", "pick = {X 100.0, Y 0.0, Z 900.0, A 0.0, B 90.0, C 0.0, S 2, T 2}"],
                 f"{DATA}, line 2"),
    "element": (MAIN, "TOOL_DATA[2]", "TOOL_DATA",
                ["DECL FRAME[] TOOL_DATA", f"TOOL_DATA[2] = {{X 0.0, Y 0.0, Z 200.0, {ZEROS}"], f"{CONFIG}, line 5"),
    "array": (CONFIG, "TOOL_DATA[16]", "TOOL_DATA",
              ["DECL FRAME[] TOOL_DATA", *(f"TOOL_DATA[{i}] = {{X 0.0, Y 0.0, Z {i}00.0, {ZEROS}" for i in (1, 2))],
              f"{CONFIG}, line 5"),
    "global": (MAIN, "shared_count = ", "shared_count", ["GLOBAL DECL INT shared_count", "shared_count = 7"],
               f"{CLOSE_DATA}, line 2"),
    "subprogram": (MAIN, "close_it (", "close_it", ["DEF close_it(g:OUT, n:IN)"], f"{CLOSE}, line 1"),
    "structure": (MAIN, "DECL GRIP_T", "GRIP_T", ["STRUC GRIP_T STATE_E STATE, REAL FORCE"], f"{CONFIG}, line 3"),
    "enumeration": (CONFIG, "STATE_E state", "STATE_E", ["ENUM STATE_E OPEN, SHUT"], f"{CONFIG}, line 2"),
    "component": (CLOSE, "g.force", "force", ["REAL force of GRIP_T"], f"{CONFIG}, line 3"),
    "constant": (MAIN, "#OPEN", "#OPEN", ["ENUM STATE_E OPEN, SHUT"], f"{CONFIG}, line 2"),
    "label": (MAIN, "again:", "again", ["again:"], f"{MAIN}, line 9"),
    "function": (MAIN, "BAS (#", "BAS", ["DEF BAS(BAS_COMMAND command:IN, REAL value:IN?)"],
                 "KUKA's bas.src and $config.dat: Inline forms and BAS"),
    "system variable": (MAIN, "$TOOL", "$TOOL", ["FRAME $TOOL"], "KSS 8.6: Poses and coordinate systems"),
    "kernel type": (CONFIG, "FRAME TOOL", "FRAME", ["STRUC FRAME REAL X, REAL Y, REAL Z, REAL A, REAL B, REAL C"], ""),
}  # fmt: skip


@pytest.mark.parametrize(("name", "text", "word", "code", "where"), SHOWN.values(), ids=SHOWN)
def test_hover_has_declaration_value_and_place(project, name, text, word, code, where):
    context, _, found = found_at(project, name, text, word)
    assert hover_text(context, found) == "\n".join(["```krl", *code, "```", *(["", where] if where else [])])


def test_a_constant_of_the_kernel_is_shown_with_its_enumeration(project):
    context, _, found = found_at(project, MAIN, "#INITMOV", "#INITMOV")
    assert hover_text(context, found).startswith("```krl\nENUM BAS_COMMAND ACC_CP, ACC_GLUE, ")


@pytest.mark.parametrize("count", [MOST_VALUES, MOST_VALUES + 1, MOST_VALUES + 5])
def test_of_many_values_the_first_are_shown_and_the_others_are_counted(tmp_path, count):
    project = EditedProject(write_backup(tmp_path))
    put(project, "DECL CONST INT many[99]", *(f"many[{i}]={i}" for i in range(1, count + 1)), name=DATA, at="ENDDAT")
    context, _, found = project.at(DATA, FILES[DATA].count("\n") - 1, 16)
    head, *values = hover_text(context, found).split("\n")[1:-3]
    assert head == "DECL CONST INT[] many"
    written = [f"many[{i}] = {i}" for i in range(1, count + 1)]
    more = count - MOST_VALUES + 1
    assert values == (written if more == 1 else [*written[: MOST_VALUES - 1], f"; and {more} more"])
