"""One line of KRL -> its statement, by lark's LALR(1) parser; the grammar is `grammar.lark` beside this file.

Lines of one shape (the same kinds of tokens in the same order) have the same parse tree. lark builds it once, as a
recipe; later lines of that shape only fill in their own tokens.
"""

import re
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, TypeAlias

from lark import Lark, Tree
from lark import Token as LarkToken
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer

from lwr_dyn.krl.language import declarations, expressions, statements
from lwr_dyn.krl.language.declarations import Header
from lwr_dyn.krl.language.lexer import GRAMMAR, KEYWORDS, LineError, Token, tokens_of
from lwr_dyn.krl.language.statements import Statement

SHAPES = 4096
"""Shapes of lines whose recipe is kept."""
LINES = 1 << 16
"""Lines that are kept by their text: programs repeat theirs, and an editor asks for all again after each change."""
LONGEST_KEPT = 500
"""[characters] A longer line is not kept."""
ParseRecipe: TypeAlias = "tuple[Callable[[list[Any]], Any], tuple[ParseRecipe | int | None, ...]]"
"""The function of a rule and its arguments: another recipe, the index of a token, or None for a part left out."""
ParsedLine: TypeAlias = tuple[Statement | None, str | None] | LineError
"""A line's statement and comment, or its fault."""
RULES = {**expressions.RULES, **declarations.RULES, **statements.RULES}
"""Rule of the grammar -> the function that builds its record from the list of its parts."""
_DESCRIPTIONS = {
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
    re.findall(r"\w+", "SEC STEP CA DISTANCE PATH ONSTART DELAY PRIO ENABLE DISABLE MINIMUM MAXIMUM PUBLIC STOP")
)


def parse_line(text: str) -> tuple[Statement | None, str | None]:
    """The statement of a line and its comment after the semicolon; None for what the line does not have.

    Raises `LineError`.

    >>> parse_line("HALT ; wait here")
    (Plain(keyword='HALT'), ' wait here')
    """
    line = _kept_line(text) if len(text) <= LONGEST_KEPT else _line(text)
    if isinstance(line, LineError):
        raise LineError(line.column, line.code, line.message, line.hint)
    return line


def statement_of(text: str) -> Statement | None:
    """The statement of a line; None without one, or where the line has a syntax error."""
    try:
        return parse_line(text)[0]
    except LineError:
        return None


def _line(text: str) -> ParsedLine:
    if text.lstrip().startswith("&"):
        return Header(text.strip()), None
    try:
        tokens, cut = tokens_of(text)
        comment = None if cut is None else text[cut + 1 :]
        if not tokens:
            return None, comment
        recipe = _recipe(tuple([token.kind for token in tokens]))
        if isinstance(recipe, _Misfit):
            return _syntax_error(tokens, recipe)
        return _filled(recipe, tokens), comment
    except LineError as fault:
        return fault.with_traceback(None)


_kept_line = lru_cache(maxsize=LINES)(_line)


def _filled(recipe: ParseRecipe, tokens: Sequence[Token]) -> Any:
    build, parts = recipe
    return build([p if p is None else tokens[p] if isinstance(p, int) else _filled(p, tokens) for p in parts])


@dataclass(frozen=True, slots=True)
class _Misfit:
    """Why a shape is no line: the index of the first token that does not fit, and the kinds allowed there."""

    at: int
    allowed: frozenset[str]


@lru_cache(maxsize=SHAPES)
def _recipe(shape: tuple[str, ...]) -> "ParseRecipe | _Misfit":
    try:
        return _recipe_of_tree(_parser().parse(shape))
    except UnexpectedToken as fault:
        at = len(shape) if fault.token.type == "$END" else int(fault.token)
        return _Misfit(at, frozenset(fault.accepts or fault.expected))


def _recipe_of_tree(tree: Any) -> ParseRecipe:
    parts = (_recipe_of_tree(c) if isinstance(c, Tree) else None if c is None else int(c) for c in tree.children)
    return RULES[tree.data], tuple(parts)


class _Shape(Lexer):
    """Gives lark the kinds of tokens; the text of each is its index."""

    def __init__(self, lexer_conf: object) -> None:
        pass

    def lex(self, data: object) -> Iterator[LarkToken]:  # type: ignore[override]
        for i, kind in enumerate(data):  # type: ignore[arg-type, var-annotated]
            yield LarkToken(kind, str(i))


@lru_cache(maxsize=1)
def _parser() -> Lark:
    return Lark(GRAMMAR, parser="lalr", lexer=_Shape, start="line", maybe_placeholders=True)


def _syntax_error(tokens: list[Token], fault: _Misfit) -> LineError:
    at, ended = fault.at, fault.at == len(tokens)
    column = tokens[-1].column + len(tokens[-1].text) if ended else tokens[at].column
    bracket = _open_bracket(tokens[:at])
    if ended and bracket is not None:
        close = _DESCRIPTIONS[_CLOSERS[bracket.kind]]
        return LineError(bracket.column, "open-bracket", f"{bracket.text} is not closed", f"close it with {close}")
    first = tokens[0]
    near = _near_keyword(first)
    if near is not None and (len(tokens) < 2 or tokens[1].kind not in _AFTER_NAMES):
        return LineError(first.column, "unknown-keyword", f"{first.text} is no keyword", f"did you mean {near}?")
    if not ended and tokens[at].kind != "NAME" and tokens[at].text.isalpha() and "NAME" in fault.allowed:
        return LineError(column, "syntax", f"{tokens[at].text} is a keyword and no name", "use another name")
    if ended:
        short = _too_short(tokens)
        if short is not None:
            return LineError(column, "syntax", *short)
    message = "the line ends too early" if ended else f"{tokens[at].text!r} does not belong here"
    return LineError(column, "syntax", message, _allowed(fault.allowed))


def _too_short(tokens: list[Token]) -> tuple[str, str] | None:
    """What is missing in a line that ends too early, and the line that helps; None where that is not certain."""
    first = tokens[0].text
    if len(tokens) == 1 and tokens[0].kind == "NAME":
        return f"{first} alone is no statement", f"{first}() calls a subprogram, {first} = ... assigns"
    if tokens[0].kind == "CIRCULAR" and len(tokens) > 1 and not _has_outer_comma(tokens):
        return f"{first} needs an auxiliary point before the end", f"{first} AUX, TARGET"
    return None


def _has_outer_comma(tokens: list[Token]) -> bool:
    """Whether a comma stands outside of all brackets."""
    return any(x.kind == "_COMMA" and _open_bracket(tokens[:i]) is None for i, x in enumerate(tokens))


def _open_bracket(tokens: list[Token]) -> Token | None:
    stack: list[Token] = []
    for token in tokens:
        if token.kind in _CLOSERS:
            stack.append(token)
        elif stack and token.kind == _CLOSERS[stack[-1].kind]:
            stack.pop()
    return stack[-1] if stack else None


def _near_keyword(first: Token) -> str | None:
    if first.kind != "NAME":
        return None
    upper = first.text.upper()
    near = get_close_matches(upper, [word for word in _FIRST_WORDS if word[0] == upper[0]], n=1, cutoff=0.66)
    return near[0] if near else None


def _allowed(kinds: Set[str]) -> str:
    if kinds >= _MAYBE_NAMES:
        kinds = kinds - _MAYBE_NAMES
    shown = sorted({_DESCRIPTIONS.get(kind, kind) for kind in kinds - {"$END", "BITS", "TRUTH"}})
    ends = ["the end of the line"] if "$END" in kinds else []
    return f"allowed here: {', '.join([*shown[:10], *ends])}"
