"""`lwr-dyn lsp` with a scripted editor: diagnoses as texts change, files that come and go, places in all encodings."""

import pytest

from tests.krl.language_client import LanguageClient, short, span
from tests.krl.small_backup import CLOSE, FILES, MAIN, write_backup

CLOSE_DATA = CLOSE.replace(".src", ".dat")


def codes(client, path):
    return [d["code"] for d in client.diagnostics(path)[1]]


def test_what_the_server_offers(client):
    offered = client.capabilities
    # whole texts, see `language_server`
    assert offered["textDocumentSync"] == {"openClose": True, "change": 1, "save": True}
    assert offered["completionProvider"] == {"triggerCharacters": [".", "#", "$", "{"]}
    assert offered["signatureHelpProvider"] == {"triggerCharacters": ["(", ","]}
    assert offered["codeActionProvider"] == {"codeActionKinds": ["quickfix"]}
    names = "hover definition references documentHighlight documentSymbol documentFormatting documentRangeFormatting"
    assert all(offered[f"{x}Provider"] is True for x in (*names.split(), "rename", "foldingRange", "callHierarchy"))


def test_of_changes_that_follow_each_other_the_last_counts_and_a_fault_goes_when_it_is_mended(client, backup):
    main = backup / MAIN
    for i in range(5):
        client.change(main, FILES[MAIN].replace("LIN pick", f"LIN pik{i}"))
    (found,) = client.diagnostics(main)[1]
    assert short(found) == {
        "range": (10, 6, 10, 10), "severity": 1, "code": "undeclared", "source": "lwr-dyn",
        "message": "pik4 is not declared (did you mean pick?)",
    }  # fmt: skip
    client.change(main, FILES[MAIN])
    assert codes(client, main) == []


def test_another_open_file_is_checked_again(client, backup):
    main, data = backup / MAIN, backup / CLOSE_DATA
    client.open(data, FILES[CLOSE_DATA])
    assert (codes(client, data), codes(client, main)) == ([], [])
    client.change(data, FILES[CLOSE_DATA].replace("GLOBAL ", ""))
    assert set(codes(client, main)) == {"undeclared"}
    client.close(data)
    client.change(main, FILES[MAIN] + "\n")
    assert codes(client, main) == []


@pytest.mark.slow
def test_a_text_may_be_anything_while_it_is_written(client, backup):
    main, options = backup / MAIN, {"tabSize": 2, "insertSpaces": True}
    for text in ("", "\n", "DEF", "DEF a(\n;FOLD\nIF\n{{{[", "\x00\x0c\u2028", "x" * 20_000, "END\n" * 300):
        client.change(main, text)
        found = client.diagnostics(main)[1]
        assert all(d["range"]["start"]["line"] <= text.count("\n") + 1 for d in found)
        for what in ("hover", "definition", "completion", "signatureHelp", "documentHighlight", "prepareCallHierarchy"):
            client.ask(what, main, 0, 3)
        for what in ("documentSymbol", "foldingRange", "semanticTokens/full", "formatting"):
            client.of(what, main, options=options)
        for what in ("inlayHint", "codeAction", "semanticTokens/range"):
            client.of(what, main, range=span((0, 0), (9, 0)), context={"diagnostics": []})
    client.change(main, FILES[MAIN])
    assert codes(client, main) == []


@pytest.mark.slow
@pytest.mark.parametrize(("encoding", "robot"), [("utf-8", 4), ("utf-16", 2), ("utf-32", 1)])
def test_places_count_as_the_editor_counts_and_a_form_feed_ends_no_line(tmp_path, encoding, robot):
    names, path = tmp_path / "own.toml", tmp_path / "a.src"
    names.write_text('[[group]]\ntitle = "glue"\npackage = "Own"\nfunctions = ["GLUE_ON(INT gun)"]\n')
    with LanguageClient(None, [encoding], ["--names", str(names)]) as client:
        assert client.capabilities["positionEncoding"] == encoding
        client.open(path, 'DEF a( )\nDECL CHAR t[9]\n;\x0c\nt[] = "\U0001f916" + nix\nGLUE_ON(3)\nGLUE_OFF(3)\nEND\n')
        found = {d["code"]: short(d["range"]) for d in client.diagnostics(path)[1]}
        first = 7 + robot + 1 + 3
        assert (found["undeclared"], found["unknown-call"]) == ((3, first, 3, first + 3), (5, 0, 5, 8))
        assert "Own: glue" in client.ask("hover", path, 4, 2)["contents"]["value"]


@pytest.mark.slow
def test_files_that_change_on_disk_are_read_again(tmp_path):
    backup = write_backup(tmp_path.resolve())
    wishes = {"workspace": {"didChangeWatchedFiles": {"dynamicRegistration": True}}}
    with LanguageClient(backup, **wishes) as client:
        asked = client.until(lambda m: m.get("method") == "client/registerCapability")[1]
        (wish,) = asked["params"]["registrations"]
        assert wish["registerOptions"]["watchers"] == [{"globPattern": "**/*.{src,dat,sub,SRC,DAT,SUB}"}]
        client.send({"id": asked["id"], "result": None})
        client.open(backup / MAIN, FILES[MAIN])
        assert codes(client, backup / MAIN) == []
        (backup / CLOSE).unlink()
        change = {"uri": (backup / CLOSE).as_uri(), "type": 3}
        client.notify("workspace/didChangeWatchedFiles", {"changes": [change]})
        assert codes(client, backup / MAIN) == ["unknown-call"]


@pytest.mark.slow
def test_it_ends_when_the_editor_goes_away(tmp_path):
    client = LanguageClient(tmp_path)
    client.process.stdin.close()
    assert client.process.wait(timeout=20) == 0
    client.process.stdout.close()


def test_a_file_that_is_not_open_or_not_there_is_answered(client, backup):
    shut = (backup / MAIN).parent / "shut.src"
    place = {"position": {"line": 0, "character": 5}, "context": {"includeDeclaration": True}}

    def on_disk(kind):
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": shut.as_uri(), "type": kind}]})

    for uri in ((backup / "gone.src").as_uri(), "untitled:Untitled-1"):
        for what, nothing in (("hover", None), ("references", []), ("documentSymbol", []), ("foldingRange", [])):
            assert client.request(f"textDocument/{what}", {"textDocument": {"uri": uri}, **place}) == nothing
    shut.write_bytes(b"DEF shut( ) ; gro\xdf\nEND\n")
    on_disk(1)
    assert "shut" in client.of("hover", shut, **place)["contents"]["value"]
    shut.unlink()
    on_disk(3)
    assert client.of("hover", shut, **place) is None


def test_a_file_of_another_language_is_left_alone(client, backup):
    other, scratch = backup / "world.xml", backup / "scratch"
    client.open(other, "<world>", "xml")
    client.open(scratch, "DEF a( )\nnix = 1\nEND\n")
    assert codes(client, scratch) == ["undeclared"]
    client.change(other, "<world/>")
    client.close(other)
    client.close(scratch)
    assert codes(client, scratch) == []
    assert not [m for _, m in client.other if m.get("params", {}).get("uri") == other.as_uri()]
