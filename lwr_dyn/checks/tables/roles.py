"""The role of a column by its heading: mean, maximum, minimum, label, and of which quantity; names and units."""

import re
from collections.abc import Mapping

ROLES: dict[str, tuple[str, ...]] = {
    "mean": ("mean", "avg", "average", "averages"),
    "mean_abs": ("meanabs", "mae"),
    "max": ("max", "maximum", "maxima", "upper", "highest", "largest"),
    "min": ("min", "minimum", "minima", "lower", "lowest", "smallest"),
    "rms": ("rms", "rmse"),
    "label": ("joint", "joints", "link", "links", "axis", "name", "row", "no", "i", "body", "part", "configuration"),
}
"""Role -> words of a heading that name it."""
TOTALS = ("total", "sum", "totals", "overall", "all")
"""Words in a row's label that make it the sum of the rows above."""
_UNIT = re.compile(r"[\[(]([^\])]*)[\])]\s*$")


def words_of(heading: str) -> list[str]:
    """The words of a heading, lower case, without its unit.

    >>> words_of("Avg. Pos. Error (mm)"), words_of("velocityMaximum")
    (['avg', 'pos', 'error'], ['velocity', 'maximum'])
    """
    bare = re.sub(r"([a-z])([A-Z])", r"\1 \2", _UNIT.sub("", heading))
    return re.findall(r"[a-z]+|\d+", bare.lower())


def unit_in(heading: str) -> str:
    """The unit in brackets at the end of a heading.

    >>> unit_in("Mass [kg]"), unit_in("Kp")
    ('kg', '')
    """
    match = _UNIT.search(heading.strip())
    return match.group(1).strip() if match else ""


def name_in(heading: str) -> str:
    """The heading without its unit.

    >>> name_in("Avg. Pos. Error (mm)")
    'Avg. Pos. Error'
    """
    return _UNIT.sub("", heading).strip() or heading


def plain_name(name: str) -> str:
    """A name that a formula can use.

    >>> plain_name("Avg. Pos. Error"), plain_name("K_P")
    ('Avg_Pos_Error', 'K_P')
    """
    return re.sub(r"\W+", "_", name).strip("_")


def role_of(heading: str, declared: Mapping[str, str]) -> str:
    """The declared role, or that of the first word that has one; "" without any.

    >>> role_of("velocity_average", {}), role_of("Kp", {})
    ('mean', '')
    """
    if heading in declared:
        return declared[heading]
    words = words_of(heading)
    return next((role for word in words for role, known in ROLES.items() if word in known), "")


def stem_of(heading: str) -> tuple[str, ...]:
    """The heading without its role: columns of one stem are statistics of one quantity.

    >>> stem_of("velocity_average") == stem_of("velocity_minimum"), stem_of("average")
    (True, ())
    """
    known = {word for role, words in ROLES.items() if role != "label" for word in words}
    return tuple(w for w in words_of(heading) if w not in known)
