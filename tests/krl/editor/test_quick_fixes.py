"""What a diagnosis means is written in the place of the wrong word, and the diagnosis is gone."""

import pytest

from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.quick_fixes import quick_fix
from tests.krl.small_backup import FILES, MAIN, write_backup

SLIPS = {
    "a variable": ("LIN pick C_DIS", "LIN pik C_DIS"),
    "a subprogram": ("helper ( )", "helpre ( )"),
    "a constant": ("#OPEN THEN", "#OPENN THEN"),
    "a component": ("grip.state", "grip.stat"),
    "a keyword": ("ENDFOR", "ENDFRO"),
    "a name of the controller": ("$TOOL =", "$TOLL ="),
}


@pytest.mark.parametrize("what", SLIPS)
def test_a_slip_is_mended(tmp_path, what):
    right, wrong = SLIPS[what]
    project = EditedProject(write_backup(tmp_path))
    project.set_text(MAIN, FILES[MAIN].replace(right, wrong, 1))
    lines = project.texts[MAIN].split("\n")
    found = [(d.position.line - 1, fix) for d in project.diagnostics(MAIN)[MAIN]
             if (fix := quick_fix(lines[d.position.line - 1], d)) is not None]  # fmt: skip
    ((line, (first, last, new)),) = found
    lines[line] = lines[line][:first] + new + lines[line][last:]
    assert "\n".join(lines).upper() == FILES[MAIN].upper()


def test_a_diagnosis_that_means_no_word_has_no_fix(tmp_path):
    project = EditedProject(write_backup(tmp_path))
    project.set_text(MAIN, FILES[MAIN].replace("shared_count = shared_count + i", "zzzz = #OPEN"))
    lines = project.texts[MAIN].split("\n")
    found = project.diagnostics(MAIN)[MAIN]
    assert found
    assert [quick_fix(lines[d.position.line - 1], d) for d in found] == [None] * len(found)
