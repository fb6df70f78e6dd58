"""Errata, checks, sections and files of a report as HTML that is readable without scripts."""

from collections.abc import Sequence

from lwr_dyn.foundation.tables import Table
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.reproduction.ledger import LedgerEntry
from lwr_dyn.reproduction.report.content import Check, Fact, FileFact, Section
from lwr_dyn.reproduction.report.figure_html import figure_html
from lwr_dyn.reproduction.report.markup import Html, anchor, element, grid, joined


def facts_html(facts: Sequence[Fact]) -> Html:
    """Names and their texts."""
    pairs = [item for name, text in facts for item in (element("dt", name), element("dd", text))]
    return element("dl", pairs, class_="facts-list")


def folded(title: str, count: str, *body: Html | None, fails: bool = False, name: str = "") -> Html:
    """A part that is folded away under its title; what fails stands open."""
    outcome = element("span", count, class_="count alarm" if fails else "count")
    summary = element("summary", element("h3", title), outcome)
    return element("details", summary, body, class_="box evidence", open=fails, id=name or None)


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
            element("span", "right: ", class_="hidden-word"),
            element("ins", e.read_as),
            class_="change",
        ),
        element("span", e.status if entry.holds else f"{e.status}, FAILS", class_=f"status {_status(entry)}"),
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


def checks_html(title: str, checks: Sequence[Check]) -> Html:
    """Values against what is allowed, folded while all hold."""
    rows = [
        (
            joined([check.name, element("small", check.note) if check.note else None]),
            element("td", check.value, class_="figure"),
            element("td", check.allowed, class_="figure"),
            _outcome_cell(check),
        )
        for check in checks
    ]
    failing = [check for check in checks if not check.holds]
    wrong = [check for check in failing if not check.is_expected]
    words = [_holding(len(checks)) if not failing else f"{len(checks) - len(failing)} hold"]
    words += [f"{len(failing) - len(wrong)} fail as expected"] if len(failing) > len(wrong) else []
    words += [f"{len(wrong)} FAIL"] if wrong else []
    table = grid(title, ("check", "value", "allowed", "outcome"), rows)
    return folded(title, ", ".join(words), table, fails=bool(wrong))


def _holding(checks: int) -> str:
    return f"all {checks} hold" if checks > 1 else "it holds"


def _outcome_cell(check: Check) -> Html:
    if check.holds:
        return element("td", "holds")
    return element("td", "fails as expected") if check.is_expected else element("td", "FAILS", class_="alarm")


def table_html(table: Table, name: str = "") -> Html:
    """A table, its cells tinted as their heading states."""
    rows = [
        [text if shade is None else _tinted(text, shade) for text, shade in zip(cells, shades, strict=True)]
        for cells, shades in zip(table.cells, table.shades, strict=True)
    ]
    return element(
        "div",
        element("h4", table.title) if table.title else None,
        element("p", table.note, class_="note") if table.note else None,
        grid(table.title or name, (h.title for h in table.columns), rows),
    )


def _tinted(text: str, shade: float) -> Html:
    return element("td", text, class_="shaded", style=f"--shade: {min(max(shade, 0.0), 1.0):.3f}")


def _paragraph(text: str) -> Html:
    """Text as a paragraph; columns aligned with spaces are kept."""
    return (
        element("pre", text, tabindex=0, role="region", aria_label=text.split("\n")[0][:60])
        if "  " in text
        else element("p", text)
    )


def section_html(section: Section, runs: Sequence[ReplayedRun]) -> Html:
    """A section, folded away."""
    text = [_paragraph(part) for part in section.text.split("\n\n") if part.strip()]
    lines = len(section.text.splitlines()) + sum(len(table.rows) for table in section.tables)
    count = f"{lines} line{'s' if lines != 1 else ''}" if lines else ""
    return folded(
        section.title,
        count,
        element("div", text, class_="prose") if text else None,
        *(table_html(table, section.title) for table in section.tables),
        *(figure_html(figure, runs) for figure in section.figures),
        name=anchor("section", section.id),
    )


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
    count = f"{len(files)}, {sum(file.size for file in files) / 1e6:.1f} MB"
    return folded("Files beside this page", count, grid("files", ("file", "what", "bytes", "SHA-256"), rows))
