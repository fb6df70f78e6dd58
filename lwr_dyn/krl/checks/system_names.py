"""Names that begin with `$` and that no list has: the one that was probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.names.known_names import KnownNames
from lwr_dyn.krl.project.program import Scope, slip_of

SHORTEST = 3
"""Characters of a name, with `$`, with which an unknown one is compared."""


def check_system_name(scope: Scope, x: e.Name) -> None:
    """Report an unknown `$` name that is one slip away from a known one, or written as another kind of name.

    A warning: options and other versions of KSS have names that no list here has. Of any other name nothing is said.
    """
    key = x.name.upper()
    if not key.startswith("$") or key in scope.known.variables or any(key in names.variables for names in scope.tables):
        return
    meant = system_name_meant(key, scope.known)
    if meant is not None:
        message = f"{x.name} is no system variable that is known"
        scope.report(x.column, "system-name", message, f"did you mean {meant}?", "warning")


@lru_cache(maxsize=1024)
def system_name_meant(key: str, known: KnownNames) -> str | None:
    """What an unknown `$` name in capitals stands for; None where nothing is near.

    >>> from lwr_dyn.krl.names.known_names import known_names
    >>> [system_name_meant(x, known_names()) for x in ("$TOLL", "$VEL_CP", "$VEL_PTP", "$MY_OPTION")]
    ['$TOOL', '$VEL.CP', '$VEL_AXIS[1] ... [6], or BAS(#VEL_PTP, ...)', None]
    """
    component = _component_meant(key, known)
    if component is not None:
        return component
    if key[1:] in known.enums.get("BAS_COMMAND", ()):
        axes = f"{key.removesuffix('_PTP')}_AXIS"
        variable = f"{axes}[1] ... [6], or " if axes in known.variables else ""
        return f"{variable}BAS(#{key[1:]}, ...)"
    return slip_of(key, _comparable(key, known), SHORTEST)


def _component_meant(key: str, known: KnownNames) -> str | None:
    """`$VEL.CP` for `$VEL_CP`."""
    for at in (i for i, letter in enumerate(key) if letter == "_"):
        kind = known.variables.get(key[:at])
        if kind is not None and not kind.dimensions and key[at + 1 :] in known.structures.get(kind.name, ()):
            return f"{key[:at]}.{key[at + 1 :]}"
    return None


def _comparable(key: str, known: KnownNames) -> Iterable[str]:
    """System variables of nearly that length; of the shortest, one letter more, one less or two swapped only."""
    names = (name for name in known.variables if name.startswith("$") and abs(len(name) - len(key)) <= 1)
    return (
        x for x in names if len(x) > SHORTEST or (len(x) == SHORTEST and (len(key) != len(x) or set(key) == set(x)))
    )
