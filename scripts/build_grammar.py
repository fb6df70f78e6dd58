"""Write the colours of KRL for editors, a TextMate grammar, from the words of the project's own lexer, or check them.

python scripts/build_grammar.py            write editors/vscode/syntaxes/krl.tmLanguage.json
python scripts/build_grammar.py --check    exit 1 when it is not fresh
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from lwr_dyn.krl.language.lexer import GRAMMAR as LANGUAGE
from lwr_dyn.krl.language.lexer import KEYWORDS
from lwr_dyn.krl.names.known_names import GEOMETRY, SIMPLE

GRAMMAR = Path(__file__).resolve().parent.parent / "editors/vscode/syntaxes/krl.tmLanguage.json"
NAME = r"[A-Za-z_$][A-Za-z0-9_$]*"
OPERATORS = frozenset({"AND", "OR", "NOT", "EXOR", "B_AND", "B_OR", "B_NOT", "B_EXOR"})
MODIFIERS = frozenset(
    {
        *("DECL", "GLOBAL", "CONST", "PUBLIC", "STRUC", "ENUM", "SIGNAL", "CHANNEL", "IN", "OUT", "INOUT"),
        *("EXT", "EXTFCT", "EXTP", "EXTFCTP"),
    }
)
WITH_SOFT_WORDS = {
    "keyword.control": ("FOR", "WAIT", "TRIGGER", "INTERRUPT", r"STOP(?=\s+WHEN)", "CONST_VEL", "TIME_BLOCK"),
    "support.function.motion": ("CIRC", "CIRC_REL", "SCIRC", "SCIRC_REL"),
}
"""Statements in which some of the words are no names that may be names elsewhere: `FOR i = 1 TO 9 STEP 2`."""
MOTIONS = frozenset({"MOVE", "CIRCULAR", "BLEND"})
"""Kinds of tokens that are motions, or how one blends into the next."""


def groups() -> Mapping[str, frozenset[str]]:
    """Scope -> its words; each keyword of the lexer has one, and the structures of the language are types."""
    words = frozenset(KEYWORDS)
    out = {
        "storage.type": SIMPLE | frozenset(GEOMETRY),
        "constant.language": frozenset(word for word in words if KEYWORDS[word] == "TRUTH"),
        "keyword.operator.word": OPERATORS & words,
        "storage.modifier": MODIFIERS & words,
        "support.function.motion": frozenset(
            word for word in words if KEYWORDS[word] in MOTIONS or word.endswith("SPLINE")
        ),
    }
    return out | {"keyword.control": words - frozenset().union(*out.values())}


def one_of(words: Iterable[str]) -> str:
    """An expression for any of the words, the longest first."""
    return "|".join(sorted(words, key=lambda word: (-len(word), word)))


def rule(scope: str, match: str, *captures: str) -> dict[str, Any]:
    """A rule of one line; without a scope of its own it has those of its captures, empty ones left out."""
    out: dict[str, Any] = {"name": f"{scope}.krl"} if scope else {}
    out["match"] = match
    named = {str(i): {"name": f"{name}.krl"} for i, name in enumerate(captures, 1) if name}
    return out | ({"captures": named} if named else {})


def soft_words() -> frozenset[str]:
    """Words with a meaning in one place only, which may be names elsewhere: rule `name` of the language's grammar."""
    found = re.search(r"^name: NAME \| (.*)$", LANGUAGE, re.MULTILINE)
    assert found is not None
    return frozenset(found[1].split(" | "))


def heads() -> Iterator[dict[str, Any]]:
    """Lines that begin a routine or a file."""
    shared = r"(?i)^\s*(GLOBAL\s+)?"
    yield rule("", rf"{shared}(DEF)\s+({NAME})", "storage.modifier", "keyword.control", "entity.name.function")
    yield rule("", rf"{shared}(DEFFCT)\s+({NAME})(?:\s*\[\s*(\d*)[^\]]*\])?\s+({NAME})", "storage.modifier",
               "keyword.control", "storage.type", "constant.numeric", "entity.name.function")  # fmt: skip
    yield rule("", rf"(?i)^\s*(DEFDAT)\s+({NAME})\s+(PUBLIC)", "keyword.control", "entity.name.module",
               "storage.modifier")  # fmt: skip
    yield rule("", rf"(?i)^\s*(DEFDAT)\s+({NAME})", "keyword.control", "entity.name.module")


