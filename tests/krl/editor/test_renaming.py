"""A name is changed everywhere it means the same, or not at all; what the checks say stays the same."""

import random
from pathlib import Path

import pytest

from lwr_dyn.krl.editor import renaming
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.renaming import KeptNameError, renamable, renamed
from tests.krl import planting
from tests.krl.rename_trial import random_backup, rename_trial, written
from tests.krl.small_backup import CLOSE, CONFIG, FILES, MAIN, place_of, put, write_backup

CELL = Path(planting.__file__).parent / "cell"
DATA = "KRC/R1/Program/main.dat"
PICK, FORCE, OPEN, COUNT = (
    (MAIN, "LIN pick", 0, "pick"), (CLOSE, "g.force", 0, "force"), (MAIN, "#OPEN", 0, "OPEN"),
    (MAIN, "shared_count = ", 0, "shared_count"),
)  # fmt: skip


def rename(project, new, name, text, nth=0, word=""):
    return renamed(project, renamable(project, name, *place_of(name, text, nth, word)), new)


@pytest.mark.parametrize(
    ("place", "count"),
    {
        "variable of a .dat": (PICK, 2),
        "variable of all": (COUNT, 4),
        "local": ((MAIN, "FOR i", 0, "i"), 4),
        "parameter": ((CLOSE, "g.state", 0, "g"), 4),
        "routine": ((MAIN, "helper ( )", 0, "helper"), 2),
        "type": ((CLOSE, "DECL GRIP_T", 0, "GRIP_T"), 3),
        "component": (FORCE, 2),
        "constant": (OPEN, 2),
        "label": ((MAIN, "GOTO again", 0, "again"), 2),
    }.values(),
)
@pytest.mark.parametrize("new", ["other", "a_name_of_24_characters_"])
def test_all_places_of_a_name_are_changed(project, place, count, new):
    uses = rename(project, new, *place)
    assert len(uses) == count
    after = project.with_texts(written(project, uses, len(place[3]), new))
    for name in FILES:
        assert after.diagnostics(name) == project.diagnostics(name) == {x: () for x in after.diagnostics(name)}
    assert new in "".join(x.shown for x in after.project.file(place[0]).file.lines)


FORM = ";FOLD PTP pick Vel=100 % ;%{PE}%R 5\nPTP pick\n;ENDFOLD"
TWIN = "DEFDAT two PUBLIC\nDECL GLOBAL INT shared_count=1\nENDDAT\n"
KEPT = {
    "of the controller": ("x", (MAIN, "$TOOL"), "$TOOL comes with the controller or an option, and keeps its name"),
    "a function of it": ("x", (MAIN, "BAS (#"), "BAS comes with the controller or an option, and keeps its name"),
    "of its structure": ("x", (DATA, "S 2"), "S comes with the controller or an option, and keeps its name"),
    "of a file": ("x", (MAIN, "close_it ("), f"close_it is the name of {CLOSE}: rename the .src, its .dat and DEFDAT"),
    "no name": ("x", (MAIN, "FOR i"), "no name that the program declares stands here"),
    "a keyword": ("wait", PICK, "wait is a keyword"),
    "no word": ("2nd", PICK, "'2nd' is no name: letters, digits and _, no digit first, $ is the controller's"),
    "a name of it": ("$mine", PICK, "'$mine' is no name: letters, digits and _, no digit first, $ is the controller's"),
    "too long": ("x" * 25, PICK, f"{'x' * 25} has 25 characters; at most 24 are allowed"),
    "taken": ("speed", PICK, f"speed is taken, as {MAIN} sees it in line 11"),
    "taken by the controller": ("strlen", PICK, f"strlen is taken, as {MAIN} sees it in line 11"),
    "taken by a component": ("state", FORCE, f"state is taken, as {CLOSE} sees it in line 5"),
    "taken by a constant": ("shut", OPEN, f"shut is taken, as {MAIN} sees it in line 12"),
}
KEPT_WITH = {
    "in an inline form": ("other", PICK, FORM, f"an inline form holds pick ({MAIN}, line 20): change it on the teach "
                          "pendant"),
    "of an unknown structure": ("other", FORCE, "unknown_one.force = 1", f"{MAIN}, line 19 may mean this force or "
                                "another: its type is not known here"),
    "not declared yet": ("caught", PICK, "caught = 1", f"caught is used in {MAIN}, line 19, where nothing declares it"),
    "a label": ("caught", (MAIN, "again:", 0, "again"), "caught:", f"caught is taken, as {MAIN} sees it in line 9"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("new", "place", "line", "why"),
    [*((new, place, "", why) for new, place, why in KEPT.values()), *KEPT_WITH.values()],
    ids=[*KEPT, *KEPT_WITH],
)
def test_a_name_that_stays_says_why(project, new, place, line, why):
    if line:
        put(project, line)
    with pytest.raises(KeptNameError) as kept:
        rename(project, new, *place)
    assert str(kept.value) == why


def test_of_a_name_that_is_declared_twice_no_use_is_certain(project):
    with pytest.raises(KeptNameError, match=r"shared_count.*which of them a use means is not certain, rename by"):
        rename(project.with_texts({"KRC/R1/Program/two.dat": TWIN}), "other", *COUNT)
    put(project, "ENUM DOOR_E OPEN, AJAR", name=CONFIG, at="STRUC")
    with pytest.raises(KeptNameError, match="#OPEN belongs to several ENUMs; which one is meant is not written here"):
        rename(project, "other", *OPEN)


def test_a_change_that_would_catch_other_places_is_found_out(project, monkeypatch):
    """With the checks before it out of the way, the proof alone still says no."""
    for name in ("_check_taken", "_check_uses"):
        monkeypatch.setattr(renaming, name, lambda *_: None)
    with pytest.raises(KeptNameError, match="with the name grip, some places would mean something else than i does"):
        rename(project, "grip", MAIN, "FOR i", 0, "i")


def test_only_the_case_of_letters_may_change_and_a_fold_that_is_no_inline_form_does_not_keep_a_name(project):
    assert len(rename(project, "PICK", *PICK)) == 2
    put(project, FORM.replace("%{PE}%R 5", ""))
    assert len(rename(project, "other", *PICK)) == 3


def test_a_member_that_is_spelt_as_a_variable_is_not_that_variable(project):
    line = put(project, "DECL INT state=1", name=CONFIG, at="ENDDAT").line
    uses = renamed(project, renamable(project, CONFIG, line, len("DECL INT s")), "other")
    assert [(x.file, x.line) for x in uses] == [(CONFIG, line + 1)]


def test_renames_drawn_by_a_seed_change_no_diagnosis(tmp_path):
    """The whole: scripts/soak.py rename."""
    small = rename_trial(EditedProject(write_backup(tmp_path)), random.Random(3), 15)
    assert (small.renamed, small.changed, bool(small.kept)) == (15, [], True)


def test_where_modules_see_each_other_in_part_no_name_is_caught(tmp_path):
    found = [rename_trial(random_backup(random.Random(seed), tmp_path), random.Random(seed), 4) for seed in range(6)]
    assert sum(x.renamed for x in found) > 10
    assert [x.changed for x in found if x.changed] == []
    assert any("is taken" in why or "mean" in why for x in found for why in x.kept)


@pytest.mark.slow
def test_renames_in_a_cell_change_no_diagnosis():
    found = rename_trial(EditedProject(CELL), random.Random(3), 60)
    assert (found.renamed, found.changed) == (60, [])
