"""Tokens of one line of KRL: keywords in any case, names, numbers, strings, signs; a comment begins with `;`."""

import re
from dataclasses import dataclass
from importlib.resources import files

GRAMMAR = files("lwr_dyn.krl.language").joinpath("grammar.lark").read_text(encoding="ascii")
LONGEST = 8192
"""Most characters of code on one line; a comment may be longer."""
DEEPEST = 100
"""Most operators and opening brackets inside one another on a line, because later steps recurse over them."""

_GROUPS = {
    "KEYWORD": "END ENDFCT ENDDAT ELSE ENDIF ENDFOR ENDWHILE REPEAT LOOP ENDLOOP EXIT DEFAULT ENDSWITCH HALT CONTINUE "
    "RESUME ON_ERROR_PROCEED",
    "MOVE": "PTP LIN SPTP SLIN SPL PTP_REL LIN_REL SPTP_REL SLIN_REL SPL_REL ASYPTP",
    "CIRCULAR": "CIRC CIRC_REL SCIRC SCIRC_REL",
    "SPLINE": "SPLINE PTP_SPLINE",
    "BLEND": "C_PTP C_DIS C_ORI C_VEL C_SPL",
    "SIMPLE": "INT REAL BOOL CHAR",
    "ANALOG": "ANIN ANOUT",
    "TRUTH": "TRUE FALSE",
    "OR": "OR B_OR",
    "EXOR": "EXOR B_EXOR",
    "AND": "AND B_AND",
    "NOT": "NOT B_NOT",
}
_SINGLE = next(re.finditer(r"^%declare (.*)$", GRAMMAR, re.MULTILINE))[1].split()
KEYWORDS = {word: word for word in _SINGLE} | {word: kind for kind, words in _GROUPS.items() for word in words.split()}
"""Keyword -> the kind of token it is."""
_SIGNS = {
    ",": "_COMMA", "(": "_LPAR", ")": "_RPAR", "[": "_LSQB", "]": "_RSQB", "{": "BRACE", "}": "_RBRACE", ":": "_COLON",
    "=": "_EQUALS", ".": "_DOT", "+": "PLUSMINUS", "-": "PLUSMINUS", "*": "TIMES", "/": "TIMES", "==": "COMPARE",
    "<>": "COMPARE", "<=": "COMPARE", ">=": "COMPARE", "<": "COMPARE", ">": "COMPARE",
}  # fmt: skip
_NESTING = frozenset(
    ["PLUSMINUS", "TIMES", "NOT", "AND", "OR", "EXOR", "COMPARE", "_COLON", "_DOT", "_LPAR", "_LSQB", "BRACE"]
)
_OPENING = frozenset(["_LPAR", "_LSQB", "BRACE"])
_CLOSING = frozenset(["_RPAR", "_RSQB", "_RBRACE"])
_TOKEN = re.compile(
    r"""[ \t]*(?:(?P<NAME>[A-Za-z_$][A-Za-z0-9_$]*)
    |(?P<DECIMAL>(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)
    |(?P<INTEGER>[0-9]+)
    |(?P<SIGN>==|<>|<=|>=|[,()\[\]{}:=.+\-*/<>])
    |(?P<ENUMERATION>\#[ \t]*[A-Za-z_$][A-Za-z0-9_$]*)
    |(?P<STRING>"[^"]*")
    |(?P<BITS>'(?:[Bb][01]+|[Hh][0-9A-Fa-f]+)')
    |(?P<COMMENT>;.*)
    |$)""",
    re.VERBOSE,
)


@dataclass(slots=True)
class Token:
    """A token: its kind as `grammar.lark` names it, its text, its column from 1."""

    kind: str
    text: str
    column: int


class LineError(Exception):
    """A line with a syntax error: column (from 1), code, message, hint. Used inside this package only."""

    def __init__(self, column: int, code: str, message: str, hint: str) -> None:
        super().__init__(message)
        self.column, self.code, self.message, self.hint = column, code, message, hint


