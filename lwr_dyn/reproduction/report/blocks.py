"""Errata, checks, sections and files of a report as HTML that is readable without scripts."""

from collections.abc import Sequence

from lwr_dyn.reproduction.ledger import LedgerEntry
from lwr_dyn.reproduction.report.content import Check, Fact, FileFact, Section
from lwr_dyn.reproduction.report.markup import Html, anchor, element, grid, joined
from lwr_dyn.reproduction.report.printed_tables import sign
from lwr_dyn.tables import Table
from lwr_dyn.viewer.figures import Figure


def facts_html(facts: Sequence[Fact]) -> Html:
    """Names and their texts."""
    pairs = [item for name, text in facts for item in (element("dt", name), element("dd", text))]
    return element("dl", pairs, class_="facts-list")


def erratum_html(entry: LedgerEntry) -> Html:
    """An erratum: what is printed and what is right in one line, the proof on demand."""
    e, proof = entry.erratum, entry.proof
    heading = [
        element("span", e.id, class_="id"),
        element("span", e.where, class_="where"),
        element(
            "span",
            element("span" if e.status == "open" else "del", e.printed),
            element("span", " \u2192 ", aria_hidden="true"),
            element("span", "right: ", class_="word"),
            element("ins", e.read_as),
            class_="change",
        ),
        element("span", e.status if entry.holds else f"{e.status}, FAILS", class_=f"chip {_status(entry)}"),
    ]
    reason = ("reason", e.why) if proof is None else ("proof", f"{e.why}\n{proof.text}")
    facts: list[Fact] = [reason, ("checked", _outcome(entry)), ("effect", e.effect), ("severity", e.severity)]
    body = facts_html([(name, text) for name, text in facts if text])
    return element(
        "details", element("summary", heading), body, id=anchor("erratum", e.id), class_="erratum", tabindex=-1
    )


def _outcome(entry: LedgerEntry) -> str:
    if not entry.holds:
        return "THE COMPUTATION DOES NOT COME OUT AS STATED"
    return "no computation decides it" if entry.proof is None else "the computation comes out as stated"


def _status(entry: LedgerEntry) -> str:
    return "fails" if not entry.holds else "proven" if entry.erratum.status == "proven" else "likely"


def checks_html(checks: Sequence[Check]) -> Html:
    """Values against what is allowed."""
    rows = [
        (
            joined([check.name, element("small", check.note) if check.note else None]),
            element("td", check.value, class_="figure"),
            element("td", check.allowed, class_="figure"),
            element("td", sign("reproduced" if check.holds else "differs"), "holds" if check.holds else "FAILS"),
        )
        for check in checks
    ]
    return element("div", grid("checks", ("check", "value", "allowed", "outcome"), rows), class_="block")


def table_html(table: Table) -> Html:
    """A table, its cells tinted as their heading states."""
    rows = [
        [text if shade is None else _tinted(text, shade) for text, shade in zip(cells, shades, strict=True)]
        for cells, shades in zip(table.cells, table.shades, strict=True)
    ]
    return element(
        "div",
        element("h3", table.title) if table.title else None,
        element("p", table.note, class_="note") if table.note else None,
        grid(table.title, (h.title for h in table.columns), rows),
        class_="block",
    )


def _tinted(text: str, shade: float) -> Html:
    return element("td", text, class_="shaded", style=f"--shade: {min(max(shade, 0.0), 1.0):.3f}")


def figure_html(figure: Figure) -> Html:
    """The place of a figure; the script fills it."""
    name = anchor("plot", figure.id)
    caption = element(
        "figcaption",
        element("h3", figure.title, element("span", figure.where, class_="where") if figure.where else None, id=name),
        element("p", figure.note, class_="note") if figure.note else None,
    )
    place = element("div", class_="plot", data_plot=figure.id, role="group", aria_labelledby=name)
    return element("figure", caption, place, class_="block")


def _paragraph(text: str) -> Html:
    """Text as a paragraph; columns aligned with spaces are kept."""
    return element("pre", text, tabindex=0) if "  " in text else element("p", text)


def section_html(section: Section) -> list[Html]:
    """The body of a section."""
    text = [_paragraph(part) for part in section.text.split("\n\n") if part.strip()]
    return [
        element("div", text, class_="prose"),
        *map(table_html, section.tables),
        *map(figure_html, section.figures),
    ]


def files_html(files: Sequence[FileFact]) -> Html:
    """Files with their sizes and hashes."""
    rows = [
        (
            file.name,
            file.what,
            element("td", f"{file.size:,}".replace(",", "\u202f"), class_="figure"),
            element("td", element("code", file.sha256), class_="hash"),
        )
        for file in files
    ]
    return element("div", grid("files", ("file", "what", "bytes", "SHA-256"), rows), class_="block")
