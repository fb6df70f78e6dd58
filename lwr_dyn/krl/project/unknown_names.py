"""Names that nothing declares: each is reported once a file, where it stands first, with its number of places."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition

NEAR_NAMES = 20
"""Names of a file for which a similar known one is looked for: that takes milliseconds each."""

COMPARED = 300
"""Known names that are compared letter by letter with an unknown one."""
SAME_LETTERS = 0.6
"""Share of the letters of an unknown name that a similar one has."""


@dataclass(slots=True, eq=False)
class UnknownNames:
    """The unknown names of one file, in the order in which they were met."""

    found: dict[str, Diagnostic] = field(default_factory=dict)
    """By message in capitals: at the first place."""
    places: dict[str, int] = field(default_factory=dict)

    def note(
        self, position: SourcePosition, code: str, message: str, name: str, known: Iterable[str], hint: str
    ) -> None:
        """Count a place; at the first one, look for a similar name among those that are known."""
        key = message.upper()
        self.places[key] = self.places.get(key, 0) + 1
        if key in self.found:
            return
        near = near_name(name, known) if len(self.found) < NEAR_NAMES else None
        hint = hint if near is None else f"did you mean {near}?"
        self.found[key] = Diagnostic(position, "error", code, message, hint)

    def diagnostics(self) -> Iterator[Diagnostic]:
        """One of each name."""
        for key, diagnostic in self.found.items():
            n = self.places[key]
            yield diagnostic if n == 1 else replace(diagnostic, message=f"{diagnostic.message} ({n} places)")


def near_name(name: str, known: Iterable[str]) -> str | None:
    """The most similar of the known names in any case; None where none is similar.

    >>> near_name("hight", ["HEIGHT", "WIDTH"])
    'HEIGHT'
    """
    upper = name.upper()
    letters, reach = set(upper), 1 + len(upper) // 4
    by_capitals = {
        key: word for word in known if abs(len(word) - len(upper)) <= reach
        and len(letters.intersection(key := word.upper())) >= SAME_LETTERS * len(letters)
    }  # fmt: skip
    by_length = sorted(by_capitals, key=lambda key: (abs(len(key) - len(upper)), key))
    near = get_close_matches(upper, by_length[:COMPARED], n=1, cutoff=0.6)
    return by_capitals[near[0]] if near else None


def slip_of(name: str, known: Iterable[str]) -> str | None:
    """The known name from which one differs by one slip: a letter left out, added or replaced, or two swapped.

    Digits do not count, and names of three letters are too short to tell.

    >>> slip_of("INITMVO", ["INITMOV", "TOOL"]), slip_of("TOOL1", ["TOOL2"])
    ('INITMOV', None)
    """
    upper = name.upper()
    return next((word for word in known if len(word) > 3 and _is_slip(upper, word.upper())), None)


def _is_slip(one: str, other: str) -> bool:
    if abs(len(one) - len(other)) > 1 or one == other:
        return False
    begin = next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))
    one, other = one[begin:], other[begin:]
    while one and other and one[-1] == other[-1]:
        one, other = one[:-1], other[:-1]
    swapped = len(one) == 2 and one == other[::-1]
    return (one + other).isalpha() and (swapped or max(len(one), len(other)) == 1)
