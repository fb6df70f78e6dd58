"""Help in writing, asked for as an editor does: completion, signatures, rename, layout, colours, hints, quick fixes."""

import pytest

from lwr_dyn.krl.editor.coloring import MEANINGS
from lwr_dyn.krl.language.layout import formatted
from lwr_dyn.krl.language.source import parse_text
from tests.krl.language_client import LanguageClient
from tests.krl.small_backup import FILES, MAIN, place_of

WHOLE = {"start": {"line": 0, "character": 0}, "end": {"line": 999, "character": 0}}


def at(text, nth=0, word=""):
    line, column = place_of(MAIN, text, nth, word)
    return line, column - 1


def with_edits(text, edits):
    lines = text.split("\n")
    for edit in sorted(edits, key=lambda x: (-x["range"]["start"]["line"], -x["range"]["start"]["character"])):
        (i, first), (end, last) = ((x["line"], x["character"]) for x in edit["range"].values())
        assert i == end
        lines[i] = lines[i][:first] + edit["newText"] + lines[i][last:]
    return "\n".join(lines)


def test_a_proposal_replaces_what_is_written(client, backup, edited):
    text = FILES[MAIN].replace("GOTO again", "  grip.st")
    edited(text)
    line = text.split("\n").index("  grip.st")
    found = client.ask("completion", backup / MAIN, line, len("  grip.st"))
    assert [x["label"] for x in found["items"]] == ["STATE", "FORCE"]
    assert found["isIncomplete"] is False
    new = with_edits(text, [found["items"][0]["textEdit"]])
    assert new == text.replace("grip.st\n", "grip.STATE\n")
    shown = client.ask("completion", backup / MAIN, line, 0)
    assert shown["isIncomplete"]
    assert {"detail": "INT", "kind": 6, "label": "shared_count"}.items() <= next(
        x for x in shown["items"] if x["label"] == "shared_count"
    ).items()


@pytest.mark.slow
def test_an_editor_that_takes_one_range_for_all_gets_one(backup):
    wishes = {"textDocument": {"completion": {"completionList": {"itemDefaults": ["editRange"]}}}}
    with LanguageClient(backup, **wishes) as client:
        client.open(backup / MAIN, FILES[MAIN])
        found = client.ask("completion", backup / MAIN, *at("  LIN pick", word="ick"))
    assert found["itemDefaults"]["editRange"]["start"] == {"line": 10, "character": 6}
    assert all("textEdit" not in x for x in found["items"])


def test_the_parameters_of_the_call_in_which_the_cursor_stands(client, backup):
    line, column = at("close_it (grip, i)", word="i)")
    shown = client.ask("signatureHelp", backup / MAIN, line, column)
    assert shown["signatures"][0]["label"] == "close_it(GRIP_T g:OUT, INT n:IN)"
    assert shown["activeParameter"] == 1
    assert client.ask("signatureHelp", backup / MAIN, 0, 0) is None


def test_a_name_is_changed_in_all_files_or_the_sentence_says_why_not(client, backup):
    line, column = at("shared_count = ")
    asked = {"textDocument": {"uri": (backup / MAIN).as_uri()}, "position": {"line": line, "character": column + 3}}
    assert client.request("textDocument/prepareRename", asked)["placeholder"] == "shared_count"
    changes = client.request("textDocument/rename", {**asked, "newName": "how_many"})["changes"]
    for name in ("main.src", "close_it.src", "close_it.dat"):
        path = f"KRC/R1/Program/{name}"
        new = with_edits(FILES[path], changes.pop((backup / path).as_uri()))
        assert new == FILES[path].replace("shared_count", "how_many")
    assert changes == {}
    assert "is taken" in client.refused("textDocument/rename", {**asked, "newName": "SPEED"})
    asked["position"] = dict(zip(("line", "character"), at("$TOOL"), strict=True))
    for method in ("prepareRename", "rename"):
        said = client.refused(f"textDocument/{method}", {**asked, "newName": "x"})
        assert said == "$TOOL comes with the controller or an option, and keeps its name"


