"""Places within a line: characters of the text, and the units in which an editor counts them."""

import re
from collections.abc import Sequence

_WORD = re.compile(r"#?[\w$.]+|\S?")


def characters(text: str, at: int, encoding: str) -> int:
    """The editor's units before a character (from 0) of a line; beyond its end one a character.

    >>> [characters("a\\U0001f916b", 2, encoding) for encoding in ("utf-8", "utf-16", "utf-32")]
    [5, 3, 2]
    """
    if text.isascii() or encoding == "utf-32":
        return at
    size, codec = (2, "utf-16-le") if encoding == "utf-16" else (1, "utf-8")
    return len(text[:at].encode(codec, "surrogatepass")) // size + max(0, at - len(text))


def column_at(text: str, units: int, encoding: str) -> int:
    """The character (from 0) of a line before which so many units stand.

    >>> column_at("a\\U0001f916b", 3, "utf-16")
    2
    """
    if text.isascii():
        return units
    sizes: Sequence[int] = [characters(text, at, encoding) for at in range(len(text) + 1)]
    return next((at for at, size in enumerate(sizes) if size >= units), len(text))


def word_length(text: str, at: int) -> int:
    """Characters of the word that begins at a character (from 0) of a line; at least one."""
    word = _WORD.match(text, min(at, len(text)))
    return max(1, 0 if word is None else len(word[0]))
