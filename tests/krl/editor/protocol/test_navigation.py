"""What stands where, asked for as an editor does: hover, uses, outline, symbols of the folder, calls."""

from pathlib import Path

import pytest

from lwr_dyn.krl.editor.protocol.navigation import MOST_SYMBOLS
from tests.krl.language_client import LanguageClient, short
from tests.krl.small_backup import CLOSE, FILES, MAIN, cursor

FUNCTION, NAMESPACE, STRING, STRUCT, VARIABLE = 12, 3, 15, 23, 13
READ, WRITE = 2, 3
HEAD, DATA_HEAD, CALL = (0, 4, 0, 12), (1, 7, 1, 15), (12, 4, 12, 12)


def test_hover_definition_and_references(client, backup):
    def answer(what, **more):
        return short(client.ask(what, backup / MAIN, *cursor("close_it ("), **more))

    shown = f"```krl\nDEF close_it(g:OUT, n:IN)\n```\n\n{CLOSE}, line 1"
    assert answer("hover") == {"contents": {"kind": "markdown", "value": shown}, "range": CALL}
    assert answer("definition") == {"uri": "close_it.src", "range": HEAD}
    uses = [{"uri": "close_it.src", "range": HEAD}, {"uri": "close_it.dat", "range": (0, 7, 0, 15)},
            {"uri": "main.src", "range": CALL}]  # fmt: skip
    assert answer("references", context={"includeDeclaration": True}) == uses
    assert answer("references", context={"includeDeclaration": False}) == uses[1:]
    there = client.ask("definition", backup / MAIN, *cursor("grip.state", word="state"))
    assert short(there) == {"uri": "$config.dat", "range": (2, 21, 2, 26)}
    for what, *place in (("hover", *cursor("FOR i")), ("definition", *cursor("$TOOL")), ("definition", 9999, 0)):
        assert client.ask(what, backup / MAIN, *place) is None
    for what in ("documentHighlight", "references"):
        nothing = client.ask(what, backup / MAIN, *cursor("FOR i"), context={"includeDeclaration": True})
        assert nothing == []


def test_uses_within_the_file_are_marked_with_those_that_write(client, backup, edited):
    edited(FILES[MAIN].replace("GOTO again", "pick.x = i\ngrip.force = pick.x\nGOTO again"))

    def marked(text, **more):
        found = short(client.ask("documentHighlight", backup / MAIN, *cursor(text, **more)))
        return [(x["range"], x["kind"]) for x in found]

    assert marked("shared_count = ") == [((16, 0, 16, 12), WRITE), ((16, 15, 16, 27), READ)]
    assert marked("$TOOL") == [((15, 0, 15, 5), WRITE)]
    assert marked("LIN pick", word="pick") == [
        ((10, 6, 10, 10), READ),
        ((18, 0, 18, 4), WRITE),
        ((19, 13, 19, 17), READ),
    ]
    assert marked("DECL GRIP_T grip", word="grip")[0] == ((3, 12, 3, 16), WRITE)


def test_outline_and_folding(client, backup):
    def entry(name, kind, lines, head, *children):
        return {"name": name, "kind": kind, "range": lines, "selectionRange": head, "children": list(children)}

    test = entry("IF grip.state == #OPEN THEN", NAMESPACE, (11, 0, 13, 7), (11, 0, 11, 29))
    assert short(client.of("documentSymbol", backup / MAIN)) == [
        entry("main", FUNCTION, (1, 0, 19, 3), (1, 0, 1, 11),
              entry("INI", STRING, (4, 0, 6, 14), (4, 0, 4, 9)),
              entry("FOR i = 1 TO 3", NAMESPACE, (9, 0, 14, 6), (9, 0, 9, 14), test)),
        entry("helper", FUNCTION, (21, 0, 25, 3), (21, 0, 21, 13)),
    ]  # fmt: skip
    folds = client.of("foldingRange", backup / MAIN)
    found = sorted((x["startLine"], x["endLine"], x.get("kind")) for x in folds)
    assert found == [(1, 19, None), (4, 6, "region"), (9, 14, None), (11, 13, None), (21, 25, None)]


def test_symbols_of_the_folder_begin_with_what_is_asked_for_first(client):
    def symbols(query):
        return short(client.request("workspace/symbol", {"query": query}))

    assert [x["name"] for x in symbols("s")] == ["shared_count", "SPEED", "SPEED", "STATE_E", "close_it"]
    assert symbols("helper") == [
        {"location": {"uri": "main.src", "range": (21, 4, 21, 10)}, "name": "helper", "kind": FUNCTION,
         "containerName": MAIN},
    ]  # fmt: skip
    kinds = {x["name"]: x["kind"] for x in symbols("")}
    assert {"GRIP_T": STRUCT, "pick": VARIABLE, "close_it": FUNCTION}.items() <= kinds.items()


def test_who_calls_a_routine_and_whom_it_calls(client, backup):
    def item(name, path, lines, head):
        return {"name": name, "kind": FUNCTION, "uri": path.split("/")[-1], "range": lines, "selectionRange": head,
                "detail": path}  # fmt: skip

    close, main = item("close_it", CLOSE, (0, 0, 6, 3), HEAD), item("main", MAIN, (1, 0, 19, 3), (1, 4, 1, 8))
    (found,) = client.ask("prepareCallHierarchy", backup / MAIN, *cursor("close_it ("))
    assert short(found) == close
    (caller,) = client.request("callHierarchy/incomingCalls", {"item": found})
    assert short(caller) == {"from": main, "fromRanges": [CALL]}
    called = client.request("callHierarchy/outgoingCalls", {"item": caller["from"]})
    helper = item("helper", MAIN, (21, 0, 25, 3), (21, 4, 21, 10))
    assert short(called) == [{"to": close, "fromRanges": [CALL]}, {"to": helper, "fromRanges": [(17, 0, 17, 6)]}]
    assert client.ask("prepareCallHierarchy", backup / MAIN, *cursor("$TOOL")) is None


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
def test_two_backups_as_two_roots_are_two_projects_and_no_answer_has_too_many_symbols(backup, tmp_path):
    text = "DEF a( )\nSPEED = 1\nEND\n"
    (tmp_path / "a.src").write_text(text)
    (tmp_path / "many.dat").write_text(f"DEFDAT many\nINT {','.join(f'n{i}' for i in range(MOST_SYMBOLS))}\nENDDAT\n")
    with LanguageClient(backup) as client:
        added = {"uri": tmp_path.as_uri(), "name": "other"}
        client.notify("workspace/didChangeWorkspaceFolders", {"event": {"added": [added], "removed": []}})
        client.open(tmp_path / "a.src", text)
        assert [d["code"] for d in client.diagnostics(tmp_path / "a.src")[1]] == ["undeclared"]
        assert len(client.request("workspace/symbol", {"query": ""})) == MOST_SYMBOLS
        names = {x["name"] for x in client.request("workspace/symbol", {"query": "a"})}
        assert {"a", "main"} <= names
        assert client.request("workspace/symbol", {"query": "n123"})
        client.notify("workspace/didChangeWorkspaceFolders", {"event": {"added": [], "removed": [added]}})
        assert client.request("workspace/symbol", {"query": "n123"}) in ([], None)
