"""Help in writing, asked for as an editor does: completion, signatures, rename, layout, colours, hints, quick fixes."""

import pytest

from lwr_dyn.krl.editor.coloring import MARKS, MEANINGS
from lwr_dyn.krl.language.layout import formatted
from lwr_dyn.krl.language.source import parse_text
from tests.krl.language_client import LanguageClient, short, span
from tests.krl.small_backup import CLOSE, FILES, MAIN, cursor

WHOLE = span((0, 0), (999, 0))


def with_edits(text, edits):
    lines = text.split("\n")
    for edit in sorted(edits, key=lambda x: short(x["range"]), reverse=True):
        i, first, end, last = short(edit["range"])
        assert i == end
        lines[i] = lines[i][:first] + edit["newText"] + lines[i][last:]
    return "\n".join(lines)


def test_a_proposal_replaces_what_is_written(client, backup, edited):
    text = FILES[MAIN].replace("GOTO again", "  grip.st")
    edited(text)
    line = text.split("\n").index("  grip.st")
    found = client.ask("completion", backup / MAIN, line, len("  grip.st"))
    assert (found["isIncomplete"], len(found["items"])) == (False, 2)
    edit = {"range": (line, 7, line, 9), "newText": "STATE"}
    assert short(found["items"][0]) == {
        "label": "STATE", "kind": 5, "detail": "STATE_E of GRIP_T", "sortText": "0STATE", "textEdit": edit,
    }  # fmt: skip
    assert client.ask("completion", backup / MAIN, 9999, 0) is None
    shown = client.ask("completion", backup / MAIN, line, 0)
    items = {x["label"]: (x["kind"], x.get("detail"), x["sortText"]) for x in shown["items"]}
    assert shown["isIncomplete"]
    some = {"shared_count": (6, "INT", "1shared_count"), "pick": (6, "E6POS", "0pick"), "FOR": (14, None, "2FOR"),
            "helper": (3, "DEF helper( )", "0helper"), "GRIP_T": (22, "STRUC", "2GRIP_T")}  # fmt: skip
    assert some.items() <= items.items()


@pytest.mark.slow
def test_an_editor_that_takes_one_range_for_all_gets_one(backup):
    wishes = {"textDocument": {"completion": {"completionList": {"itemDefaults": ["editRange"]}}}}
    with LanguageClient(backup, **wishes) as client:
        client.open(backup / MAIN, FILES[MAIN])
        found = client.ask("completion", backup / MAIN, *cursor("  LIN pick", word="ick"))
    assert short(found["itemDefaults"]["editRange"]) == (10, 6, 10, 7)
    assert all("textEdit" not in x for x in found["items"])


def test_the_parameters_of_the_call_in_which_the_cursor_stands(client, backup, edited):
    shown = client.ask("signatureHelp", backup / MAIN, *cursor("close_it (grip, i)", word="i)"))
    (signature,) = shown["signatures"]
    assert signature["label"] == "close_it(GRIP_T g:OUT, INT n:IN)"
    assert [x["label"] for x in signature["parameters"]] == ["GRIP_T g:OUT", "INT n:IN"]
    assert (shown["activeSignature"], shown["activeParameter"]) == (0, 1)
    assert client.ask("signatureHelp", backup / MAIN, 0, 0) is None
    edited(FILES[MAIN].replace("(grip, i)", "(grip, i, 3, 4)"))
    assert client.ask("signatureHelp", backup / MAIN, 12, 27)["activeParameter"] == 1  # the last one that there is


def test_a_name_is_changed_in_all_files_or_the_sentence_says_why_not(client, backup):
    line, column = cursor("shared_count = ")
    shown = client.ask("prepareRename", backup / MAIN, line, column + 3)
    assert short(shown) == {"range": (line, 0, line, 12), "placeholder": "shared_count"}
    changes = client.ask("rename", backup / MAIN, line, column + 3, newName="how_many")["changes"]
    for path in (MAIN, CLOSE, CLOSE.replace(".src", ".dat")):
        new = with_edits(FILES[path], changes.pop((backup / path).as_uri()))
        assert new == FILES[path].replace("shared_count", "how_many")
    assert changes == {}

    def refused(method, line, character, new):
        asked = {"textDocument": {"uri": (backup / MAIN).as_uri()}, "position": {"line": line, "character": character}}
        return client.refused(f"textDocument/{method}", {**asked, "newName": new})

    assert refused("rename", line, column, "SPEED") == f"SPEED is taken, as {CLOSE} sees it in line 6"
    for method in ("prepareRename", "rename"):
        kept = "$TOOL comes with the controller or an option, and keeps its name"
        assert refused(method, *cursor("$TOOL"), "x") == kept
        assert client.ask(method, backup / MAIN, 9999, 0, newName="x") is None


