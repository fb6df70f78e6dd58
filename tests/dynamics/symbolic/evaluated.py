"""The number of an equation's text."""

import math
import re

LETTER = re.compile(r"\b[A-Za-z]+\d+[xyz]*\b")


def evaluated(text, values):
    """The value of a text such as "m7*(c7z + d7)^2*cos(q7)" with numbers for its letters."""
    names = {letter: values[letter] for letter in LETTER.findall(text)}
    return eval(text.replace("^", "**"), {"__builtins__": {}, "sin": math.sin, "cos": math.cos}, names)


def state_letters(q, dq):
    """Numbers of q1, dq1 and so on."""
    numbered = zip((*q, *dq), [f"{d}{i + 1}" for d in ("q", "dq") for i in range(len(q))], strict=True)
    return {name: float(x) for x, name in numbered}
