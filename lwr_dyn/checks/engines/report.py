"""The tables of a survey: how far each engine is from ours, what it makes of each feature, what restores a loss."""

from collections.abc import Sequence
from typing import Any

from lwr_dyn.checks.engines.losses import NO_DYNAMICS
from lwr_dyn.checks.engines.reference import STATES
from lwr_dyn.checks.engines.survey import EngineReport, ModelReport, Restored
from lwr_dyn.foundation.tables import Heading, Table


def agreement_table(report: ModelReport) -> Table:
    """Largest differences from our own dynamics of the file."""
    heads = [Heading("engine"), Heading("mass", "kg", ".6g")]
    heads += [Heading(x, "relative", ".1e") for x in ("B", "C dq", "g", "torque")]
    heads += [Heading("torque", "N m", ".2g", key="torque_nm"), Heading("flange", "m", ".1e")]
    rows = []
    for engine in report.engines:
        found = engine.agreement
        if found is not None:
            relative = [found.relative.get(x) for x in ("B", "C dq", "g", "torque")]
            rows.append((engine.engine, found.mass, *relative, found.absolute.get("torque"), found.absolute["flange"]))
    title = f"{report.file}: largest difference from ours over {STATES} random states, as each engine loads it"
    note = "torque: B ddq + C dq + g with rotors and friction, as the engine's own motion needs it"
    return Table(title, heads, rows, note)


def loss_table(report: ModelReport) -> Table:
    """What is not as the file says, with the torque that is then wrong and what restores it."""
    rows = []
    for engine in report.engines:
        for row in (x for x in engine.losses if x.loss.is_loss):
            loss = row.loss
            cells = (engine.engine, loss.feature, loss.verdict, loss.torque, loss.relative)
            rows.append((*cells, row.by or "nothing that was tried", loss.detail))
    heads = [Heading("engine"), Heading("feature"), Heading("verdict"), Heading("torque", "N m", ".2g")]
    heads += [Heading("share", "", ".1e"), Heading("restored by", key="restored_by"), Heading("detail")]
    return Table("What is lost, each by taking it out of the file and loading again", heads, rows)


def kept_lines(report: ModelReport) -> list[str]:
    """Engine by engine, what is as the file says."""
    out = []
    for engine in report.engines:
        if engine.losses:
            words: dict[str, list[str]] = {}
            for row in (x for x in engine.losses if not x.loss.is_loss and x.loss.verdict != NO_DYNAMICS):
                detail = f" ({row.loss.detail})" if row.loss.detail else ""
                words.setdefault(row.loss.verdict, []).append(row.loss.feature + detail)
            out.append(f"{engine.engine}: " + "; ".join(f"{k} {', '.join(v)}" for k, v in words.items()))
    return out


def notes(report: ModelReport) -> list[str]:
    """Engines that are missing, refuse the file, or take it only in part."""
    lines = [f"{engine.engine}: {engine.note}" for engine in report.engines if engine.note]
    return [*lines, f"all formats: {report.unwritten}"] if report.unwritten else lines


def text(report: ModelReport) -> str:
    """Everything on one model."""
    parts = [agreement_table(report).text()] if any(x.agreement for x in report.engines) else []
    parts += [loss_table(report).text()] if loss_table(report).rows else []
    parts += ["\n".join(lines) for lines in (kept_lines(report), notes(report)) if lines]
    return "\n\n".join(parts)


def record(report: ModelReport) -> dict[str, Any]:
    """The same for programs."""
    return {
        "file": report.file,
        "unwritten": report.unwritten,
        "engines": [_engine_record(engine) for engine in report.engines],
    }


def _engine_record(engine: EngineReport) -> dict[str, Any]:
    found = engine.agreement
    out: dict[str, Any] = {"engine": engine.engine, "note": engine.note}
    if found is not None:
        out |= {"mass": found.mass, "absolute": found.absolute, "relative": found.relative}
    names = ("feature", "verdict", "torque", "relative", "detail")
    rows = [{x: getattr(row.loss, x) for x in names} | {"restored_by": row.by} for row in engine.losses]
    return out | {"features": rows}


def matrix(reports: Sequence[ModelReport]) -> Table:
    """Models and their features by rows, engines by columns."""
    engines = list(dict.fromkeys(engine.engine for report in reports for engine in report.engines))
    rows = []
    for report in reports:
        by_engine = {engine.engine: {row.loss.feature: row for row in engine.losses} for engine in report.engines}
        for feature in dict.fromkeys(name for found in by_engine.values() for name in found):
            cells = [_cell(by_engine.get(engine, {}).get(feature)) for engine in engines]
            rows.append((report.file, feature, *cells))
    return Table("What each engine makes of each file", [Heading("file"), Heading("feature"), *engines], rows)


def _cell(row: Restored | None) -> str:
    if row is None:
        return "-"
    loss = row.loss
    size = f", {loss.torque:.2g} N m" if loss.torque else ""
    return f"{loss.verdict}{size}" + (f"; {row.by}" if row.by else "")


def markdown(table: Table) -> str:
    """A table as Markdown."""
    lines = [tuple(head.title for head in table.columns), ("---",) * len(table.columns), *table.cells]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