def test_the_layout_is_that_of_the_command_whatever_the_editor_wants(client, backup):
    document = {"textDocument": {"uri": (backup / MAIN).as_uri()}, "options": {"tabSize": 8, "insertSpaces": False}}
    edits = client.request("textDocument/formatting", document)
    wanted = formatted(parse_text(FILES[MAIN], "main.src")[0]).text()
    assert with_edits(FILES[MAIN], edits) == wanted != FILES[MAIN]
    part = {"start": {"line": 7, "character": 0}, "end": {"line": 10, "character": 0}}
    edits = client.request("textDocument/rangeFormatting", {**document, "range": part})
    lines = (FILES[MAIN].split("\n"), wanted.split("\n"))
    assert with_edits(FILES[MAIN], edits).split("\n") == [*lines[0][:7], *lines[1][7:10], *lines[0][10:]]


def test_colours_of_the_whole_and_of_a_part_agree(client, backup):
    document = {"textDocument": {"uri": (backup / MAIN).as_uri()}}
    legend = client.capabilities["semanticTokensProvider"]["legend"]
    assert legend["tokenTypes"] == list(MEANINGS)
    whole = placed(client.request("textDocument/semanticTokens/full", document)["data"])
    part = {"start": {"line": 5, "character": 0}, "end": {"line": 11, "character": 0}}
    some = placed(client.request("textDocument/semanticTokens/range", {**document, "range": part})["data"])
    assert some == [x for x in whole if 5 <= x[0] <= 11] != []
    lines = FILES[MAIN].split("\n")
    named = {lines[i][at : at + n]: MEANINGS[kind] for i, at, n, kind in whole}
    assert named["close_it"] == "function"
    assert named["#OPEN"] == "enumMember"


def placed(data):
    out, line, at = [], 0, 0
    for i in range(0, len(data), 5):
        at = data[i + 1] + (at if data[i] == 0 else 0)
        line += data[i]
        out.append((line, at, data[i + 2], data[i + 3]))
    return out


def test_an_input_has_its_name_beside_it_behind_letters_beyond_ascii(client, backup, edited):
    signal = FILES[MAIN].replace("DECL INT i\n", "DECL INT i\nDECL CHAR t[9]\nSIGNAL part $IN[3]\n", 1)
    text = signal.replace("GOTO again", 't[] = "\U0001f916"\nWAIT FOR $IN[3] AND t[] == "\U0001f916" AND $IN[3]')
    edited(text)
    asked = {"textDocument": {"uri": (backup / MAIN).as_uri()}, "range": WHOLE}
    found = client.request("textDocument/inlayHint", asked)
    line = next(i for i, x in enumerate(text.split("\n")) if x.startswith("WAIT FOR"))
    places = [(x["position"]["line"], x["position"]["character"], x["label"]) for x in found]
    assert places == [(line, 15, "part"), (line, 42, "part")]


def test_a_slip_is_mended_in_the_text_as_it_is_now(client, backup, edited):
    text = FILES[MAIN].replace("LIN pick", "LIN pik")
    given = edited(text)
    asked = {"textDocument": {"uri": (backup / MAIN).as_uri()}, "range": given[0]["range"]}
    (action,) = client.request("textDocument/codeAction", {**asked, "context": {"diagnostics": given}})
    assert (action["title"], action["kind"], action["diagnostics"]) == ("Write pick", "quickfix", given)
    assert with_edits(text, action["edit"]["changes"][(backup / MAIN).as_uri()]) == FILES[MAIN]
    moved = "\n" + text
    client.change(backup / MAIN, moved)
    asked["range"] = WHOLE
    (action,) = client.request("textDocument/codeAction", {**asked, "context": {"diagnostics": []}})
    assert with_edits(moved, action["edit"]["changes"][(backup / MAIN).as_uri()]) == "\n" + FILES[MAIN]
    client.diagnostics(backup / MAIN)
