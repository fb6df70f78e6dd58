"""An option means one thing in all commands: one type, one form, one unit, one line of words."""

import re
from collections import defaultdict

import click
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.help_text import ROBOT_OPTIONS
from lwr_dyn.cli.options import OneOf, option
from lwr_dyn.cli.renamed import RENAMED
from lwr_dyn.cli.vocabulary import VOCABULARY, Word, given_positions, shared
from lwr_dyn.foundation.errors import OptionError
from tests.custody.test_help_text import SINGLE
from tests.optional import need


def options_by_name(commands=SINGLE):
    """Option -> command path -> click's option; those of click itself are left out."""
    found = defaultdict(dict)
    for path, command in commands.items():
        for param in command.params:
            if isinstance(param, click.Option) and "--help" not in param.opts:
                found[max(param.opts, key=len)][path] = param
    return found


def kind_of(param):
    """What tells one type from another: a range and its ends, a list of numbers, one of some names."""
    if isinstance(param.type, click.Choice):
        return OneOf
    return bool if param.is_flag else str(param.type) if isinstance(param.type, click.IntRange) else param.type.name


def faults(name, params, vocabulary=VOCABULARY):
    """What is said of an option in two ways: none where all commands say the same, or agree with its row."""
    said = {(kind_of(x), x.metavar, x.multiple, x.help) for x in params.values()}
    if name not in vocabulary:
        return [] if len(said) == 1 else [f"{name} has {len(said)} meanings and no row: {sorted(params)}"]
    word = vocabulary[name]
    model = option(name, "", word.kind) if word.kind is not OneOf else option(name, "", OneOf([]))
    out = []
    for path, param in params.items():
        of_type = (kind_of(param), param.multiple) == (kind_of(model), word.repeatable) and param.metavar in word.forms
        of_words = word.words.lower() in param.help.lower() and word.unit in param.help
        out += [] if of_type else [f"{path} {name}: another type or form, {kind_of(param)} {param.metavar}"]
        out += [] if of_words else [f"{path} {name}: other words or unit, {param.help}"]
    return out


@pytest.mark.parametrize("name", options_by_name())
def test_an_option_means_one_thing_in_all_commands(name):
    assert faults(name, options_by_name()[name]) == []


def test_the_table_holds_what_several_commands_share():
    need("llvmlite")  # of kernels, sweep, tune
    names = options_by_name()
    assert {name for name in VOCABULARY if len(names[name]) < 2} == set()


OTHER = {
    "type": shared("--jobs", kind=int),
    "form": shared("--jobs", form="COUNT"),
    "words": option("--jobs", "Seconds that a run may take.", click.IntRange(1), metavar="N"),
}


@pytest.mark.parametrize("what", OTHER)
def test_a_second_meaning_is_found(what):
    assert faults("--jobs", {"sweep": shared("--jobs"), "tune": shared("--jobs", "; all if not given")}) == []
    found = faults("--jobs", {"sweep": shared("--jobs"), "tune": OTHER[what]})
    assert [text.startswith("tune --jobs: ") for text in found] == [True]
    assert len(faults("--jobs", {"sweep": shared("--jobs"), "tune": OTHER[what]}, {})) == 1


def test_a_unit_stands_in_the_words():
    load = {"--load": Word("Mass at the flange", float, "kg")}
    said = {text: option("--load", text, float) for text in ("Mass at the flange, kg.", "Mass at the flange, g.")}
    assert load["--load"].text(" that is known") == "Mass at the flange that is known, kg."
    assert load["--load"].text(" of it; 0 if not given") == "Mass at the flange of it, kg; 0 if not given."
    assert load["--load"].text() == "Mass at the flange, kg."
    assert [len(faults("--load", {"simulate": param}, load)) for param in said.values()] == [0, 1]


OF_FILES = {"--file", "--waypoints", "--units"}
"""Options whose words name units of columns in files."""
IN_KUKAS_UNITS = {"--tool-data", "--base-data"}
"""Frames as KUKA writes them, mm and deg, as the form of their value says."""


def test_a_unit_that_is_not_si_stands_in_the_name():
    for name, params in options_by_name().items():
        texts = [param.help for param in params.values() if not param.is_flag]
        units = {unit for text in texts for unit in re.findall(r"(?<![_\w])(deg|mm)\b", text)}
        if name in IN_KUKAS_UNITS:
            assert {param.metavar for param in params.values()} == {"X,Y,Z,A,B,C"}
        elif name not in OF_FILES:
            assert units <= set(name.split("-")[-1:]), name


def test_joint_positions_are_given_in_either_unit_everywhere():
    names = options_by_name()
    assert set(names["--q"]) == set(names["--q-deg"]) == {"fk", "margins", "show"}
    wam = lwr_dyn.load("wam7")
    assert given_positions(wam, None, None) is None
    right = (0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert (given_positions(wam, None, right) == given_positions(wam, tuple(np.radians(right)), None)).all()
    with pytest.raises(OptionError, match="--q, --q-deg: both given; allowed: one of them"):
        given_positions(wam, (0.0,) * 7, (0.0,) * 7)


BY_NAME = {"list", "conventions", "new study"}
"""Commands of a table or a file that names the robot: no arm is loaded for more than its name and reading."""


OF_PROGRAMS = {"krl check", "krl run", "krl write"}
"""Commands that take a robot with a program."""


def test_a_robot_is_the_first_argument_with_all_options_that_load_it():
    """Not of papers, and commands of several robots or files; a program names its robot (krl), or `--robot` does."""
    for path, command in SINGLE.items():
        arguments = [param for param in command.params if isinstance(param, click.Argument)]
        options = {param.opts[0] for param in command.params}
        if "robot" in [argument.name for argument in arguments] and path not in BY_NAME:
            assert arguments[0].name == "robot"
            assert set(ROBOT_OPTIONS) - {"--robot"} <= options, path
        else:
            assert ("--robot" in options) == (path in OF_PROGRAMS)
            assert path not in OF_PROGRAMS or set(ROBOT_OPTIONS) <= options, path
            assert path in BY_NAME | OF_PROGRAMS or "--reading" not in options


def test_old_names_are_free():
    """An old name may stand in another command, with its one meaning there."""
    names = options_by_name()
    for path, old in ((path, old) for path, rows in RENAMED.items() for old in rows):
        assert path not in names.get(old, {})
