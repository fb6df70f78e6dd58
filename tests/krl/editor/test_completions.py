"""What is offered where; of hidden names drawn by a seed 99 of 100 are, within 50 ms."""

import random
from pathlib import Path

import pytest

from lwr_dyn.krl.editor.completions import completions
from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.editor.referents import line_context
from tests.krl import planting
from tests.krl.recall_trial import recall_trial
from tests.krl.small_backup import CONFIG, FILES, MAIN, write_backup

CELL = Path(planting.__file__).parent / "cell"


@pytest.fixture
def project(tmp_path):
    return EditedProject(write_backup(tmp_path))


def offered(project, written, after="shared_count = shared_count + i", name=MAIN):
    """What is offered at the end of a line that is written behind another one, and where it would begin."""
    lines = FILES[name].split("\n")
    at = next(i for i, x in enumerate(lines) if after in x) + 1
    project.set_text(name, "\n".join([*lines[:at], written, *lines[at:]]))
    context = line_context(project.program(name), project.project.file(name), at)
    start, found = completions(context, len(written))
    return written[start:], found


def texts(project, written, **more):
    return {x.text.upper() for x in offered(project, written, **more)[1]}


PLACES = {
    "components of a variable": ("grip.", {"STATE", "FORCE"}),
    "components while one is written": ("grip.st", {"STATE", "FORCE"}),
    "components of an element": ("TOOL_DATA[i + f(2)].", set("XYZABC")),
    "constants of the variable": ("grip.state = #", {"OPEN", "SHUT"}),
    "constants in a comparison": ("IF grip.state == #OP", {"OPEN", "SHUT"}),
    "items of an aggregate": ("pick = {X 1, ", {*"XYZABCST", *(f"E{i}" for i in range(1, 7))}),
    "items of a type that is written": ("x = {FRAME: X 1, ", set("XYZABC")),
    "a declaration's items": ("DECL GRIP_T g = {state #OPEN, ", {"STATE", "FORCE"}),
    "a constant as an item's value": ("DECL GRIP_T g = {state #", {"OPEN", "SHUT"}),
    "labels": ("GOTO a", {"AGAIN"}),
    "nothing in a comment": ("i = 1 ; gr", set()),
    "nothing in a text": ('x[] = "gr', set()),
    "nothing in a line of the file system": ("&ACCESS R", set()),
    "no component of a number": ("i = 1.", set()),
}


@pytest.mark.parametrize("what", PLACES)
def test_what_is_offered_is_what_can_stand_there(project, what):
    written, expected = PLACES[what]
    assert texts(project, written) == expected


def test_a_constant_of_a_parameter_comes_before_all_others(project):
    found = texts(project, "BAS(#")
    assert {"INITMOV", "VEL_PTP"} <= found
    assert "SHUT" not in found or offered(project, "BAS(#")[1][0].near


def test_the_constants_of_a_case_are_those_of_its_switch(project):
    text = "SWITCH grip.state"
    lines = FILES[MAIN].replace("helper ( )\n", f"{text}\nCASE #OPEN\nENDSWITCH\nhelper ( )\n", 1)
    project.set_text(MAIN, lines)
    at = lines.split("\n").index("CASE #OPEN")
    context = line_context(project.program(MAIN), project.project.file(MAIN), at)
    assert {x.text for x in completions(context, len("CASE #"))[1]} == {"OPEN", "SHUT"}


def test_names_are_those_with_the_first_letter_and_the_nearest_come_first(project):
    written, found = offered(project, "  sh")
    assert written == "sh"
    assert all(x.text[0].upper() == "S" for x in found)
    by_name = {x.text: x for x in found}
    assert {"shared_count", "SPEED", "SWITCH", "STRLEN"} <= set(by_name)
    assert not by_name["SPEED"].near
    assert next(x for x in offered(project, "p")[1] if x.text == "pick").near


def test_names_of_the_controller_are_offered_once_a_dollar_is_written(project):
    assert not any(x.startswith("$") for x in texts(project, ""))
    assert {"$IN", "$INTERRUPT"} <= texts(project, "$I")
    assert "$TOOL" not in texts(project, "$I")


def test_a_name_of_another_robot_is_not_offered(project):
    assert {"SPEED", "SHARED_COUNT"} <= texts(project, "s")
    assert "SHARED_COUNT" not in texts(project, "s", name="KRC/STEU/$config.dat", after="SPEED")


@pytest.mark.parametrize("folder", ["small", "cell"])
def test_of_hidden_names_99_in_100_are_offered(tmp_path, folder):
    """The whole: scripts/soak.py completion. The times are those of the processor."""
    found = recall_trial(EditedProject(CELL if folder == "cell" else write_backup(tmp_path)), random.Random(7), 200)
    assert found.share >= 0.99, found.missed
    assert sorted(found.seconds)[-3] < 0.05


def test_a_name_that_nothing_declares_any_more_is_missed(project):
    """The trial can fail: without $config.dat its names are not offered."""
    project.set_text(CONFIG, "DEFDAT $CONFIG\nENDDAT\n")
    assert recall_trial(project, random.Random(7), 200).share < 0.9
