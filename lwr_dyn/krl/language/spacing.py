"""The words of one line of KRL with the spaces between them."""

from collections.abc import Sequence

from lwr_dyn.krl.language.lexer import Token

_OPEN, _CLOSE = frozenset("([{"), frozenset(")]}")
_TIGHT_BEFORE = _CLOSE | frozenset(",.[")
_TIGHT_AFTER = _OPEN | {"."}
_MODES = frozenset({"IN", "OUT", "INOUT"})
_SIGNED = frozenset({"NAME", "INTEGER", "DECIMAL", "STRING", "BITS", "TRUTH", "ENUMERATION"})
"""After one of these (or a closing bracket) + and - join two values; elsewhere they are signs."""


def spaced(tokens: Sequence[Token]) -> str:
    """The words with one space where one belongs: around operators, after a comma, between words.

    >>> from lwr_dyn.krl.language.lexer import tokens_of
    >>> spaced(tokens_of("x=a[ 1 ]*( -b+{X  -1,Y 2} : f (c ,d))")[0])
    'x = a[1] * (-b + {X -1, Y 2} : f(c, d))'
    """
    signs = _signs(tokens)
    out = ""
    for i, token in enumerate(tokens):
        out += " " if i and _space(tokens, i, signs) else ""
        out += token.text
    return out


def _space(tokens: Sequence[Token], i: int, signs: frozenset[int]) -> bool:
    """Whether a space stands before word `i`."""
    before, here = tokens[i - 1], tokens[i]
    if here.text in _TIGHT_BEFORE or before.text in _TIGHT_AFTER or i - 1 in signs:
        return False
    if here.text == "(":
        return before.kind != "NAME"
    if here.text == ":":
        return not _is_tight(tokens, i)
    if before.text == ":":
        return here.text.upper() not in _MODES
    return True


def _is_tight(tokens: Sequence[Token], i: int) -> bool:
    """Whether the colon `i` stands right behind a word: a label, a parameter's mode, the type of an aggregate."""
    if i + 1 == len(tokens) or tokens[i + 1].text.upper() in _MODES:
        return True
    return i >= 2 and tokens[i - 2].text == "{"


def _signs(tokens: Sequence[Token]) -> frozenset[int]:
    """The places of + and - that are signs of a number, not operators of two values."""
    found = set()
    open_: list[str] = []
    names = False
    """Whether the next word names a component of an aggregate."""
    value = False
    """Whether the next word begins the value of a component."""
    for i, token in enumerate(tokens):
        text = token.text
        if token.kind == "PLUSMINUS" and (i == 0 or value or not _ends_value(tokens[i - 1])):
            found.add(i)
        named = names and token.kind != "BRACE"
        if text in _OPEN:
            open_.append(text)
        elif text in _CLOSE and open_:
            open_.pop()
        inside = bool(open_) and open_[-1] == "{"
        # {TYPE: NAME value, NAME[1] value}
        value = named or (value and text in "[") or (inside and text == "]" and _ends_name(tokens, i))
        names = inside and (text in ("{", ",") or (text == ":" and tokens[i - 2].text == "{"))
    return frozenset(found)


def _ends_name(tokens: Sequence[Token], i: int) -> bool:
    """Whether the bracket `]` at `i` ends the name of a component: {NAME[1] value}."""
    depth = 0
    for k in range(i, -1, -1):
        depth += (tokens[k].text == "]") - (tokens[k].text == "[")
        if depth == 0:
            return k >= 2 and tokens[k - 2].text in ("{", ",", ":")
    return False


def _ends_value(token: Token) -> bool:
    return token.kind in _SIGNED or token.text in _CLOSE
