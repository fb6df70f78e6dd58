"""JavaScript without comments and without the space that only people need; line ends stay, so no statement changes."""

import re
from collections.abc import Iterator

_TOKEN = re.compile(
    r"""(?P<text>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')"""
    r"|(?P<comment>//[^\n]*|/\*.*?\*/)"
    r"|(?P<template>`)|(?P<open>\{)|(?P<close>\})"
    r"|(?P<space>[ \t]+)|(?P<word>[\w$]+)|(?P<other>.)",
    re.DOTALL,
)
_TEMPLATE = re.compile(r"(?:\\.|\$(?!\{)|[^`\\$])*(?:`|\$\{)", re.DOTALL)
_REGULAR_EXPRESSION = re.compile(r"/(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\[\n])+/[a-z]*")
_BEFORE_REGULAR_EXPRESSION = frozenset("(,=:[!&|?{};>\n")
"""What stands before a regular expression, and never before a division."""


def without_space(script: str) -> str:
    """The script; strings, templates and regular expressions are copied.

    >>> print(without_space("a = `x ${ b + `y  z` } ` + 'c  d'; // why\\nreturn a - -1;"))
    a=`x ${b+`y  z`} `+'c  d';
    return a- -1;
    """
    out: list[str] = []
    gap = ""
    for kind, text in _tokens(script):
        if kind == "space":
            gap = " "
        elif kind != "comment":
            if gap and out and _needed(out[-1][-1], text[0]):
                out.append(gap)
            out.append(text)
            gap = ""
    lines = (line.strip() for line in "".join(out).split("\n"))
    return "\n".join(line for line in lines if line)


def _needed(before: str, after: str) -> bool:
    """Whether two characters would read otherwise without the space between."""
    words = [c.isalnum() or c in "_$" for c in (before, after)]
    return all(words) or (before == after and before in "+-/") or (words[0] and after == ".")


def _tokens(script: str) -> Iterator[tuple[str, str]]:
    """Kind and text of each token; a template is a token up to its next `${`, and one from each `}` of such on."""
    place, depths, last = 0, [0], "\n"
    while place < len(script):
        kind, text = _next(script, place, last)
        if kind == "template" or (kind == "close" and depths[-1] == 0 and len(depths) > 1):
            found = _TEMPLATE.match(script, place + 1)
            assert found is not None  # our own scripts are whole
            kind, text = ("template", script[place : found.end()])
            depths = _depths(depths, script[place], text)
        elif kind in ("open", "close"):
            depths[-1] += 1 if kind == "open" else -1
        place += len(text)
        last = last if kind in ("space", "comment") else text[-1]
        yield kind, text


def _depths(depths: list[int], first: str, text: str) -> list[int]:
    """Open braces in each `${` that is open, after a piece of a template."""
    outer = depths if first == "`" else depths[:-1]
    return [*outer, 0] if text.endswith("${") else outer


def _next(script: str, place: int, last: str) -> tuple[str, str]:
    expression = _REGULAR_EXPRESSION.match(script, place) if last in _BEFORE_REGULAR_EXPRESSION else None
    if expression is not None and script[place : place + 2] not in ("//", "/*"):
        return "other", expression[0]
    found = _TOKEN.match(script, place)
    assert found is not None
    return str(found.lastgroup), found[0]