def signs() -> list[dict[str, Any]]:
    """What is the same inside braces and outside."""
    types = groups()["storage.type"]
    return [
        rule("comment.line.fold", r"(?i);\s*((?:END)?FOLD)\b([^;]*)(;.*)?$",
             "keyword.other.fold", "entity.name.section", "comment.line.parameters"),
        rule("comment.line.semicolon", r";.*$"),
        rule("string.quoted.double", r'"[^"]*("|$)'),
        rule("constant.numeric.bits", r"'(?:[Bb][01]+|[Hh][0-9A-Fa-f]+)'"),
        rule("constant.other.enum", rf"#[ \t]*{NAME}"),
        rule("variable.other.property", rf"(?<=\.){NAME}"),
        rule("variable.language.system", r"\$[A-Za-z0-9_$]+"),
        rule("storage.type", rf"(?i)(?<=\{{)\s*(?:{one_of(types)})(?=\s*:)"),
    ]  # fmt: skip


def _word(words: Iterable[str]) -> str:
    return rf"(?i)(?<![\w$.])(?:{one_of(words)})(?![\w$])"


def grammar() -> dict[str, Any]:
    """The grammar; inside braces and in STRUC and ENUM a keyword is the name of a component, as for the lexer."""
    soft = soft_words()
    words = [rule(scope, _word(group - soft)) for scope, group in groups().items()]
    types, values = words[0], [words[1], words[2]]
    member = rule("variable.other.property", rf"(?<=[{{,:])\s*{NAME}")
    rest = [
        rule("", rf"({NAME})\s*(?=\()", "entity.name.function.call"),
        rule("constant.numeric", r"(?<![\w$])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"),
        rule("keyword.operator", r"==|<>|<=|>=|[-+*/<>=:]"),
        rule("variable.other", NAME),
    ]
    braces = {
        "begin": r"\{", "end": r"\}|$", "name": "meta.aggregate.krl",
        "patterns": [*signs(), {"include": "#braces"}, {"include": "#inside"}, member, *values, *rest],
    }  # fmt: skip
    inside = {  # arguments and indices of a value in braces: there a comma begins no component
        "begin": r"[(\[]", "end": r"[)\]]|$",
        "patterns": [*signs(), {"include": "#braces"}, {"include": "#inside"}, *values, *rest],
    }  # fmt: skip
    declared = {
        "begin": r"(?i)^\s*(GLOBAL\s+)?(STRUC|ENUM)\s+", "end": r"$",
        "beginCaptures": {str(i): {"name": "storage.modifier.krl"} for i in (1, 2)},
        "patterns": [*signs(), types, *rest],
    }  # fmt: skip
    there = [*signs(), {"include": "#braces"}, *words]
    in_place = [
        {"begin": _word(firsts), "end": r"$", "beginCaptures": {"0": {"name": f"{scope}.krl"}},
         "patterns": [*there, rule("keyword.control", _word(soft)), *rest]}
        for scope, firsts in WITH_SOFT_WORDS.items()
    ]  # fmt: skip
    return {
        "name": "KRL",
        "scopeName": "source.krl",
        "comment": "Written by scripts/build_grammar.py from the words of lwr_dyn.krl.language.lexer.",
        "patterns": [
            rule("meta.preprocessor", r"^\s*&.*$"),
            declared, *heads(), *in_place, *there, *rest,
        ],
        "repository": {"braces": braces, "inside": inside},
    }  # fmt: skip


def main(arguments: list[str] | None = None, path: Path = GRAMMAR) -> int:
    check = "--check" in (sys.argv[1:] if arguments is None else arguments)
    wanted = json.dumps(grammar(), indent=1) + "\n"
    fresh = path.is_file() and path.read_text(encoding="utf-8") == wanted
    if not fresh and not check:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(wanted, encoding="utf-8")
    state = "fresh" if fresh else "stale" if check else "written"
    print(f"{state}: {path.name}, {len(KEYWORDS)} keywords")
    return int(check and not fresh)


if __name__ == "__main__":
    sys.exit(main())
