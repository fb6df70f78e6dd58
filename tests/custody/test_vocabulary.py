"""An option means one thing in all commands: one type, one form, one unit, one line of words."""

from collections import defaultdict

import click
import pytest

from lwr_dyn.cli.options import OneOf, option
from lwr_dyn.cli.vocabulary import VOCABULARY, Word, shared
from tests.custody.test_help_text import SINGLE

EXCEPTIONS = {
    "--controller": "a law by its name (simulate, margins), or one of the study's with its options (tune)",
    "--convention": "one of two names (dh), or a text (new arm, new paper)",
    "--timing": "of one paper's runs, a text (reproduce), or an option of tasks",
}
"""Option -> why its name still has two meanings; one that has one meaning must go from here."""


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
    found = faults(name, options_by_name()[name])
    if name in EXCEPTIONS:
        assert found, f"{name} has one meaning now: take it from EXCEPTIONS"
    else:
        assert found == []


def test_the_table_holds_what_several_commands_share():
    names = options_by_name()
    assert {name for name in VOCABULARY if len(names[name]) < 2} == set()
    assert set(EXCEPTIONS) <= set(names)


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
    assert [len(faults("--load", {"simulate": param}, load)) for param in said.values()] == [0, 1]
