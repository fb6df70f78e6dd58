"""How many printed numbers got which verdict, and how many slips are proven: as text and as JSON values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lwr_dyn.reproduction.compare import AFTER, DIFFERS, NOT, REPRODUCED
from lwr_dyn.reproduction.ledger import LedgerEntry
from lwr_dyn.reproduction.verdicts import Verdicts
from lwr_dyn.tables import aligned

HEAD = (
    "paper", "printed", "reproduced", "after erratum", "differs", "not reproducible", "derived", "of them reproduced",
    "errata", "proven",
)  # fmt: skip


def counts(found: Verdicts, entries: Sequence[LedgerEntry]) -> dict[str, Any]:
    """Printed and derived numbers apart, errata by status."""
    proven = [e for e in entries if e.erratum.status == "proven"]
    return {
        "printed": {"all": sum(found.counts().values()), **found.counts()},
        "derived": {"all": sum(found.counts(True).values()), **found.counts(True)},
        "errata": {"all": len(entries), "proven": len(proven), "proofs that hold": sum(e.holds for e in proven)},
    }


def counts_text(records: dict[str, dict[str, Any]]) -> str:
    """A row a paper, from `counts`, and a sum where there are several."""
    rows = [_row(paper, found) for paper, found in records.items()]
    if len(rows) > 1:
        sums = [str(sum(int(row[i]) for row in rows)) for i in range(1, len(HEAD))]
        rows.append(("all", *sums))
    return aligned(rows, HEAD)


def _row(paper: str, found: dict[str, Any]) -> tuple[str, ...]:
    printed, derived, errata = found["printed"], found["derived"], found["errata"]
    numbers = [printed[name] for name in ("all", REPRODUCED, AFTER, DIFFERS, NOT)]
    numbers += [derived["all"], derived[REPRODUCED], errata["all"], errata["proofs that hold"]]
    return paper, *map(str, numbers)


def differing_text(found: Verdicts) -> str:
    """Every number that differs, with D in its unit and in last digits; empty when none does."""
    rows = [
        (
            j.cell.path.removeprefix("results."),
            j.cell.printed,
            _told(j.value),
            _difference(j.miss),
            _difference(j.digits),
        )
        for j in found.numbers
        if j.verdict == DIFFERS
    ]
    return aligned(rows, ("cell", "printed", "recomputed", "D", "in last digits")) if rows else ""


def _told(value: Any) -> str:
    return "-" if value is None else value.text if hasattr(value, "text") else f"{value:.8g}"


def _difference(value: float | None) -> str:
    return "-" if value is None else f"{value:+.3g}"
