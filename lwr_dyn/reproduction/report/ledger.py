"""Errata, checks, sections and files of a report as HTML that is readable without scripts."""

from __future__ import annotations

from collections.abc import Sequence

from lwr_dyn.reproduction.report.content import Check, Erratum, Fact, FileFact, Section
from lwr_dyn.reproduction.report.markup import Html, anchor, element, grid, joined
from lwr_dyn.reproduction.report.tables import sign
from lwr_dyn.tables import Table
from lwr_dyn.viewer.figures import Figure


def facts_html(facts: Sequence[Fact]) -> Html:
    """Names and what is said of them."""
    pairs = [item for name, text in facts for item in (element("dt", name), element("dd", text))]
    return element("dl", pairs, class_="facts-list")


def erratum_html(erratum: Erratum) -> Html:
    """One slip: what is printed and what is right in one line, the proof on demand."""
    heading = [
        element("span", erratum.id, class_="id"),
        element("span", erratum.where, class_="where"),
        element(
            "span",
            element("span" if erratum.status == "open" else "del", erratum.printed),
            element("span", " \u2192 ", aria_hidden="true"),
            element("span", "right: ", class_="word"),
            element("ins", erratum.right),
            class_="change",
        ),
        element(
            "span", erratum.status if erratum.holds else f"{erratum.status}, FAILS", class_=f"chip {_status(erratum)}"
        ),
    ]
    told: list[Fact] = [("proof" if erratum.computed else "reason", erratum.proof), ("checked", _outcome(erratum))]
    told.append(("effect", erratum.effect))
    told.append(("severity", erratum.severity))
    body = facts_html([(name, text) for name, text in told if text])
    return element(
        "details", element("summary", heading), body, id=anchor("erratum", erratum.id), class_="erratum", tabindex=-1
    )


def _outcome(erratum: Erratum) -> str:
    if not erratum.holds:
        return "THE COMPUTATION DOES NOT COME OUT AS TOLD"
    return "the computation comes out as told" if erratum.computed else "no computation decides it"


def _status(erratum: Erratum) -> str:
    return "fails" if not erratum.holds else "proven" if erratum.status == "proven" else "likely"


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
    """A table, its cells tinted where their heading says so."""
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
    """The place of a plot; the script fills it."""
    name = anchor("plot", figure.id)
    caption = element(
        "figcaption",
        element("h3", figure.title, element("span", figure.where, class_="where") if figure.where else None, id=name),
        element("p", figure.note, class_="note") if figure.note else None,
    )
    place = element("div", class_="plot", data_plot=figure.id, role="group", aria_labelledby=name)
    return element("figure", caption, place, class_="block")


def _paragraph(text: str) -> Html:
    """Words as a paragraph; columns aligned with spaces as they stand."""
    return element("pre", text, tabindex=0) if "  " in text else element("p", text)


def section_html(section: Section) -> list[Html]:
    """What stands under the heading of a section."""
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
