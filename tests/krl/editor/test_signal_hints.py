"""Beside an input or output stands its SIGNAL."""

from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.signal_hints import signal_hints
from tests.krl.small_backup import CONFIG, FILES, MAIN, write_backup

SIGNALS = "SIGNAL part_there $IN[3]\nSIGNAL job $IN[10] TO $IN[13]\nSIGNAL glue $ANOUT[1]\nSIGNAL off FALSE\nENDDAT"


def hints(project, *lines):
    at = FILES[MAIN].split("\n").index("GOTO again")
    project.set_text(MAIN, FILES[MAIN].replace("GOTO again", "\n".join([*lines, "GOTO again"])))
    found = signal_hints(project.program(MAIN), project.project.file(MAIN), at, at + len(lines) - 1)
    return [(line - at, column, text) for line, column, text in found]


def test_inputs_and_outputs_have_their_names(tmp_path):
    project = EditedProject(write_backup(tmp_path))
    project.set_text(CONFIG, FILES[CONFIG].replace("ENDDAT", SIGNALS))
    line = "WAIT FOR $IN[3] AND NOT $in[ 11 ]"
    assert hints(project, line) == [(0, 15, "part_there"), (0, len(line), "job bit 1")]
    assert hints(project, "$ANOUT[1] = 1.0", "; $IN[3]") == [(0, 9, "glue")]
    assert hints(project, "$OUT[3] = $IN[i] OR $IN[14] ; $IN[3]") == []


def test_two_names_of_one_input_and_those_of_a_routine_are_there(tmp_path):
    project = EditedProject(write_backup(tmp_path))
    project.set_text(CONFIG, FILES[CONFIG].replace("ENDDAT", "SIGNAL again_there $IN[3]\n" + SIGNALS))
    assert hints(project, "WAIT FOR $IN[3]") == [(0, 15, "again_there, part_there")]
    text = (
        FILES[MAIN]
        .replace("DECL INT i\n", "DECL INT i\nSIGNAL mine $OUT[7]\n", 1)
        .replace("GOTO again", "$OUT[7] = TRUE")
    )
    project.set_text(MAIN, text)
    (found,) = signal_hints(project.program(MAIN), project.project.file(MAIN), 0, 99)
    assert found[2] == "mine"
