"""The errata ledger: every erratum of a data file with its proof, run anew, its effect and how certain it is.

An entry is "proven" when a computation shows the fault and its right reading; that computation is a function of the
paper's study. A ledger with a proven entry that has no proof, or whose proof fails, is wrong. "likely" has evidence
that no computation from printed numbers decides; "open" is listed without a verdict.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from lwr_dyn.arms.papers.schema import Erratum
from lwr_dyn.reproduction.case import PaperData


@dataclass(frozen=True, slots=True, eq=False)
class Proof:
    """A computation that shows a fault of a paper: a statement, whether its numbers bear it out, those numbers."""

    statement: str
    holds: bool
    numbers: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        plain = {name: x if isinstance(x, str) else float(x) for name, x in self.numbers.items()}
        object.__setattr__(self, "numbers", plain)
        object.__setattr__(self, "holds", bool(self.holds))

    @property
    def text(self) -> str:
        """Statement and numbers, a line each."""
        rows = [f"{name}: {x if isinstance(x, str) else format(x, '.6g')}" for name, x in self.numbers.items()]
        return "\n".join([self.statement, *rows])

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        return {"statement": self.statement, "numbers": dict(self.numbers), "holds": self.holds}


Prove = Callable[[PaperData], Proof]
"""A proof of an erratum, computed from the paper's data."""


@dataclass(frozen=True, slots=True, eq=False)
class LedgerEntry:
    """One erratum of a paper with its proof; None where it is not proven."""

    erratum: Erratum
    proof: Proof | None

    @property
    def holds(self) -> bool:
        """A proven entry has a proof that holds; the others claim nothing."""
        return self.erratum.status != "proven" or (self.proof is not None and self.proof.holds)

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        keys = ("id", "where", "printed", "read_as", "why", "effect", "severity", "status")
        proof = None if self.proof is None else self.proof.record()
        return {key: getattr(self.erratum, key) for key in keys} | {"proof": proof}


def ledger(data: PaperData, proofs: Mapping[str, Prove]) -> tuple[LedgerEntry, ...]:
    """An entry for every erratum of a paper, each proof run now."""
    return tuple(LedgerEntry(e, proofs[e.id](data) if e.id in proofs else None) for e in data.errata)
