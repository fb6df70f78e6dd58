"""The closed forms as texts in a small part of C, from which C, JavaScript, Python and machine code are made.

The part: functions on double and int, local arrays of a fixed size, for, while, if, ?:, functions of <math.h>. Sine,
cosine, arctangent and arccosine are functions of a text too, products, sums and quotients in a fixed order, so what is
made of one text has the same bits on every machine and in every language: for angles up to 1.6e6 rad; atan2 errs by at
most 1.6 units in the last place, acos by 2, sine and cosine by 3e-16.
"""

import re
from functools import cache
from importlib.resources import files
from typing import Any

FUNCTION = re.compile(r"(?m)^(?:/\*(?:(?!\*/).)*\*/\n)?(?:static )?(?:double|int|void) (\w+)\(.*?^}\n", re.S | re.M)

_NAMES = re.compile(r"\b(sin|cos|atan2|acos)\(")

ANGLE_NUMBERS: dict[str, Any] = {
    "PI_PARTS": (3.1415926534682512, 1.2154201012607932e-10, 4.044532497591901e-21),
    "SINE": (
        2.7314447669863995e-15, -7.643970296798572e-13, 1.6058977312464087e-10, -2.5052107616996182e-08,
        2.7557319219163234e-06, -0.00019841269841254974, 0.008333333333333316, -0.16666666666666666,
    ),
    "COSINE": (
        4.6464359591124806e-14, -1.1466252259718479e-11, 2.0876681558867395e-09, -2.7557318573366175e-07,
        2.480158729891355e-05, -0.0013888888888884767, 0.04166666666666666,
    ),
    "ARCTANGENT": (
        0.011152908092096216, -0.02895352123252625, 0.04283578705573422, -0.05157516225552972, 0.058664967492257074,
        -0.06665052856794013, 0.07692198451257941, -0.09090904370311348, 0.11111110990139533, -0.14285714284106285,
        0.199999999999916, -0.33333333333333326,
    ),
    "EIGHTH": 0.7853981633974483, "EIGHTH_REST": 3.061616997868383e-17,
    "SINE_TERMS": 8, "COSINE_TERMS": 7, "ARCTANGENT_TERMS": 12,
    "MAGIC": 6755399441055744.0, "PER_HALF_TURN": 0.3183098861837907,
}  # fmt: skip
"""Numbers of the functions of angles: pi in three parts, near-minimax polynomials, an eighth of a turn and its rest.

`tests/kinematics/closed_forms/test_texts.py` fits them again with mpmath.
"""


@cache
def closed_form_text(*names: str) -> str:
    """The texts of these names, one after the other."""
    folder = files("lwr_dyn.kinematics.closed_forms")
    return "\n".join((folder / f"{name}.c").read_text(encoding="utf-8") for name in names)


def with_own_angles(text: str) -> str:
    """A text whose calls of sin, cos, atan2 and acos are those of functions in front of it."""
    return closed_form_text("own_angles") + "\n" + _NAMES.sub(r"own_\1(", text)


def with_shared(text: str, entry: str) -> str:
    """A text with those functions of `shared.c` in front that its function `entry` needs."""
    return used_functions(closed_form_text("shared") + "\n" + text, (entry,))


def used_functions(text: str, wanted: tuple[str, ...]) -> str:
    """The text without the static functions that none of those wanted needs."""
    bodies = {match[1]: match[0] for match in FUNCTION.finditer(text)}
    needed, waiting = set[str](), list(wanted)
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            waiting += [other for other in bodies if re.search(rf"\b{other}\(", bodies[name])]
    return FUNCTION.sub(lambda match: match[0] if match[1] in needed else "", text)
