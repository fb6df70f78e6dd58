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
    """The same with `--json`: what it prints agrees with its schema and comes out as it is read."""
    from lwr_dyn.cli.help_text import schema_file
    from tests.json_schemas import faults

    def run(*arguments):
        record = json.loads(printed(*arguments, "--json"))
        path = next(x for x in (" ".join(map(str, arguments[:2])), arguments[0]) if schema_file(x).is_file())
        assert faults(path, record) == []
        return record

    return run


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
