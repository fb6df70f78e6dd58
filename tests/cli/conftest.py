"""A command that takes its input, as text or as its record, and one that refuses it."""

import json

import pytest


@pytest.fixture
def printed(lwr_dyn_command):
    """The command as a function: it exits with code 0 and says nothing beside what it prints, which comes out."""

    def run(*arguments):
        code, out, err = lwr_dyn_command(*arguments)
        assert (code, err) == (0, "")
        return out

    return run


@pytest.fixture
def recorded(printed):
    """The same with `--json`: what it prints comes out as it is read."""
    return lambda *arguments: json.loads(printed(*arguments, "--json"))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder in which the command runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def refused(lwr_dyn_command):
    """The command as a function: it exits with code 2 and prints nothing but one line, which comes out."""

    def run(*arguments):
        code, out, err = lwr_dyn_command(*arguments)
        assert (code, out, err.count("\n")) == (2, "", 1), err
        return err

    return run
