"""A name is changed everywhere it means the same, or not at all; what the checks say stays the same."""

import random
from pathlib import Path

import pytest

from lwr_dyn.krl.editor import renaming
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.renaming import KeptNameError, renamable, renamed
from tests.krl import planting
from tests.krl.rename_trial import random_backup, rename_trial, written
from tests.krl.small_backup import CLOSE, CONFIG, FILES, MAIN, place_of, write_backup

CELL = Path(planting.__file__).parent / "cell"


@pytest.fixture
def project(tmp_path):
    return EditedProject(write_backup(tmp_path))


def rename(project, new, name, text, nth=0, word=""):
    return renamed(project, renamable(project, name, *place_of(name, text, nth, word)), new)


def short(uses):
    return [(x.file.rsplit("/", 1)[1], x.line) for x in uses]


@pytest.mark.parametrize(
    ("place", "count"),
    {
        "variable of a .dat": ((MAIN, "LIN pick", 0, "pick"), 2),
        "variable of all": ((MAIN, "shared_count = ", 0, "shared_count"), 4),
        "local": ((MAIN, "FOR i", 0, "i"), 4),
        "parameter": ((CLOSE, "g.state", 0, "g"), 4),
        "routine": ((MAIN, "helper ( )", 0, "helper"), 2),
        "type": ((CLOSE, "DECL GRIP_T", 0, "GRIP_T"), 3),
        "component": ((CLOSE, "g.force", 0, "force"), 2),
        "constant": ((MAIN, "#OPEN", 0, "OPEN"), 2),
        "label": ((MAIN, "GOTO again", 0, "again"), 2),
    }.values(),
)
def test_all_places_of_a_name_are_changed(project, place, count):
    uses = rename(project, "other", *place)
    assert len(uses) == count
    word = place[3].lstrip("#")
    after = project.with_texts(written(project, uses, len(word), "other"))
    for name in FILES:
        assert after.diagnostics(name) == project.diagnostics(name) == {x: () for x in after.diagnostics(name)}
    text = "".join(x.shown for x in after.project.file(place[0]).file.lines)
    assert "other" in text


KEPT = {
    "of the controller": ("x", (MAIN, "$TOOL", 0, ""), "comes with the controller"),
    "a function of the controller": ("x", (MAIN, "BAS (#", 0, "BAS"), "comes with the controller"),
    "of the controller's structure": ("x", (MAIN, "S 2", 0, "S"), "comes with the controller"),
    "of a file": ("x", (MAIN, "close_it (", 0, ""), "is the name of KRC/R1/Program/close_it.src"),
    "no name": ("x", (MAIN, "FOR i", 0, "FOR"), "no name"),
    "a keyword": ("wait", (MAIN, "LIN pick", 0, "pick"), "is a keyword"),
    "no word": ("2nd", (MAIN, "LIN pick", 0, "pick"), "is no name"),
    "of the controller, as the new one": ("$mine", (MAIN, "LIN pick", 0, "pick"), "$ is the controller's"),
    "too long": ("x" * 25, (MAIN, "LIN pick", 0, "pick"), "25 characters"),
    "taken": ("speed", (MAIN, "LIN pick", 0, "pick"), "taken, as KRC/R1/Program/main"),
    "taken by the controller": ("strlen", (MAIN, "LIN pick", 0, "pick"), "is taken"),
    "taken by a component": ("state", (CLOSE, "g.force", 0, "force"), "is taken"),
    "taken by a constant": ("shut", (MAIN, "#OPEN", 0, "OPEN"), "is taken"),
}


@pytest.mark.parametrize("what", KEPT)
def test_a_name_that_stays_says_why(project, what):
    new, place, why = KEPT[what]
    name = place[0].replace(".src", ".dat") if what == "of the controller's structure" else place[0]
    with pytest.raises(KeptNameError, match=why.replace("$", r"\$")):
        rename(project, new, name, *place[1:])


