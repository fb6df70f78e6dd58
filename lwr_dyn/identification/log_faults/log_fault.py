"""One fault of a log, for people and for programs."""

from dataclasses import dataclass
from typing import Literal

FaultKind = Literal["saturated", "still", "silent", "sign", "order", "unit"]


@dataclass(frozen=True, slots=True)
class LogFault:
    """What is wrong with logs: `kind`, which `joints` (from 1), `where` (files, columns), `found` and `needed`.

    A `severe` one makes any fit meaningless; with another the fit stands and says less.
    """

    kind: FaultKind
    joints: tuple[int, ...]
    where: str
    found: str
    needed: str
    severe: bool = False

    def __str__(self) -> str:
        return f"{self.where}: {self.found}; needed: {self.needed}"
