"""What a run assumes: values that the program asks for and that neither it nor its files give, each listed once."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class Assumption:
    """One thing assumed: its name (`$T1`, `LIN with C_DIS`), what is taken, and where that comes from."""

    name: str
    value: str
    why: str

    def __str__(self) -> str:
        return f"{self.name} = {self.value} ({self.why})" if self.value else f"{self.name}: {self.why}"

    def to_json(self) -> dict[str, Any]:
        """As one JSON object."""
        return {"name": self.name, "value": self.value, "why": self.why}


@dataclass(slots=True, eq=False)
class Assumptions:
    """The assumptions of a run, in the order in which they were first needed."""

    noted: dict[str, Assumption] = field(default_factory=dict)

    def note(self, name: str, value: str, why: str) -> None:
        """Add one, unless that name is there already.

        >>> a = Assumptions(); a.note("$T1", "FALSE", "state default"); a.note("$T1", "TRUE", ""); print(*a.all())
        $T1 = FALSE (state default)
        """
        self.noted.setdefault(name, Assumption(name, value, why))

    def all(self) -> tuple[Assumption, ...]:
        """All of them."""
        return tuple(self.noted.values())
