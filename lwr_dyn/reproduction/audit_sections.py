"""What other rooms find about a paper's tables, as parts of its report: lint, the readings that fit, their spread."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from typing import Any

import numpy as np

from lwr_dyn.audit.conventions.evidence import Evidence
from lwr_dyn.audit.conventions.evidence_file import room_evidence
from lwr_dyn.audit.conventions.printed import printed_table
from lwr_dyn.audit.conventions.resolve import resolve
from lwr_dyn.audit.conventions.statements import statements
from lwr_dyn.audit.conventions.zero import resolve_zero, zero_statements
from lwr_dyn.audit.lint.examine import lint
from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.toml_sheet import sheet_of_toml
from lwr_dyn.audit.sensitivity.analysis import Sensitivity, sensitivity
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import open_paper, readings
from lwr_dyn.reproduction.report.content import Section
from lwr_dyn.reproduction.results import results_text
from lwr_dyn.reproduction.rooms import Room
from lwr_dyn.tables import Heading, Table

RESOLVED = {"lwr4plus": "tensors", "wam7": "tensors", "kr30ha": "zero"}
"""Papers whose tables leave conventions open: of the inertia tensors, or of the joints' zero and signs."""
SPREAD = ("lwr4plus", "wam7")
"""Papers whose readings are readings of one arm with masses in print."""
Told = tuple[Section, Any]
"""A part of the page, and the same as JSON values."""


def lint_section(here: Room) -> Told:
    """Slips that show without a model, in the data file and in the printed results."""
    data = resources.files("lwr_dyn.papers").joinpath(here.file).read_text(encoding="utf-8")
    sheets = ((data, here.file), (results_text(here.paper), f"{here.paper}/results.toml"))
    found: list[Finding] = [f for text, file in sheets for f in lint(sheet_of_toml(text, file, "revolute"))]
    told = "\n".join(f.line() for f in found) or "nothing found"
    return Section("lint", "Lint", told), [f.record() for f in found]


def resolver_section(paper: str) -> Told | None:
    """How the tables may be read when nobody states their conventions, the file's own errata not looked at."""
    kind = RESOLVED.get(paper)
    if kind is None:
        return None
    if kind == "zero":
        lines = zero_statements(resolve_zero(paper))
    else:
        table = printed_table(paper)
        lines = statements(resolve(table, room_evidence(paper, table) or Evidence()))
    return Section("resolver", "Conventions", "\n".join(lines)), lines


def spread_section(paper: str) -> Told | None:
    """The paper's task under all readings: the controller believes in one, the plant is another."""
    if paper not in SPREAD:
        return None
    found = sensitivity({name: arm_from_paper(open_paper(paper, name)) for name in readings(paper)})
    laws = [choice.name for choice in found.study.task.controllers]
    tables = [*(_matrix(found, law) for law in laws), _inertias(found), _survivors(found)]
    text = f"{found.study.task.about}; {len(found.runs)} runs at {found.rate:g} Hz or more"
    record = {
        "rms_mm": {law: found.tip_rms_mm(law) for law in laws},
        "conclusions": {c.text: c.verdict() for c in found.conclusions},
    }
    return Section("spread", "Readings", text, tuple(tables)), record


def _matrix(found: Sensitivity, law: str) -> Table:
    tips, worst = found.tip_rms_mm(law), found.worst_mrad(law)
    least, largest = float(np.nanmin(tips)), float(np.nanmax(tips)) or 1.0

    def shade(pair: tuple[float, float]) -> float:
        return float(np.nan_to_num((pair[0] - least) / largest))

    heads = [
        Heading(f"on {name}", format=lambda pair: "{:.3g} ({:.3g})".format(*pair), shade=shade) for name in found.names
    ]
    rows = [(name, *zip(tips[i], worst[i], strict=True)) for i, name in enumerate(found.names)]
    title = f"{law}: RMS error of the tip [mm] (largest error of a joint [mrad])"
    return Table(title, (f"{law} believes in", *heads), rows, "rows: the controller believes; columns: what is moved")


def _inertias(found: Sensitivity) -> Table:
    heads = [Heading("reading"), *(Heading(joint, format=".4g") for joint in found.joints)]
    rows = [(name, *found.statics[name].b) for name in found.names]
    return Table("Largest inertia b = max B_ii [kg m^2]", heads, rows)


def _survivors(found: Sensitivity) -> Table:
    rows = [(c.text, c.verdict()) for c in found.conclusions]
    return Table("What survives", ("conclusion", "under which readings"), rows)


def sections_of(here: Room, with_spread: bool) -> tuple[Sequence[Section], dict[str, Any]]:
    """All of these parts that the paper has, and their record."""
    told = {"lint": lint_section(here), "resolver": resolver_section(here.paper)}
    if with_spread:
        told["spread"] = spread_section(here.paper)
    kept = {name: part for name, part in told.items() if part is not None}
    return [section for section, _ in kept.values()], {name: record for name, (_, record) in kept.items()}