def test_the_layout_is_that_of_the_command_whatever_the_editor_wants(client, backup):
    options = {"tabSize": 8, "insertSpaces": False}
    edits = client.of("formatting", backup / MAIN, options=options)
    wanted = formatted(parse_text(FILES[MAIN], "main.src")[0]).text()
    assert with_edits(FILES[MAIN], edits) == wanted != FILES[MAIN]
    before, after = FILES[MAIN].split("\n"), wanted.split("\n")
    for character, last in ((0, 10), (1, 11)):  # a line of which no character is taken does not count
        part = span((7, 0), (10, character))
        edits = client.of("rangeFormatting", backup / MAIN, options=options, range=part)
        assert with_edits(FILES[MAIN], edits).split("\n") == [*before[:7], *after[7:last], *before[last:]]


def test_colours_of_the_whole_and_of_a_part_agree(client, backup):
    legend = client.capabilities["semanticTokensProvider"]["legend"]
    assert legend == {"tokenTypes": list(MEANINGS), "tokenModifiers": list(MARKS)}
    whole = placed(client.of("semanticTokens/full", backup / MAIN)["data"])
    some = placed(client.of("semanticTokens/range", backup / MAIN, range=span((5, 0), (11, 0)))["data"])
    assert some == [x for x in whole if 5 <= x[0] <= 11] != []
    lines = FILES[MAIN].split("\n")
    named = [(lines[i][at : at + n], MEANINGS[kind], marks) for i, at, n, kind, marks in whole if i in (5, 11, 12)]
    assert named == [
        ("BAS", "function", 2), ("#INITMOV", "enumMember", 0), ("grip", "variable", 0), ("state", "property", 0),
        ("#OPEN", "enumMember", 0), ("close_it", "function", 0), ("grip", "variable", 0), ("i", "variable", 0),
    ]  # fmt: skip


def placed(data):
    out, line, at = [], 0, 0
    for i in range(0, len(data), 5):
        at = data[i + 1] + (at if data[i] == 0 else 0)
        line += data[i]
        out.append((line, at, *data[i + 2 : i + 5]))
    return out


def test_an_input_has_its_name_beside_it_behind_letters_beyond_ascii(client, backup, edited):
    more = "DECL CHAR t[9]\nSIGNAL part $IN[3]\nSIGNAL odd $IN[i]\n"
    signal = FILES[MAIN].replace("DECL INT i\n", f"DECL INT i\n{more}", 1)
    text = signal.replace("GOTO again", 't[] = "\U0001f916"\nWAIT FOR $IN[3] AND t[] == "\U0001f916" AND $IN[3]')
    edited(text)
    line = next(i for i, x in enumerate(text.split("\n")) if x.startswith("WAIT FOR"))
    places = [(*x["position"].values(), x["label"], x["paddingLeft"])
              for x in client.of("inlayHint", backup / MAIN, range=WHOLE)]  # fmt: skip
    assert places == [(line, 15, "part", True), (line, 42, "part", True)]
    assert client.of("inlayHint", backup / MAIN, range=span((0, 0), (line - 1, 0))) == []


def test_a_slip_is_mended_in_the_text_as_it_is_now(client, backup, edited):
    text = FILES[MAIN].replace("LIN pick", "LIN pik")
    given = edited(text)

    def actions(where, diagnostics):
        return client.of("codeAction", backup / MAIN, range=where, context={"diagnostics": diagnostics})

    (action,) = actions(given[0]["range"], [*given, {**given[0], "code": "other"}])
    assert (action["title"], action["kind"], action["diagnostics"]) == ("Write pick", "quickfix", given)
    assert action["isPreferred"]
    assert with_edits(text, action["edit"]["changes"][(backup / MAIN).as_uri()]) == FILES[MAIN]
    assert [actions(span((i, 0), (i, 9)), []) for i in (9, 11)] == [[], []]
    moved = "\n" + text
    client.change(backup / MAIN, moved)
    (action,) = actions(WHOLE, [])
    assert with_edits(moved, action["edit"]["changes"][(backup / MAIN).as_uri()]) == "\n" + FILES[MAIN]
    client.diagnostics(backup / MAIN)
