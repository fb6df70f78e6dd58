"""Closed forms on the page: each text, with the arm's numbers for its letters, is the engine's entry."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.symbolic.equation_forms import named_entries
from lwr_dyn.pages.explorer.page_data import _read, closed_forms, length_values, letter_values
from tests.dynamics.symbolic.evaluated import LETTER, evaluated, state_letters
from tests.pages.explorer.explored import COMMITTED, explored_arm

LARGEST = 25_000
"""[bytes] of all texts of a page."""
AGREES = 1e-12
"""Of the largest value."""
WITH_TEXTS = [(robot, reading) for robot, reading in COMMITTED if reading in _read().get(robot, {}).get("readings", ())]


@pytest.mark.parametrize(("robot", "reading"), WITH_TEXTS)
def test_each_text_is_the_engines_entry(robot, reading):
    arm = lwr_dyn.load(robot, reading)
    found, dynamics = closed_forms(arm), lwr_dyn.dynamics_of(arm)
    assert len(found["texts"]) >= 7
    numbers = letter_values(arm) | length_values(arm, _read()[robot]["lengths"])
    for q, dq in np.random.default_rng(7).uniform(-2, 2, (3, 2, arm.n)):
        known = {"B": dynamics.mass_matrix(q), "C": dynamics.coriolis_matrix(q, dq), "g": dynamics.gravity_vector(q)}
        for name, text in found["texts"].items():
            letter, i, j = named_entries(arm.n)[name]
            expected = known[letter][i] if letter == "g" else known[letter][i, j]
            apart = abs(evaluated(text, numbers | state_letters(q, dq)) - expected)
            assert apart < AGREES * np.abs(known[letter]).max(), name


@pytest.mark.parametrize(("robot", "reading"), WITH_TEXTS)
def test_every_letter_has_a_number_and_all_fit_on_the_page(robot, reading):
    found = closed_forms(lwr_dyn.load(robot, reading))
    letters = {letter for text in found["texts"].values() for letter in LETTER.findall(text)}
    assert {letter for letter in letters if letter.lstrip("d")[0] != "q"} == set(found["values"])
    assert len(str(found)) * len(lwr_dyn.readings(robot)) < LARGEST


@pytest.mark.slow
def test_the_command_prints_an_entry_of_this_reading(capsys):
    command = closed_forms(lwr_dyn.load("lwr4plus", "physical"))["command"].replace("ENTRY", "B_77")
    assert command.endswith("print(e('lwr4plus', 'B_77', 'physical'))\"")
    exec(command.removeprefix('python -c "').removesuffix('"'), {})
    assert capsys.readouterr().out == "I7zz + Ia7\n"


def test_the_command_names_a_file_that_has_no_readings():
    arm = explored_arm("panda")
    assert closed_forms(arm)["command"].endswith(f"print(e({arm.file!r}, 'ENTRY'))\"")


def test_a_reading_with_other_angles_has_none():
    assert closed_forms(lwr_dyn.load("kr30ha", "printed"))["texts"] == {}


def test_an_arm_that_carries_or_lacks_something_has_none():
    for arm in (explored_arm("hung"), lwr_dyn.load("lwr4"), lwr_dyn.load("lwr4plus", lock={"joint_7": 0.2})):
        assert closed_forms(arm) == {"texts": {}, "values": {}, "command": ""}
    assert closed_forms(explored_arm("panda"))["texts"] == {}
