"""One line of KRL -> what it says. LALR(1) by lark; the grammar is `grammar.lark` beside this file.

Lines of one shape (the same kinds of words in the same order) have the same tree: lark builds it once, and lines that
follow only put their own words in.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from difflib import get_close_matches
from functools import lru_cache
from importlib.resources import files
from typing import Any, TypeAlias

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer

from lwr_dyn.krl.declarations import Header
from lwr_dyn.krl.lexer import KEYWORDS, LineError, Word, tokens_of
from lwr_dyn.krl.line_tree import LineTree
from lwr_dyn.krl.statements import Statement

SHAPES = 4096
"""How many shapes of lines are kept."""
Plan: TypeAlias = "tuple[Callable[[list[Any]], Any], tuple[Plan | int | None, ...]]"
"""What to call, with what: a plan of its own, the index of a word, or nothing."""
_MARKS = {
    "_COMMA": ",", "_EQUALS": "=", "_LPAR": "(", "_RPAR": ")", "_LSQB": "[", "_RSQB": "]", "_RBRACE": "}",
    "BRACE": "{", "_DOT": ".", "_COLON": ":", "PLUSMINUS": "+ or -", "TIMES": "* or /", "COMPARE": "a comparison",
    "INTEGER": "a number", "DECIMAL": "a number", "STRING": "a string", "NAME": "a name", "ENUMERATION": "#NAME",
    "BLEND": "C_PTP, C_DIS ...",
}  # fmt: skip
_CLOSERS = {"_LPAR": "_RPAR", "_LSQB": "_RSQB", "BRACE": "_RBRACE"}
_NEVER_FIRST = "IN OUT INOUT TO CA WITH SEC THEN STEP WHEN DO ON OFF TRUE FALSE AND OR NOT"
_FIRST_WORDS = [word for word in KEYWORDS if word not in _NEVER_FIRST.split(" ")]
_AFTER_NAMES = ("_EQUALS", "_LPAR", "_LSQB", "_DOT", "_COLON")
_MAYBE_NAMES = frozenset(
    re.findall(r"\w+", "SEC STEP CA DISTANCE PATH ONSTART DELAY PRIO ENABLE DISABLE MINIMUM MAXIMUM PUBLIC")
)


def parse_line(text: str) -> tuple[Statement | None, str | None]:
    """What a line says (None for an empty one), and its comment after the semicolon (None without one).

    Raises `LineError`.

    >>> parse_line("HALT ; wait here")
    (Plain(keyword='HALT', column=1), ' wait here')
    """
    if text.lstrip().startswith("&"):
        return Header(text.strip()), None
    words, cut = tokens_of(text)
    comment = None if cut is None else text[cut + 1 :]
    if not words:
        return None, comment
    try:
        plan = _plan(tuple(word.kind for word in words))
    except UnexpectedToken as fault:
        raise _syntax_fault(words, fault) from None
    statement: Statement = _carried_out(plan, words)
    return statement, comment


def _carried_out(plan: Plan, words: Sequence[Word]) -> Any:
    call, parts = plan
    return call([p if p is None else words[p] if isinstance(p, int) else _carried_out(p, words) for p in parts])


@lru_cache(maxsize=SHAPES)
def _plan(shape: tuple[str, ...]) -> Plan:
    tree = _parser().parse(shape)
    return _planned(tree)


def _planned(tree: Any) -> Plan:
    parts = tuple(_planned(c) if isinstance(c, Tree) else None if c is None else int(c) for c in tree.children)
    return getattr(_RULES, tree.data), parts


_RULES = LineTree()


class _Shape(Lexer):
    """Hands the kinds of words to lark as tokens whose text is their index."""

    def __init__(self, lexer_conf: object) -> None:
        pass

    def lex(self, data: object) -> Iterator[Token]:  # type: ignore[override]
        for i, kind in enumerate(data):  # type: ignore[arg-type, var-annotated]
            yield Token(kind, str(i))


@lru_cache(maxsize=1)
def _parser() -> Lark:
    grammar = files("lwr_dyn.krl").joinpath("grammar.lark").read_text(encoding="ascii")
    return Lark(grammar, parser="lalr", lexer=_Shape, start="line", maybe_placeholders=True)


def _syntax_fault(words: list[Word], fault: UnexpectedToken) -> LineError:
    ended = fault.token.type == "$END"
    at = len(words) if ended else int(fault.token)
    column = words[-1].column + len(words[-1].text) if ended else words[at].column
    still_open = _open_bracket(words[:at])
    if ended and still_open is not None:
        sign, close = _MARKS[still_open.kind], _MARKS[_CLOSERS[still_open.kind]]
        return LineError(still_open.column, "open-bracket", f"{sign} is not closed", f"close it with {close}")
    near = _near_keyword(words[0])
    if near is not None and (len(words) < 2 or words[1].kind not in _AFTER_NAMES):
        return LineError(words[0].column, "unknown-keyword", f"{words[0].text} is no keyword", f"did you mean {near}?")
    if not ended and words[at].kind != "NAME" and words[at].text.isalpha() and "NAME" in fault.expected:
        return LineError(column, "syntax", f"{words[at].text} is a keyword and no name", "use another name")
    found = "the line ends too early" if ended else f"{words[at].text!r} does not belong here"
    return LineError(column, "syntax", found, _allowed(fault))


def _open_bracket(words: list[Word]) -> Word | None:
    stack: list[Word] = []
    for word in words:
        if word.kind in _CLOSERS:
            stack.append(word)
        elif stack and word.kind == _CLOSERS[stack[-1].kind]:
            stack.pop()
    return stack[-1] if stack else None


def _near_keyword(first: Word) -> str | None:
    if first.kind != "NAME":
        return None
    upper = first.text.upper()
    near = get_close_matches(upper, [word for word in _FIRST_WORDS if word[0] == upper[0]], n=1, cutoff=0.66)
    return near[0] if near else None


def _allowed(fault: UnexpectedToken) -> str:
    kinds = set(fault.accepts or fault.expected)
    if kinds >= _MAYBE_NAMES:
        kinds -= _MAYBE_NAMES
    shown = sorted({_MARKS.get(kind, kind) for kind in kinds - {"$END", "BITS", "TRUTH"}})
    ends = ["the end of the line"] if "$END" in kinds else []
    return f"allowed here: {', '.join([*shown[:10], *ends])}"
