"""What each name of a program means."""

from lwr_dyn.krl.editor.coloring import MEANINGS, OF_CONTROLLER, READ_ONLY, colored
from lwr_dyn.krl.editor.edited_project import EditedProject
from tests.krl.small_backup import CLOSE, FILES, MAIN, write_backup


def colors(project, name, *lines):
    text = FILES[name].split("\n") if name not in project.texts else project.texts[name].split("\n")
    found = colored(project.program(name), project.project.file(name), *lines)
    return {text[i][c : c + n]: (MEANINGS[kind], marks) for i, c, n, kind, marks in found}


def test_names_have_the_colours_of_what_they_mean(tmp_path):
    project = EditedProject(write_backup(tmp_path))
    found = colors(project, MAIN)
    assert found["close_it"] == found["helper"] == ("function", 0)
    assert found["BAS"] == ("function", OF_CONTROLLER)
    assert found["$TOOL"] == ("variable", OF_CONTROLLER)
    assert found["GRIP_T"] == ("type", 0)
    assert found["state"] == ("property", 0)
    assert found["#OPEN"] == ("enumMember", 0)
    assert found["i"] == found["shared_count"] == ("variable", 0)
    assert colors(project, CLOSE)["g"] == ("parameter", 0)
    assert set(colors(project, MAIN, 7, 8)) == {"XHOME", "again"}


def test_what_a_program_cannot_write_is_marked(tmp_path):
    project = EditedProject(write_backup(tmp_path))
    data = "KRC/R1/Program/main.dat"
    project.set_text(data, FILES[data].replace("ENDDAT", "DECL CONST INT top=3\nENDDAT"))
    project.set_text(MAIN, FILES[MAIN].replace("GOTO again", "i = top + {X 1, Y top}\nWAIT FOR $IN[top]\nGOTO again"))
    found = colors(project, MAIN)
    assert found["top"] == ("variable", READ_ONLY)
    assert found["$IN"] == ("variable", READ_ONLY | OF_CONTROLLER)
    assert found["X"] == ("property", 0)
