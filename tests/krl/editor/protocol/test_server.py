"""`lwr-dyn lsp` with a scripted editor: diagnoses as texts change, answers, places in all encodings."""

import pytest

from tests.krl.language_client import LanguageClient
from tests.krl.small_backup import CLOSE, FILES, MAIN, place_of, write_backup


def at(text, nth=0, word="", name=MAIN):
    line, column = place_of(name, text, nth, word)
    return line, column - 1


@pytest.mark.slow
def test_a_fault_is_said_at_its_word_and_gone_when_it_is_mended(client, backup):
    main = backup / MAIN
    client.change(main, FILES[MAIN].replace("LIN pick", "LIN pik"))
    (found,) = client.diagnostics(main)[1]
    line, column = at("LIN pick", word="pick")
    assert found["range"] == {
        "start": {"line": line, "character": column},
        "end": {"line": line, "character": column + 3},
    }
    assert (found["severity"], found["code"], found["source"]) == (1, "undeclared", "lwr-dyn")
    assert found["message"] == "pik is not declared (did you mean pick?)"
    client.change(main, FILES[MAIN])
    assert client.diagnostics(main)[1] == []


def test_of_changes_that_follow_each_other_the_last_counts(client, backup):
    main = backup / MAIN
    for i in range(5):
        client.change(main, FILES[MAIN].replace("LIN pick", f"LIN pick{i}"))
    (found,) = client.diagnostics(main)[1]
    assert found["message"].startswith("pick4 ")
    client.change(main, FILES[MAIN])
    assert client.diagnostics(main)[1] == []


def test_another_open_file_is_checked_again(client, backup):
    data = backup / CLOSE.replace(".src", ".dat")
    text = FILES[CLOSE.replace(".src", ".dat")]
    client.open(data, text)
    assert client.diagnostics(data)[1] == []
    assert client.diagnostics(backup / MAIN)[1] == []
    client.change(data, text.replace("GLOBAL ", ""))
    assert {d["code"] for d in client.diagnostics(backup / MAIN)[1]} == {"undeclared"}
    client.notify("textDocument/didClose", {"textDocument": {"uri": data.as_uri()}})
    client.change(backup / MAIN, FILES[MAIN] + "\n")
    assert client.diagnostics(backup / MAIN)[1] == []


def test_hover_definition_and_references(client, backup):
    place = at("close_it (")
    shown = client.ask("hover", backup / MAIN, *place)
    assert "DEF close_it(g:OUT, n:IN)" in shown["contents"]["value"]
    assert shown["range"]["end"]["character"] - shown["range"]["start"]["character"] == len("close_it")
    there = client.ask("definition", backup / MAIN, *place)
    assert there["uri"] == (backup / CLOSE).as_uri()
    assert there["range"]["start"] == {"line": 0, "character": 4}
    for declared, count in ((True, 3), (False, 2)):
        uses = client.ask("references", backup / MAIN, *place, context={"includeDeclaration": declared})
        assert len(uses) == count
    assert client.ask("hover", backup / MAIN, *at("FOR i")) is None
    assert client.ask("definition", backup / MAIN, 9999, 0) is None


def test_outline_and_folding(client, backup):
    document = {"textDocument": {"uri": (backup / MAIN).as_uri()}}
    names = [x["name"] for x in client.request("textDocument/documentSymbol", document)]
    assert names == ["main", "helper"]
    folds = client.request("textDocument/foldingRange", document)
    assert {(x["startLine"], x["endLine"]) for x in folds} >= {(9, 14), (4, 6)}


@pytest.mark.slow
def test_a_text_may_be_anything_while_it_is_written(client, backup):
    main = backup / MAIN
    for text in ("", "\n", "DEF", "DEF a(\n;FOLD\nIF\n{{{[", "\x00\x0c\u2028", "x" * 20_000, "END\n" * 300):
        client.change(main, text)
        found = client.diagnostics(main)[1]
        assert all(d["range"]["start"]["line"] <= text.count("\n") + 1 for d in found)
        for what in ("hover", "definition", "completion", "signatureHelp", "documentHighlight", "prepareCallHierarchy"):
            client.ask(what, main, 0, 3)
        document = {"textDocument": {"uri": main.as_uri()}}
        part = {"start": {"line": 0, "character": 0}, "end": {"line": 9, "character": 0}}
        for what in ("documentSymbol", "foldingRange", "semanticTokens/full", "formatting"):
            client.request(f"textDocument/{what}", {**document, "options": {"tabSize": 2, "insertSpaces": True}})
        for what in ("inlayHint", "codeAction", "semanticTokens/range"):
            client.request(f"textDocument/{what}", {**document, "range": part, "context": {"diagnostics": []}})
    client.change(main, FILES[MAIN])
    assert client.diagnostics(main)[1] == []


