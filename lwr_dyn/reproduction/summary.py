"""How many numbers got which verdict and on what basis, and how many errata are proven: as records, tables, a text."""

from collections.abc import Mapping, Sequence
from typing import Any

from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.reproduction.case import COMPUTED, REPEATED, STRUCTURAL, ComparedExpression, Value
from lwr_dyn.reproduction.compare import AFTER, ASSUMED, DIFFERS, NEAR, NOT, REPRODUCED, ComparedNumber
from lwr_dyn.reproduction.ledger import LedgerEntry
from lwr_dyn.reproduction.verdicts import Verdicts

NEARNESS = f"near: within the digits or axes printed, or {NEAR:.0%} of the range printed in the row"
"""What "near" means, for tables and texts."""
COUNTED: Mapping[str, tuple[str, ...]] = {
    "printed": ("printed", "all"),
    COMPUTED: ("printed", COMPUTED, "all"),
    REPRODUCED: ("printed", COMPUTED, REPRODUCED),
    AFTER: ("printed", COMPUTED, AFTER),
    DIFFERS: ("printed", DIFFERS),
    STRUCTURAL: ("printed", STRUCTURAL, "all"),
    "repeated": ("printed", REPEATED, "all"),
    "assumed": ("printed", ASSUMED, "all"),
    "of them near": ("printed", ASSUMED, "near"),
    "no value": ("printed", NOT),
    "derived": ("derived", "all"),
    "of them computed": ("derived", COMPUTED, "all"),
    "errata": ("errata", "all"),
    "proven": ("errata", "proofs that hold"),
}
"""Heading -> place in the record of counts."""
COUNT_NOTE = f"""\
computed: from other numbers; of them reproduced as printed, or after an erratum; differs: of all kinds
structural: 0, +-1 and entries that stay whatever the numbers are
repeated: one number in print twice, a count, a place, or what an erratum was fitted to: compared, not computed
assumed: recomputed under conditions that are not printed; {NEARNESS}"""


def counts(verdicts: Verdicts, entries: Sequence[LedgerEntry]) -> dict[str, Any]:
    """Printed and derived numbers apart, by basis and verdict; errata by status."""
    proven = [e for e in entries if e.erratum.status == "proven"]
    return {
        **{
            kind: _counted([n for n in verdicts.numbers if n.block.derived == derived])
            for kind, derived in (("printed", False), ("derived", True))
        },
        "errata": {"all": len(entries), "proven": len(proven), "proofs that hold": sum(e.holds for e in proven)},
    }


def _counted(numbers: Sequence[ComparedNumber]) -> dict[str, Any]:
    out: dict[str, Any] = {"all": len(numbers)}
    for basis in (COMPUTED, STRUCTURAL, REPEATED):
        mine = [n.verdict for n in numbers if n.basis == basis]
        out[basis] = {"all": len(mine), **{verdict: mine.count(verdict) for verdict in (REPRODUCED, AFTER, DIFFERS)}}
    near = [n.near for n in numbers if n.verdict == ASSUMED]
    out[ASSUMED] = {"all": len(near), "near": near.count(True), "not near": near.count(False)}
    return out | {verdict: sum(n.verdict == verdict for n in numbers) for verdict in (DIFFERS, NOT)}


def count_table(records: Mapping[str, Mapping[str, Any]]) -> Table:
    """A row a paper, from `counts`, and a sum where there are several."""
    rows = [(paper, *(_at(record, place) for place in COUNTED.values())) for paper, record in records.items()]
    if len(rows) > 1:
        rows.append(("all", *map(sum, zip(*(row[1:] for row in rows), strict=True))))
    return Table("", ("paper", *COUNTED), rows, COUNT_NOTE)


def _at(record: Any, place: Sequence[str]) -> int:
    for key in place:
        record = record[key]
    return int(record)


