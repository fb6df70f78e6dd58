"""Tokens of one line of KRL: keywords in any case, names, numbers, strings, signs; a comment begins with `;`."""

import re
from dataclasses import dataclass
from importlib.resources import files

GRAMMAR = files("lwr_dyn.krl.language").joinpath("grammar.lark").read_text(encoding="ascii")
LONGEST = 500
"""Most characters of code on one line; a comment may be longer."""
DEEPEST = 100
"""Most operators and opening brackets on one line, because later steps recurse over them."""

_GROUPS = {
    "KEYWORD": "END ENDFCT ENDDAT ELSE ENDIF ENDFOR ENDWHILE REPEAT LOOP ENDLOOP EXIT DEFAULT ENDSWITCH HALT CONTINUE "
    "RESUME BRAKE",
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
_TOKEN = re.compile(
    r"""[ \t]+
    |(?P<NAME>[A-Za-z_$][A-Za-z0-9_$]*)
    |(?P<DECIMAL>(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)
    |(?P<INTEGER>[0-9]+)
    |(?P<SIGN>==|<>|<=|>=|[,()\[\]{}:=.+\-*/<>])
    |(?P<ENUMERATION>\#[A-Za-z_$][A-Za-z0-9_$]*)
    |(?P<STRING>"[^"]*")
    |(?P<BITS>'(?:[Bb][01]+|[Hh][0-9A-Fa-f]+)')
    |(?P<COMMENT>;.*)""",
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
    out: list[Token] = []
    at, end = 0, len(text)
    while at < end:
        match = _TOKEN.match(text, at)
        if match is None:
            raise _bad_character(text, at)
        kind = match.lastgroup
        if kind == "COMMENT":
            return _checked(out, at), at
        if kind is not None:
            out.append(_token(kind, match[0], at))
        at = match.end()
    return _checked(out, end), None


def _token(kind: str, text: str, at: int) -> Token:
    if kind == "NAME":
        kind = KEYWORDS.get(text.upper(), kind)
    elif kind == "SIGN":
        kind = _SIGNS[text]
    return Token(kind, text, at + 1)


def _checked(tokens: list[Token], length: int) -> list[Token]:
    if length > LONGEST:
        hint = f"at most {LONGEST} characters before the comment"
        raise LineError(LONGEST + 1, "long-line", f"the line has {length} characters of code", hint)
    deep = [token for token in tokens if token.kind in _NESTING]
    if len(deep) > DEEPEST:
        hint = f"at most {DEEPEST} operators and brackets; use intermediate variables"
        raise LineError(deep[DEEPEST].column, "long-line", f"the line has {len(deep)} operators and brackets", hint)
    return tokens


def _bad_character(text: str, at: int) -> LineError:
    sign = text[at]
    if sign == '"':
        return LineError(at + 1, "open-string", "a string is not closed", 'close it with "')
    if sign == "'":
        return LineError(at + 1, "bad-literal", "not a binary or hexadecimal number", "write 'B0101' or 'H1F'")
    what = repr(sign) if sign.isprintable() else f"the character U+{ord(sign):04X}"
    return LineError(at + 1, "bad-character", f"{what} has no place in code", "ASCII only outside comments and strings")
