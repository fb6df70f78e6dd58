"""What an editor shows in a line: what each name means, the SIGNAL beside an input, the word that mends a slip."""

from itertools import groupby

import pytest

from lwr_dyn.krl.editor.coloring import MEANINGS, OF_CONTROLLER, READ_ONLY, colored
from lwr_dyn.krl.editor.quick_fixes import quick_fix
from lwr_dyn.krl.editor.signal_hints import signal_hints
from tests.krl.small_backup import CLOSE, CONFIG, FILES, MAIN, put

SIGNALS = "SIGNAL part_there $IN[3]\nSIGNAL job $IN[10] TO $IN[13]\nSIGNAL glue $ANOUT[1]\nSIGNAL off FALSE\nENDDAT"


def colors(project, name, *lines):
    """Line (from 1) -> its words with their meanings; ! for what is only read, * for what the controller brings."""
    file, found = project.project.file(name), []
    for i, column, length, meaning, marks in colored(project.program(name), file, *lines):
        signs = "!" * bool(marks & READ_ONLY) + "*" * bool(marks & OF_CONTROLLER)
        found.append((i + 1, f"{file.file.lines[i].shown[column : column + length]} {MEANINGS[meaning]}{signs}"))
    return {line: ", ".join(text for _, text in of_line) for line, of_line in groupby(found, lambda x: x[0])}


def test_names_have_the_colours_of_what_they_mean(project):
    whole = colors(project, MAIN)
    assert whole == {
        2: "main function", 3: "i variable", 4: "GRIP_T type, grip variable", 6: "BAS function*, #INITMOV enumMember",
        8: "XHOME variable", 9: "again variable", 10: "i variable", 11: "pick variable",
        12: "grip variable, state property, #OPEN enumMember", 13: "close_it function, grip variable, i variable",
        16: "$TOOL variable*, TOOL_DATA variable", 17: "shared_count variable, shared_count variable, i variable",
        18: "helper function", 19: "again variable", 22: "helper function", 23: "i variable", 24: "i variable",
        25: "SPEED variable, i variable",
    }  # fmt: skip
    assert colors(project, MAIN, 7, 8) == {8: whole[8], 9: whole[9]}
    assert colors(project, MAIN, 24, 99) == {25: whole[25]}
    assert list(colors(project, CLOSE).values())[:4] == [
        "close_it function, g parameter, n parameter", "GRIP_T type, g parameter", "n parameter",
        "g parameter, state property, #SHUT enumMember",
    ]  # fmt: skip


def test_what_a_program_cannot_write_is_marked_and_items_are_told_from_arguments(project):
    data = "KRC/R1/Program/main.dat"
    project.set_text(data, FILES[data].replace("ENDDAT", "DECL CONST INT top=3\nENDDAT"))
    put(project, "i = top + {X f(i, 2), Y top, Z 1}", "LIN p q", "WAIT FOR $IN[top] AND (helper == strlen(close_it))")
    assert list(colors(project, MAIN, 18, 20).values()) == [
        "i variable, top variable!, X property, f function, i variable, Y property, top variable!, Z property",
        "$IN variable!*, top variable!, helper function, strlen function*, close_it function",
    ]


def hints(project, *lines, at="GOTO again"):
    line = put(project, *lines, at=at).line
    found = signal_hints(project.program(MAIN), project.project.file(MAIN), line - len(lines) + 1, line)
    return [(i - line + len(lines) - 1, column, text) for i, column, text in found]


def test_inputs_and_outputs_have_their_names_beside_them(project):
    project.set_text(CONFIG, FILES[CONFIG].replace("ENDDAT", SIGNALS))
    line = "WAIT FOR $IN[3] AND NOT $in[ 11 ] OR $IN[13]"
    named = [(15, "part_there"), (line.index("]", 20) + 1, "job bit 1"), (len(line), "job bit 3")]
    assert hints(project, line) == [(0, *x) for x in named]
    others = ("; $IN[3]", "&PARAM $IN[3]", "LIN p $IN[3]", "$OUT[3] = $IN[i] OR $IN[9] OR $IN[14] ; $IN[3]")
    assert hints(project, "$ANOUT[1] = 1.0", *others) == [(0, 9, "glue")]
    project.set_text(CONFIG, FILES[CONFIG].replace("ENDDAT", "SIGNAL again_there $IN[3]\n" + SIGNALS))
    assert hints(project, "WAIT FOR $IN[3]") == [(0, 15, "again_there, part_there")]
    assert hints(project, "SIGNAL mine $OUT[7]", at=";FOLD INI") == []
    assert hints(project, "$OUT[7] = $IN[3]", "x = $OUT[7") == [(0, 7, "mine"), (0, 16, "again_there, part_there")]
    program, file = project.program(MAIN), project.project.file(MAIN)
    assert len(list(signal_hints(program, file, -5, 99))) == 7
    assert list(signal_hints(program, file, 6, 5)) == []


SLIPS = {
    "a variable": ("LIN pick C_DIS", "LIN pik C_DIS"),
    "a subprogram": ("helper ( )", "helpre ( )"),
    "a constant": ("#OPEN THEN", "#OPENN THEN"),
    "a component": ("grip.state", "grip.stat"),
    "a keyword": ("ENDFOR", "ENDFRO"),
    "a name of the controller": ("$TOOL =", "$TOLL ="),
}


@pytest.mark.parametrize(("right", "wrong"), SLIPS.values(), ids=SLIPS)
def test_a_slip_is_mended_by_what_its_diagnosis_means(project, right, wrong):
    project.set_text(MAIN, FILES[MAIN].replace(right, wrong, 1))
    lines = project.texts[MAIN].split("\n")
    found = [(d.position.line - 1, fix) for d in project.diagnostics(MAIN)[MAIN]
             if (fix := quick_fix(lines[d.position.line - 1], d)) is not None]  # fmt: skip
    ((line, (first, last, new)),) = found
    lines[line] = lines[line][:first] + new + lines[line][last:]
    assert "\n".join(lines).upper() == FILES[MAIN].upper()


def test_a_diagnosis_that_means_no_word_or_stands_at_none_has_no_fix(project):
    text = put(project, "zzzz = #OPEN").text
    (found,) = project.diagnostics(MAIN)[MAIN]
    assert (found.code, quick_fix(text, found)) == ("undeclared", None)
    put(project, "LIN pik")
    found = project.diagnostics(MAIN)[MAIN][-1]
    assert [quick_fix(x, found) for x in ("LIN pik", "LIN ( )", "LIN # pik")] == [(4, 7, "pick"), None, (6, 9, "pick")]