def tokens_of(text: str) -> tuple[list[Token], int | None]:
    """The tokens of a line, and the index where its comment begins; raises `LineError`.

    >>> [token.text for token in tokens_of("PTP P1 C_PTP ; go")[0]], tokens_of("PTP P1 C_PTP ; go")[1]
    (['PTP', 'P1', 'C_PTP'], 13)
    """
    cut = len(text) > LONGEST and ";" not in text[: LONGEST + 1]
    out: list[Token] = []
    end = 0
    next_match = _TOKEN.scanner(text[: LONGEST + 1] if cut else text).match  # type: ignore[attr-defined]
    while (match := next_match()) and (kind := match.lastgroup):
        at, end = match.span(kind)
        if kind == "COMMENT":
            return _checked(out, at), at
        out.append(_token(kind, match[kind], at, out))
    rest = text[end:].lstrip(" \t")
    if rest and not cut and len(text) - len(rest) < LONGEST:
        raise _bad_character(text, len(text) - len(rest))
    return _checked(out, len(text)), None


def _token(kind: str, text: str, at: int, before: list[Token]) -> Token:
    if kind == "NAME":
        keyword = KEYWORDS.get(text.upper())
        if keyword is not None and not (before and _names_member(before, keyword)):
            kind = keyword
    elif kind == "SIGN":
        kind = _SIGNS[text]
    return Token(kind, text, at + 1)


def _names_member(before: list[Token], keyword: str) -> bool:
    """Whether a keyword after these tokens is the name of a component or of a constant of an enumeration."""
    last = before[-1].kind
    if last in ("_DOT", "BRACE") or (last == "_COLON" and len(before) > 2 and before[-3].kind == "BRACE"):
        return True
    first = before[1].kind if before[0].kind == "GLOBAL" and len(before) > 1 else before[0].kind
    if first in ("STRUC", "ENUM"):
        return keyword != "SIMPLE" or last == "SIMPLE"
    return last == "_COMMA" and _innermost(before) == "BRACE"


def _innermost(tokens: list[Token]) -> str:
    """The kind of the bracket that is open after these tokens; empty without one."""
    closed = 0
    for token in reversed(tokens):
        if token.kind in _CLOSING:
            closed += 1
        elif token.kind in _OPENING:
            if not closed:
                return token.kind
            closed -= 1
    return ""


def _checked(tokens: list[Token], length: int) -> list[Token]:
    if length > LONGEST:
        hint = f"at most {LONGEST} characters before the comment"
        raise LineError(LONGEST + 1, "long-line", f"the line has more than {LONGEST} characters of code", hint)
    if len(tokens) > DEEPEST:
        _check_depth(tokens)
    return tokens


def _check_depth(tokens: list[Token]) -> None:
    """Operators and brackets count inside one another; a comma ends those before it in its bracket."""
    depths = [0]
    for token in tokens:
        kind = token.kind
        if kind == "_COMMA":
            depths[-1] = depths[-2] + 1 if len(depths) > 1 else 0
        elif kind in _CLOSING and len(depths) > 1:
            depths.pop()
        elif kind in _NESTING:
            depths[-1] += 1
            if kind in _OPENING:
                depths.append(depths[-1])
        if depths[-1] > DEEPEST:
            hint = f"at most {DEEPEST} inside one another; use intermediate variables"
            raise LineError(token.column, "long-line", f"more than {DEEPEST} operators and brackets in a row", hint)


def _bad_character(text: str, at: int) -> LineError:
    sign = text[at]
    if sign == '"':
        return LineError(at + 1, "open-string", "a string is not closed", 'close it with "')
    if sign == "'":
        return LineError(at + 1, "bad-literal", "not a binary or hexadecimal number", "write 'B0101' or 'H1F'")
    what = repr(sign) if sign.isprintable() else f"the character U+{ord(sign):04X}"
    return LineError(at + 1, "bad-character", f"{what} has no place in code", "ASCII only outside comments and strings")
