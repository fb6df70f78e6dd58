"""What `--help` leads with: commands in groups, few options in full and the names of all others."""

import click
import pytest

from lwr_dyn.cli.help_text import FURTHER, HELP_ALL, grouped, help_texts
from lwr_dyn.cli.main import COMMANDS

LINES = {"simulate": 60, "compare": 65, "margins": 60}


def test_every_command_stands_in_one_group():
    listed = [name for names in help_texts()[""]["commands"].values() for name in names]
    assert sorted(listed) == sorted(COMMANDS.names)


def test_commands_of_other_packages_come_last_and_groups_without_commands_are_left_out():
    found = grouped("", ["mine", "check", "urdf"])
    assert list(found.items()) == [("A robot from tables or a URDF", ["urdf", "check"]), (FURTHER, ["mine"])]
    assert grouped("krl", ["run", "check"]) == {"Commands": ["run", "check"]}


@pytest.mark.parametrize("name", LINES)
def test_short_help_fits_a_screen_and_names_every_option_once(name, lwr_dyn_command):
    code, out, _ = lwr_dyn_command(name, "--help")
    assert (code, len(out.splitlines()) <= LINES[name]) == (0, True), len(out.splitlines())
    words = [word.rstrip(",") for word in out.split()]
    options = [param.opts[0] for param in COMMANDS.load(name).params if isinstance(param, click.Option)]
    shown = out.partition("Examples:")[0].split()
    missing = [option for option in options if option not in shown]
    assert missing == [], words
    names = out.partition("More options")[2].partition("\n\n")[0].split()
    assert len([x for x in names if x.startswith("--")]) == len({x for x in names if x.startswith("--")})


@pytest.mark.parametrize("name", LINES)
def test_all_options_are_explained_where_that_is_asked(name, lwr_dyn_command):
    code, out, _ = lwr_dyn_command(name, HELP_ALL)
    assert code == 0
    assert "More options" not in out
    for param in COMMANDS.load(name).params:
        if isinstance(param, click.Option) and param.help:
            assert "".join(param.help.split()[:4]) in "".join(out.split()), param.opts


def test_short_lists_name_options_that_exist():
    for path, text in help_texts().items():
        if "short" in text:
            there = {opt for param in COMMANDS.load(path).params for opt in param.opts} | {"--help"}
            assert set(text["short"]) <= there, path
