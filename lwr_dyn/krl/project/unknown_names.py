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


def near_name(name: str, known: Iterable[str], like: float = 0.6) -> str | None:
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
    near = get_close_matches(upper, by_length[:COMPARED], n=1, cutoff=like)
    return by_capitals[near[0]] if near else None
