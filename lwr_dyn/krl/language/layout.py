"""The layout of a KRL file: indentation by blocks, one space where words need it, keywords in capitals.

What a line means stays the same: a line whose statement or comment would change is kept as it stands. Kept byte for
byte are comments, strings, `&` lines, lines with a fault, ends of lines, and KUKA's inline forms, which are the lines
from a fold with parameters (`;FOLD ... ;%{PE} ...`) to its end. In a `.dat`, whose values the controller writes itself,
spaces inside a line stay too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from lwr_dyn.krl.language.blocks import CLOSERS, OPENERS, keyword_of
from lwr_dyn.krl.language.declarations import Def, Header
from lwr_dyn.krl.language.lexer import KEYWORDS, Token, tokens_of
from lwr_dyn.krl.language.source import SourceFile, SourceLine

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
        before = tokens[i - 1] if i else None
        ends_value = before is not None and (before.kind in _SIGNED or before.text in _CLOSE)
        if token.kind == "PLUSMINUS" and (value or not ends_value):
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


INDENT = 2
"""Spaces for each block."""
TAB = 4
"""Columns of a tabulator, where the place of a comment is kept."""
_PARTS = frozenset({"ELSE", "CASE", "DEFAULT"})
"""They split a block and stand one step less deep than its lines."""
_ENDS = frozenset({"END", "ENDFCT"})


def formatted(file: SourceFile, indent: int = INDENT) -> SourceFile:
    """The file with its layout put in order; formatting the result again changes nothing.

    >>> from lwr_dyn.krl.language.source import parse_text
    >>> print(formatted(parse_text("def a( )\\nif x==1 then;go\\nptp  P1\\nendif\\nend\\n", "a.src")[0]).text(), end="")
    DEF a()
      IF x == 1 THEN ;go
        PTP P1
      ENDIF
    END
    """
    depths, inline = _depths(file), inline_forms(file)
    lines = [
        line if kept else _formatted_line(line, " " * indent * depth, file.is_data)
        for line, depth, kept in zip(file.lines, depths, inline, strict=True)
    ]
    return replace(file, lines=tuple(lines))


def changed_lines(before: SourceFile, after: SourceFile) -> list[int]:
    """Numbers (from 1) of the lines whose text differs."""
    pairs = zip(before.lines, after.lines, strict=True)
    return [i for i, (a, b) in enumerate(pairs, 1) if a.text() != b.text()]


def _depths(file: SourceFile) -> Iterator[int]:
    """How many blocks each line is in: a routine, IF, LOOP ..., and a branch of SWITCH counts as one more."""
    open_: list[str] = []
    for line in file.lines:
        keyword = keyword_of(line.statement)
        if isinstance(line.statement, Def) or keyword in _ENDS:
            open_.clear()
        elif keyword in CLOSERS and open_ and open_[-1]:
            open_.pop()
        depth = len(open_) + open_.count("SWITCH")
        yield depth - 1 if depth and keyword in _PARTS else depth
        if isinstance(line.statement, Def) or keyword in OPENERS:
            open_.append(keyword)


def inline_forms(file: SourceFile) -> Iterator[bool]:
    """Whether each line belongs to an inline form."""
    folds: list[bool] = []
    for line in file.lines:
        word = (line.comment or "").split(maxsplit=1)[:1] if line.statement is None else []
        name = word[0].upper() if word else ""
        if name == "FOLD":
            folds.append(";%{" in (line.comment or "").replace(" ", ""))
        yield any(folds)
        if name == "ENDFOLD" and folds:
            folds.pop()


def _formatted_line(line: SourceLine, margin: str, is_data: bool) -> SourceLine:
    text = line.text()
    if not line.readable or isinstance(line.statement, Header):
        return line
    for capitals in (True, False):
        new = _layout(text, margin, capitals, is_data)
        if line.means(new):
            return replace(line, layout=new)
    return line


def _layout(text: str, margin: str, capitals: bool, is_data: bool) -> str:
    tokens, cut = tokens_of(text)
    if capitals:
        for token in tokens:
            if token.kind not in ("NAME", "STRING", "ENUMERATION") and token.text.upper() in KEYWORDS:
                token.text = token.text.upper()
    if is_data:
        code = _in_place(text[:cut].rstrip(" \t"), [(token.column - 1, token.text) for token in tokens])
    else:
        code = spaced(tokens)
    code = margin + code if code else ""
    if cut is None:
        return code
    comment = text[cut:]
    if not code:
        return margin + comment
    place = len(text[:cut].expandtabs(TAB))
    return code + " " * max(1, place - len(code)) + comment


def _in_place(code: str, tokens: list[tuple[int, str]]) -> str:
    """The code with the same spaces between its words."""
    for at, word in tokens:
        code = code[:at] + word + code[at + len(word) :]
    return code.lstrip(" \t")