def test_a_name_in_an_inline_form_is_left_to_the_teach_pendant(project):
    form = ";FOLD PTP pick Vel=100 % ;%{PE}%R 5\nPTP pick\n;ENDFOLD\n"
    project.set_text(MAIN, FILES[MAIN].replace("GOTO again\n", form + "GOTO again\n"))
    with pytest.raises(KeptNameError, match=r"an inline form holds pick \(KRC/R1/Program/main.src, line 20\)"):
        rename(project, "other", MAIN, "LIN pick", 0, "pick")
    project.set_text(MAIN, FILES[MAIN].replace("GOTO again\n", form.replace("%{PE}%R 5", "") + "GOTO again\n"))
    assert len(rename(project, "other", MAIN, "LIN pick", 0, "pick")) == 3


def test_a_component_of_an_unknown_structure_keeps_all_of_its_name(project):
    project.set_text(MAIN, FILES[MAIN].replace("GOTO again\n", "unknown_one.force = 1\nGOTO again\n"))
    with pytest.raises(KeptNameError, match="may mean this force or another"):
        rename(project, "other", CLOSE, "g.force", 0, "force")


def test_a_name_that_nothing_declares_yet_is_not_caught(project):
    project.set_text(MAIN, FILES[MAIN].replace("GOTO again\n", "caught = 1\nGOTO again\n"))
    with pytest.raises(KeptNameError, match=r"caught is used in KRC/R1/Program/main.src, line 19, where nothing"):
        rename(project, "caught", MAIN, "LIN pick", 0, "pick")


def test_of_a_name_that_is_global_in_two_modules_no_use_is_certain(project):
    twin = {"KRC/R1/Program/two.dat": "DEFDAT two PUBLIC\nDECL GLOBAL INT shared_count=1\nENDDAT\n"}
    with pytest.raises(KeptNameError, match="which of them a use means is not certain"):
        rename(project.with_texts(twin), "other", MAIN, "shared_count = ", 0, "shared_count")


def test_a_change_that_would_catch_other_places_is_found_out(project, monkeypatch):
    """With the checks before it out of the way, the proof alone still says no."""
    for name in ("_check_taken", "_check_uses"):
        monkeypatch.setattr(renaming, name, lambda *_: None)
    with pytest.raises(KeptNameError, match="would mean something else"):
        rename(project, "grip", MAIN, "FOR i", 0, "i")


def test_only_the_case_of_letters_may_change(project):
    assert len(rename(project, "PICK", MAIN, "LIN pick", 0, "pick")) == 2


def test_a_member_that_is_spelt_as_a_variable_is_not_that_variable(project):
    text = FILES[CONFIG].replace("ENDDAT", "DECL INT state=1\nENDDAT")
    project.set_text(CONFIG, text)
    line = text.split("\n").index("DECL INT state=1")
    state = renamable(project, CONFIG, line, len("DECL INT s"))
    assert short(renamed(project, state, "other")) == [("$config.dat", line + 1)]


def test_renames_drawn_by_a_seed_change_no_diagnosis(tmp_path):
    """The whole: scripts/soak.py rename."""
    small = rename_trial(EditedProject(write_backup(tmp_path)), random.Random(3), 15)
    assert (small.renamed, small.changed) == (15, [])
    assert small.kept


def test_where_modules_see_each_other_in_part_no_name_is_caught(tmp_path):
    found = [rename_trial(random_backup(random.Random(seed), tmp_path), random.Random(seed), 4) for seed in range(6)]
    assert sum(x.renamed for x in found) > 10
    assert [x.changed for x in found if x.changed] == []
    assert any("is taken" in why or "mean" in why for x in found for why in x.kept)


@pytest.mark.slow
def test_renames_in_a_cell_change_no_diagnosis():
    found = rename_trial(EditedProject(CELL), random.Random(3), 60)
    assert (found.renamed, found.changed) == (60, [])
