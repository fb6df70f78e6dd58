"""How many printed numbers got which verdict, and how many errata are proven: as records and as tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from lwr_dyn.reproduction.case import ComparedExpression, Value
from lwr_dyn.reproduction.compare import AFTER, DIFFERS, NOT, REPRODUCED
from lwr_dyn.reproduction.ledger import LedgerEntry
from lwr_dyn.reproduction.verdicts import Verdicts
from lwr_dyn.tables import Heading, Table

COUNTED = {
    "printed": ("printed", "all"),
    **{verdict: ("printed", verdict) for verdict in (REPRODUCED, AFTER, DIFFERS, NOT)},
    "derived": ("derived", "all"),
    "of them reproduced": ("derived", REPRODUCED),
    "errata": ("errata", "all"),
    "proven": ("errata", "proofs that hold"),
}
"""Heading -> place in the record of counts."""


def counts(verdicts: Verdicts, entries: Sequence[LedgerEntry]) -> dict[str, Any]:
    """Printed and derived numbers apart, errata by status."""
    proven = [e for e in entries if e.erratum.status == "proven"]
    numbers = {"printed": verdicts.counts(), "derived": verdicts.counts(derived=True)}
    return {
        **{kind: {"all": sum(counted.values()), **counted} for kind, counted in numbers.items()},
        "errata": {"all": len(entries), "proven": len(proven), "proofs that hold": sum(e.holds for e in proven)},
    }


def count_table(records: Mapping[str, Mapping[str, Any]]) -> Table:
    """A row a paper, from `counts`, and a sum where there are several."""
    rows = [(paper, *(record[kind][key] for kind, key in COUNTED.values())) for paper, record in records.items()]
    if len(rows) > 1:
        rows.append(("all", *map(sum, zip(*(row[1:] for row in rows), strict=True))))
    return Table("", ("paper", *COUNTED), rows)


def difference_table(verdicts: Verdicts) -> Table:
    """Every number that differs, with D in its unit and in last digits."""
    differing = [number for number in verdicts.numbers if number.verdict == DIFFERS]
    rows = [(n.cell.path.removeprefix("results."), n.cell.printed, n.value, n.miss, n.digits) for n in differing]
    recomputed = Heading("recomputed", format=_value)
    sizes = (Heading(name, format="+.3g") for name in ("D", "in last digits"))
    return Table("", ("cell", "printed", recomputed, *sizes), rows)


def _value(value: Value) -> str:
    return value.text if isinstance(value, ComparedExpression) else f"{value:.8g}"