def summary_text(verdicts: Verdicts, entries: Sequence[LedgerEntry], holds: bool) -> str:
    """The outcome in words: what is computed first, what is only assumed and not explained last."""
    counted = counts(verdicts, entries)
    printed, derived = counted["printed"], counted["derived"]
    mine = printed[COMPUTED]
    parts = [
        f"Of {printed['all']} printed numbers {mine['all']} are computed from other numbers: {mine[REPRODUCED]} are "
        f"reproduced as printed, {mine[AFTER]} after an erratum, {mine[DIFFERS]} differ.",
        f"{printed[STRUCTURAL]['all']} are structural and {printed[REPEATED]['all']} repeated in print: compared, not"
        f" computed; {printed[STRUCTURAL][DIFFERS] + printed[REPEATED][DIFFERS]} of them differ.",
    ]
    if printed[NOT]:
        parts.append(f"{printed[NOT]} cannot be computed: {_missing(verdicts, NOT)} not printed.")
    if assumed := printed[ASSUMED]["all"]:
        near, far = (printed[ASSUMED][key] for key in ("near", "not near"))
        parts.append(
            f"{assumed} are recomputed under assumed conditions ({_missing(verdicts, ASSUMED)} not printed):"
            f" {near} near, {far} not near ({NEARNESS})."
        )
        parts += [f"Why {far} are not near is not explained."] if far else []
    if derived["all"]:
        parts.append(f"Of {derived['all']} derived numbers {derived[COMPUTED]['all']} are computed.")
    if counted["errata"]["all"]:
        parts.append(f"{counted['errata']['proofs that hold']} of {counted['errata']['all']} errata are proven.")
    if not holds:
        parts.append("Something computed, checked or claimed is NOT explained.")
    return " ".join(parts)


def verdict_sentence(verdicts: Verdicts, entries: Sequence[LedgerEntry], holds: bool) -> tuple[tuple[str, bool], ...]:
    """The outcome for the head of a page, with its reasons: pieces of text, each with whether it stands out."""
    printed = counts(verdicts, entries)["printed"]
    mine, same = printed[COMPUTED], printed[STRUCTURAL]["all"] + printed[REPEATED]["all"]
    good = mine[REPRODUCED] + mine[AFTER]
    ways = [f"{mine[REPRODUCED]} as printed", *([f"{mine[AFTER]} after an erratum"] if mine[AFTER] else [])]
    out = [(f"{good} of {printed['all']}", True), (f" printed numbers come out: {', '.join(ways)}.", False)]
    if agree := same - printed[STRUCTURAL][DIFFERS] - printed[REPEATED][DIFFERS]:
        out.append((f" {agree} more agree, but are structural or repeated in print.", False))
    if assumed := printed[ASSUMED]["all"]:
        near, far = (printed[ASSUMED][key] for key in ("near", "not near"))
        needs = _missing(verdicts, ASSUMED).replace(".", " ")
        why = f" For {assumed} the paper leaves out {needs}: with assumed values {near} come near"
        out.append((f"{why}; why {far} do not is not explained." if far else f"{why}.", False))
    if printed[NOT]:
        out.append((f" {printed[NOT]} cannot be computed: {_missing(verdicts, NOT)} not printed.", False))
    differ = printed[DIFFERS]
    out.append((f" {differ} differ." if differ else " None that the paper lets recompute differs.", True))
    return (*out, *([] if holds else [(" Something computed, checked or claimed is NOT explained.", True)]))


def _missing(verdicts: Verdicts, verdict: str) -> str:
    """What numbers with a verdict need and the paper does not print."""
    needs = dict.fromkeys(need for n in verdicts.numbers if n.verdict == verdict for need in n.missing)
    return ", ".join(needs)


def difference_table(verdicts: Verdicts) -> Table:
    """Every number that differs, with D in its unit and in last digits."""
    differing = [number for number in verdicts.numbers if number.verdict == DIFFERS]
    rows = [(n.cell.path.removeprefix("results."), n.cell.printed, n.value, n.miss, n.digits) for n in differing]
    recomputed = Heading("recomputed", format=_value)
    sizes = (Heading(name, format="+.3g") for name in ("D", "in last digits"))
    return Table("", ("cell", "printed", recomputed, *sizes), rows)


def _value(value: Value) -> str:
    return value.text if isinstance(value, ComparedExpression) else f"{value:.8g}"