@pytest.mark.slow
def test_places_count_as_the_editor_counts_and_a_form_feed_ends_no_line(tmp_path):
    names, path = tmp_path / "own.toml", tmp_path / "a.src"
    names.write_text('[[group]]\ntitle = "glue"\npackage = "Own"\nfunctions = ["GLUE_ON(INT gun)"]\n')
    with LanguageClient(None, ["utf-8"], ["--names", str(names)]) as client:
        assert client.capabilities["positionEncoding"] == "utf-8"
        assert client.capabilities["textDocumentSync"]["change"] == 1  # whole texts, see `language_server`
        client.open(path, 'DEF a( )\nDECL CHAR t[9]\n;\x0c\nt[] = "\U0001f916" + nix\nGLUE_ON(3)\nGLUE_OFF(3)\nEND\n')
        found = {d["code"]: d["range"] for d in client.diagnostics(path)[1]}
        first = 7 + 4 + 1 + 3
        assert found["undeclared"] == {
            "start": {"line": 3, "character": first},
            "end": {"line": 3, "character": first + 3},
        }
        assert found["unknown-call"]["start"]["line"] == 5
        assert "Own: glue" in client.ask("hover", path, 4, 2)["contents"]["value"]


@pytest.mark.slow
def test_files_that_change_on_disk_are_read_again(tmp_path):
    backup = write_backup(tmp_path.resolve())
    wishes = {"workspace": {"didChangeWatchedFiles": {"dynamicRegistration": True}}}
    with LanguageClient(backup, **wishes) as client:
        asked = client.until(lambda m: m.get("method") == "client/registerCapability")[1]
        client.send({"id": asked["id"], "result": None})
        client.open(backup / MAIN, FILES[MAIN])
        assert client.diagnostics(backup / MAIN)[1] == []
        (backup / CLOSE).unlink()
        change = {"uri": (backup / CLOSE).as_uri(), "type": 3}
        client.notify("workspace/didChangeWatchedFiles", {"changes": [change]})
        assert [d["code"] for d in client.diagnostics(backup / MAIN)[1]] == ["unknown-call"]


@pytest.mark.slow
def test_it_ends_when_the_editor_goes_away(tmp_path):
    client = LanguageClient(tmp_path)
    client.process.stdin.close()
    assert client.process.wait(timeout=20) == 0
    client.process.stdout.close()


def test_a_file_that_is_not_open_or_not_there_is_answered(client, backup):
    place = {"position": {"line": 0, "character": 5}, "context": {"includeDeclaration": True}}
    for uri in ((backup / "gone.src").as_uri(), "untitled:Untitled-1"):
        asked = {"textDocument": {"uri": uri}, **place}
        assert client.request("textDocument/hover", asked) is None
        assert client.request("textDocument/references", asked) == []
        assert client.request("textDocument/documentSymbol", asked) == []
        assert client.request("textDocument/foldingRange", asked) == []
    folder = (backup / MAIN).parent
    (folder / "shut.src").write_bytes(b"DEF shut( ) ; gro\xdf\nEND\n")
    shut = {"textDocument": {"uri": (folder / "shut.src").as_uri()}}
    client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": shut["textDocument"]["uri"], "type": 1}]})
    assert "shut" in client.request("textDocument/hover", {**shut, **place})["contents"]["value"]
    (folder / "shut.src").unlink()
    client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": shut["textDocument"]["uri"], "type": 3}]})
    assert client.request("textDocument/hover", {**shut, **place}) is None


def test_a_file_of_another_language_is_left_alone(client, backup):
    other, scratch = backup / "world.xml", backup / "scratch"
    client.open(other, "<world>", "xml")
    client.open(scratch, "DEF a( )\nnix = 1\nEND\n")
    assert [d["code"] for d in client.diagnostics(scratch)[1]] == ["undeclared"]
    client.change(other, "<world/>")
    for path in (other, scratch):
        client.notify("textDocument/didClose", {"textDocument": {"uri": path.as_uri()}})
    assert client.diagnostics(scratch)[1] == []
    assert not [m for _, m in client.other if m.get("params", {}).get("uri") == other.as_uri()]
