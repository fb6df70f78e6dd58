"""Seeded changes of good input: numbers, rows, names, types, a little of the text; most results are still readable."""

from __future__ import annotations

import random
import re

NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORD = re.compile(r"[A-Za-z_]{3,}")
VALUES = (
    "0", "-0.0", "1", "-1", "2", "0.5", "1e-9", "1e9", "1e-160", "1e200", "1e308", "-1e308", "5e-324", "1e999", "nan",
    "inf", "-inf", "9" * 30, "0x1F", "1_000", "1,5", "'1'", "true", "", "99999999999", str(2**63), "3.141592653589793",
)  # fmt: skip
SCRAPS = (
    "", " ", "\n", "\t", "\0", "\ufeff", "ö", "空", "\u202e", '"', "'", "<", ">", "&", "]]>", "<!--", "[", "]", "{",
    "}", ",", ";", "=", "#", "\\", "\\u0000", "%n", "../", "/dev/zero", "-", "--", "[[", "]]", "e", ".", "\r",
    "\x1b[31m", "A" * 300,
)  # fmt: skip


def changed(text: str, rng: random.Random, kinds: str = "nnnnnnvrrwdsx") -> str:
    """One to three small changes of a text; `kinds` weighs them by letter."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        text = CHANGES[rng.choice(kinds)](text, rng)
    return text


def _replaced(text: str, pattern: re.Pattern[str], rng: random.Random, new: object) -> str:
    found = list(pattern.finditer(text))
    if not found:
        return text
    match = rng.choice(found)
    return text[: match.start()] + (new(match[0]) if callable(new) else str(new)) + text[match.end() :]


def _number(text: str, rng: random.Random) -> str:
    """Another number of its size."""
    factor = rng.choice((-1.0, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1e3, 1e-3))
    return _replaced(text, NUMBER, rng, lambda old: f"{float(old) * factor:.6g}" if len(old) < 30 else old)


def _value(text: str, rng: random.Random) -> str:
    return _replaced(text, NUMBER, rng, rng.choice(VALUES))


def _word(text: str, rng: random.Random) -> str:
    """A name misspelt, or another name of the text."""
    words = WORD.findall(text) or ["x"]
    return _replaced(text, WORD, rng, lambda old: rng.choice((old[:-1], old.upper(), old + "ö", rng.choice(words))))


def _row(text: str, rng: random.Random) -> str:
    """A line left out, doubled, or exchanged with another."""
    lines = text.splitlines(keepends=True)
    if len(lines) < 2:
        return text
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(3)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(j, lines[i])
    else:
        lines[i], lines[j] = lines[j], lines[i]
    return "".join(lines)


def _piece(text: str, rng: random.Random) -> str:
    """A piece copied to another place."""
    i, j = rng.randrange(len(text) + 1), rng.randrange(len(text) + 1)
    return text[:j] + text[i : i + rng.randint(1, 60)] + text[j:]


def _scrap(text: str, rng: random.Random) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice(SCRAPS) + text[at + rng.choice((0, 0, 1, 5)) :]


def _cut(text: str, rng: random.Random) -> str:
    return text[: rng.randrange(len(text) + 1)] if rng.random() < 0.3 else text


CHANGES = {"n": _number, "v": _value, "w": _word, "r": _row, "d": _piece, "s": _scrap, "x": _cut}


def flipped(data: bytes, rng: random.Random) -> bytes:
    """One to four bytes of a file changed, or its end cut off."""
    out = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        if out:
            out[rng.randrange(len(out))] = rng.randrange(256)
    return bytes(out[: rng.randrange(len(out) + 1)]) if rng.random() < 0.1 else bytes(out)
