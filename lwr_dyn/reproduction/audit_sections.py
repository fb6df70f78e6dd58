"""What audits show about a paper's tables, as sections of its page: lint, conventions, sensitivity to the reading."""

from collections.abc import Sequence
from typing import Any

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper, readings
from lwr_dyn.checks.conventions.evidence_file import packaged_evidence
from lwr_dyn.checks.conventions.joint_zero import zero_readings, zero_text
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.checks.conventions.ranking import rank_readings
from lwr_dyn.checks.conventions.ranking_text import ranking_text
from lwr_dyn.checks.sensitivity.analysis import sensitivity
from lwr_dyn.checks.sensitivity.result_tables import error_table, errors_text, gains_table, notes, survival
from lwr_dyn.checks.sensitivity.study_tasks import printed_task
from lwr_dyn.checks.tables.rules import lint, sheets_of_robot
from lwr_dyn.reproduction.paper_study import PaperStudy
from lwr_dyn.reproduction.report.content import Section

Audit = tuple[Section, Any]
"""A section of the page, and the same as JSON values."""


def lint_section(paper: str) -> Audit:
    """Faults that show without a model, in the data file and in the printed results."""
    findings = [finding for sheet in sheets_of_robot(paper) for finding in lint(sheet)]
    text = "\n".join(finding.line() for finding in findings) or "nothing found"
    return Section("lint", "Lint", text), [finding.record() for finding in findings]


def tensor_section(paper: str) -> Audit:
    """How the tables of inertia may be read when no convention is stated; the file's own errata are not used."""
    table = printed_table(open_paper(paper))
    return _conventions(ranking_text(rank_readings(table, packaged_evidence(paper, table))))


def zero_section(paper: str) -> Audit:
    """How zero and signs of the joints may be read when they are not stated."""
    return _conventions(zero_text(zero_readings(open_paper(paper))))


def _conventions(lines: Sequence[str]) -> Audit:
    return Section("resolver", "Conventions", "\n".join(lines)), lines


def sensitivity_section(paper: str) -> Audit:
    """The paper's task under all readings: the controller's model is one of them, the plant another."""
    task = printed_task(paper)
    result = sensitivity({name: arm_from_paper(open_paper(paper, name)) for name in readings(paper)}, task)
    names = list(result.study.labels.values())
    tables = (*(error_table(result, name) for name in names), gains_table(result), survival(result))
    text = "\n".join([f"{result.study.task.about}; {errors_text(result)}", *notes(result)])
    record = {
        "rms_mm": {name: result.tip_rms_mm(name) for name in names},
        "conclusions": {c.text: c.verdict() for c in result.conclusions},
    }
    return Section("spread", "Readings", text, tables), record


def audit_sections(study: PaperStudy, with_sensitivity: bool) -> tuple[list[Section], dict[str, Any]]:
    """All of these sections that the paper has, and their record."""
    paper = study.name
    audits = {"lint": lint_section(paper)}
    if study.study.conventions:
        audits["resolver"] = {"tensors": tensor_section, "zero": zero_section}[study.study.conventions](paper)
    if with_sensitivity:
        audits["spread"] = sensitivity_section(paper)
    return [section for section, _ in audits.values()], {name: record for name, (_, record) in audits.items()}
