"""The errata ledger: every slip that a data file names, its proof run anew, what it touches and how sure it is.

An entry is "proven" when a computation shows the slip and its right reading; that computation is a function of the
paper's room, it is run, and a ledger with a proven entry that has none, or whose proof fails, is wrong. "likely" has
evidence that no computation from printed numbers decides, "open" is told and left.
"""

from __future__ import annotations

from dataclasses import dataclass

from lwr_dyn.papers.reader import paper_of_tables
from lwr_dyn.papers.schema import Erratum
from lwr_dyn.reproduction.proof import Proof
from lwr_dyn.reproduction.rooms import Room


@dataclass(frozen=True, slots=True, eq=False)
class LedgerEntry:
    """One slip of a paper with its proof; None where it is not proven."""

    paper: str
    erratum: Erratum
    proof: Proof | None

    @property
    def holds(self) -> bool:
        """A proven entry has a proof that holds; the others claim nothing."""
        return self.erratum.status != "proven" or (self.proof is not None and self.proof.holds)


def errata_of(room: Room) -> tuple[Erratum, ...]:
    """Every slip that a paper's data file names."""
    return paper_of_tables(dict(room.tables), room.file).errata


def ledger(room: Room) -> tuple[LedgerEntry, ...]:
    """All entries of a paper, each proof run now."""
    return tuple(entry(room, erratum) for erratum in errata_of(room))


def entry(room: Room, erratum: Erratum) -> LedgerEntry:
    """One entry, its proof run now."""
    prove = room.proofs.get(erratum.id)
    return LedgerEntry(room.paper, erratum, None if prove is None else prove(room.evidence))
