"""What is offered where; of hidden names drawn by a seed 99 of 100 are, within 50 ms."""

import random
from pathlib import Path

import pytest

from lwr_dyn.krl.editor.completions import completions
from lwr_dyn.krl.editor.edited_project import EditedProject
from tests.krl import planting
from tests.krl.recall_trial import recall_trial
from tests.krl.small_backup import CONFIG, put, write_backup

CELL = Path(planting.__file__).parent / "cell"
STEU = "KRC/STEU/$config.dat"


def offered(project, written, **place):
    """What is offered at the end of a line that is written, and the part of it that would be replaced."""
    start, found = completions(put(project, written, **place), len(written))
    return written[start:], found


def texts(project, written, **place):
    return {x.text.upper() for x in offered(project, written, **place)[1]}


STATES, GRIP = {"OPEN", "SHUT"}, {"STATE", "FORCE"}
PLACES = {
    "components of a variable": ("grip.", GRIP),
    "components while one is written": ("grip.st", GRIP),
    "components of an element": ("TOOL_DATA[i + f(2)].", set("XYZABC")),
    "components of a component of an element": ("boxes[2].grip[1].", GRIP),
    "no component of what is unknown": ("nix.state.", set()),
    "constants of the variable": ("grip.state = #", STATES),
    "constants in a comparison": ("IF grip.state == #OP", STATES),
    "items of an aggregate": ("pick = {X 1, ", {*"XYZABCST", *(f"E{i}" for i in range(1, 7))}),
    "items of a type that is written": ("x = {FRAME: X 1, ", set("XYZABC")),
    "items of a target, of whatever kind": ("PTP {", {*"XYZABCST", *(f"{k}{i}" for k in "AE" for i in range(1, 7))}),
    "items of an argument": ("close_it ({", GRIP),
    "items of an item": ("boxes[1] = {grip[1] {", GRIP),
    "a declaration's items": ("DECL GRIP_T g = {state #OPEN, ", GRIP),
    "a constant as an item's value": ("DECL GRIP_T g = {state #", STATES),
    "a constant as an argument": ("shut (#", STATES),
    "labels": ("GOTO a", {"AGAIN"}),
    "nothing in a comment": ("i = 1 ; gr", set()),
    "nothing in a text": ('x[] = "gr', set()),
    "nothing in a line of the file system": ("&ACCESS R", set()),
    "no component of a number": ("i = 1.", set()),
    "no component of a bracket": ("i = (1).", set()),
}


@pytest.mark.parametrize(("written", "expected"), PLACES.values(), ids=PLACES)
def test_what_is_offered_is_what_can_stand_there(project, written, expected):
    put(project, "STRUC BOX GRIP_T grip[3]", "DECL BOX boxes[2]", name=CONFIG, at="ENDDAT")
    put(project, "DEF shut(what:IN)", "DECL STATE_E what", "END", at="DEF helper")
    assert texts(project, written) == expected


def test_a_proposal_has_its_kind_and_type_and_the_nearest_stands_above(project):
    def described(written):
        replaced, found = offered(project, written)
        assert replaced == written.strip()
        assert all(x.text[: len(replaced)].upper() == replaced.upper() for x in found)
        return {x.text: (x.kind, x.detail, x.near) for x in found}

    some = {"shared_count": ("variable", "INT", False), "STATE_E": ("type", "ENUM", False),
            "SWITCH": ("keyword", "", False)}  # fmt: skip
    assert some.items() <= described("  s").items()
    some = {"pick": ("variable", "E6POS", True), "i": ("variable", "INT", True), "FOR": ("keyword", "", False),
            "helper": ("routine", "DEF helper( )", True)}  # fmt: skip
    whole = described("")
    assert some.items() <= whole.items()
    assert not any(x.startswith("$") for x in whole)  # those of the controller, once a dollar is written
    assert {"$IN": ("system", "BOOL[]", False)}.items() <= described("$I").items()
    found = [(x.text, x.kind, x.detail, x.near) for x in offered(project, "grip.")[1]]
    assert found == [("STATE", "component", "STATE_E of GRIP_T", True), ("FORCE", "component", "REAL of GRIP_T", True)]


def test_a_constant_of_a_parameter_comes_before_all_others(project):
    found = offered(project, "BAS(#")[1]
    assert {"INITMOV", "VEL_PTP"} <= {x.text for x in found if x.near and x.detail == "BAS_COMMAND"}
    assert all(x.near == (x.detail == "BAS_COMMAND") for x in found)


@pytest.mark.parametrize("end", [("ENDSWITCH",), ()])
def test_the_constants_of_a_case_are_those_of_its_switch_also_while_it_has_no_end(project, end):
    put(project, "SWITCH grip.state", "CASE #SHUT")
    if end:
        put(project, "SWITCH i", "CASE 1", "ENDSWITCH", "HALT", *end)
    assert texts(project, "CASE #", at="HALT" if end else "GOTO again") == STATES


def test_a_name_of_another_robot_is_not_offered(project):
    assert {"SPEED", "SHARED_COUNT"} <= texts(project, "s")
    assert "SHARED_COUNT" not in texts(project, "s", name=STEU, at="ENDDAT")


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
