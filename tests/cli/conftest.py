"""A command that takes its input, as text or as its record, one that refuses it, and what it asks of the library."""

import json
from dataclasses import replace

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
def as_recorded():
    """What a command records of a document of the library, behind the caveats of these arms."""
    from lwr_dyn.foundation.tables import json_text
    from lwr_dyn.model.arm import caveats_of

    def record(document, *arms, used=None):
        if arms:
            caveats = caveats_of(arms) if used is None else caveats_of(arms, used)
            document = replace(document, caveats=tuple(dict.fromkeys((*(document.caveats or ()), *caveats))))
        return json.loads(json_text(document.record()))

    return record


@pytest.fixture
def asked(monkeypatch):
    """Puts a stand-in in the place of a function of the library: gives the list of its calls, (arguments, options)."""

    def stand_in(place, result=None):
        calls = []

        def called(*arguments, **options):
            calls.append((arguments, options))
            if isinstance(result, Exception):
                raise result
            return result

        monkeypatch.setattr(place, called)
        return calls

    return stand_in


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
