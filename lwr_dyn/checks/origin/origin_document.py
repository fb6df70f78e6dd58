"""What was found of a file's origin, for people and programs."""

from collections.abc import Iterator

from lwr_dyn.checks.origin.link_numbers import LinkNumbers
from lwr_dyn.checks.origin.tracing import CellDifference, KindTrace, Trace
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.tables import Heading, Table

MOST_DIFFERENCES = 20
"""Rows that text shows."""


def origin_document(file: str, links: LinkNumbers, trace: Trace | None) -> Document:
    """The set that the numbers come from, kind by kind, and the cells in which they differ."""
    found = trace if trace is not None and trace.is_copy else None
    kinds = () if found is None else found.kinds
    pairs = [] if found is None else [(links.names[i], j + 1) for i, j in found.pairs]
    facts = [
        Fact("file", file, "As given."),
        Fact("origin", None if found is None else found.known.name, "ROBOT:READING, null where it copies no set here.",
             kind=str | None),
        Fact("digits", 0.0 if trace is None else trace.digits,
             "In which links agree with those of the nearest set, beyond chance."),
    ]  # fmt: skip
    sections = [
        Section("", [_kinds(kinds, len(pairs)), *_notes(links, found)]),
        Section("Where they differ", [_differences(() if found is None else found.differences)]),
        Section("", [Table("", (Heading(key="link"), Heading(key="number", kind=int)), pairs, key="links",
                           says="Links of the file, and the number of the set's link that each agrees with.",
                           when=False)]),
    ]  # fmt: skip
    return Document(f"Origin of {file}", _verdict(file, found, trace), sections, "lwr-dyn origin", facts=facts)


def _verdict(file: str, found: Trace | None, trace: Trace | None) -> str:
    if found is None:
        near = (
            "" if trace is None else f" (nearest: {trace.known.name}, {trace.digits:.1f} digits, less than a copy has)"
        )
        return f"{file}: the numbers of no published set here{near}"
    about = f", {found.known.about}" if found.known.about else ""
    return f"{file}: numbers of {found.known.name}{about}; {len(found.pairs)} links agree, {found.digits:.0f} digits"


def _kinds(kinds: tuple[KindTrace, ...], pairs: int) -> Table:
    headings = (
        Heading("numbers", key="kind"), Heading("links that agree", key="agree"), Heading("of", key="of"),
        Heading("compared", key="how"),
        Heading("file / set", "", lambda power: f"10^{power}" if power else "1", "power",
                "The file's numbers are the set's times ten to this."),
        Heading("digits", "", ".0f", "digits"),
        Heading("also in", "", lambda names: ", ".join(names), "elsewhere", "Other sets with the same numbers.",
                list[str]),
    )  # fmt: skip
    rows = [(k.kind, k.agree, pairs, k.how, k.power, k.digits, [*k.elsewhere]) for k in kinds]
    return Table("", headings, rows, key="kinds", says="Masses, centres and tensors.")


def _notes(links: LinkNumbers, found: Trace | None) -> Iterator[Note]:
    if found is None:
        return
    paired = {i for i, _ in found.pairs}
    other = [name for i, name in enumerate(links.names) if i not in paired]
    yield Note(f"Not of that set: {', '.join(other)}.", bool(other))
    few = [k.kind for k in found.kinds if 2 * k.agree < len(found.pairs)]
    yield Note(
        f"Most {' and '.join(few)} are not the set's: changed, of another frame, or of another source.", bool(few)
    )
    turned = [k.kind for k in found.kinds if k.how != "as written" and k.kind not in few]
    yield Note(f"Cells of {' and '.join(turned)} are not compared one by one: axes differ.", bool(turned))


def _differences(found: tuple[CellDifference, ...]) -> Table:
    headings = (
        Heading("link", key="link"), Heading("cell", key="cell"), Heading("file", "", ".6g", "file"),
        Heading("set", "", ".6g", "published"),
    )  # fmt: skip
    rows = [(x.link, x.cell, x.file, x.published) for x in found]
    title = f"{len(rows)} cells that are not the set's (kg, m, kg m^2)"
    return Table(title, headings, rows, key="differences", says="Cells compared one by one.", most=MOST_DIFFERENCES)
