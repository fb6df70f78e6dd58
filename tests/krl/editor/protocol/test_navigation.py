"""What stands where, asked for as an editor does: highlights, symbols of the folder, calls."""

from pathlib import Path

import pytest

from tests.krl.language_client import LanguageClient
from tests.krl.small_backup import CLOSE, CONFIG, FILES, MAIN, place_of

READ, WRITE = 2, 3


def at(text, nth=0, word="", name=MAIN):
    line, column = place_of(name, text, nth, word)
    return line, column - 1


def test_uses_within_the_file_are_marked_with_those_that_write(client, backup):
    found = client.ask("documentHighlight", backup / MAIN, *at("shared_count = "))
    places = [(x["range"]["start"]["line"], x["range"]["start"]["character"], x["kind"]) for x in found]
    line = at("shared_count = ")[0]
    assert places == [(line, 0, WRITE), (line, len("shared_count = "), READ)]
    kinds = [x["kind"] for x in client.ask("documentHighlight", backup / MAIN, *at("$TOOL"))]
    assert kinds == [WRITE]


def test_a_component_is_defined_where_its_structure_lists_it(client, backup):
    there = client.ask("definition", backup / MAIN, *at("grip.state", word="state"))
    line, column = place_of(CONFIG, "STATE_E state", word="state")
    assert there["uri"].endswith("config.dat")
    assert there["range"]["start"] == {"line": line, "character": column - 1}


def test_symbols_of_the_folder_begin_with_what_is_asked_for_first(client):
    found = client.request("workspace/symbol", {"query": "e"})
    names = [x["name"] for x in found]
    assert {"close_it", "helper", "GRIP_T", "SPEED", "shared_count"} - set(names) == {"GRIP_T"}
    first = client.request("workspace/symbol", {"query": "S"})
    assert [x["name"][0].upper() for x in first[:2]] == ["S", "S"]
    (place,) = client.request("workspace/symbol", {"query": "helper"})
    line, column = at("DEF helper", word="helper")
    assert place["location"]["range"]["start"] == {"line": line, "character": column}


def test_who_calls_a_routine_and_whom_it_calls(client, backup):
    (item,) = client.ask("prepareCallHierarchy", backup / MAIN, *at("close_it ("))
    assert (item["name"], item["uri"]) == ("close_it", (backup / CLOSE).as_uri())
    (caller,) = client.request("callHierarchy/incomingCalls", {"item": item})
    assert caller["from"]["name"] == "main"
    line, column = at("close_it (")
    assert caller["fromRanges"][0]["start"] == {"line": line, "character": column}
    called = client.request("callHierarchy/outgoingCalls", {"item": caller["from"]})
    assert [x["to"]["name"] for x in called] == ["close_it", "helper"]
    assert client.ask("prepareCallHierarchy", backup / MAIN, *at("$TOOL")) is None


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the time of another process as Linux gives it")
def test_with_the_whole_machine_as_root_an_answer_comes_in_3_s(backup):
    """The time is that after the server has begun to listen, of the processor: other tests may be at work."""
    with LanguageClient("/") as client:
        before = ticks(client.process.pid)
        client.open(backup / MAIN, FILES[MAIN])
        assert client.diagnostics(backup / MAIN)[1] == []
        assert client.request("workspace/symbol", {"query": "helper"})
        assert ticks(client.process.pid) - before < 3.0


def ticks(process):
    """[s] Of the processor, that a process has used."""
    with open(f"/proc/{process}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


@pytest.mark.slow
def test_two_backups_as_two_roots_are_two_projects(backup, tmp_path):
    (tmp_path / "a.src").write_text("DEF a( )\nSPEED = 1\nEND\n")
    with LanguageClient(backup) as client:
        added = {"uri": tmp_path.as_uri(), "name": "other"}
        client.notify("workspace/didChangeWorkspaceFolders", {"event": {"added": [added], "removed": []}})
        client.open(tmp_path / "a.src", "DEF a( )\nSPEED = 1\nEND\n")
        assert [d["code"] for d in client.diagnostics(tmp_path / "a.src")[1]] == ["undeclared"]
        names = {x["name"] for x in client.request("workspace/symbol", {"query": ""})}
        assert {"a", "helper"} <= names
