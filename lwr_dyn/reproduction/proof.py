"""A proof: a computation that shows a slip, with the numbers it found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from lwr_dyn.reproduction.case import PaperData

Number = float | str


@dataclass(frozen=True, slots=True, eq=False)
class Proof:
    """A computation that shows a slip: what it says, whether the numbers it found show it, and those numbers."""

    statement: str
    holds: bool
    numbers: Mapping[str, Number] = field(default_factory=dict)

    def __post_init__(self) -> None:
        plain = {name: x if isinstance(x, str) else float(x) for name, x in self.numbers.items()}
        object.__setattr__(self, "numbers", plain)
        object.__setattr__(self, "holds", bool(self.holds))

    @property
    def told(self) -> str:
        """Statement and numbers as one text."""
        rows = [f"{name}: {x if isinstance(x, str) else format(x, '.6g')}" for name, x in self.numbers.items()]
        return "\n".join([self.statement, *rows])


Prove = Callable[[PaperData], Proof]
"""What a room proves an erratum with."""
