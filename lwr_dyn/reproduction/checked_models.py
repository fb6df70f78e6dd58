"""What every report begins with: the models of a robot under each of its readings, and all checks on them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lwr_dyn.checks.run_checks import check_arm
from lwr_dyn.checks.verdict import CheckReport
from lwr_dyn.files import write_file, write_folder
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import open_readings
from lwr_dyn.urdf.model_files import model_files


def models_and_checks(place: Path, robot: str) -> list[CheckReport]:
    """Write `models/` and `checks.txt` into a folder; raises `FileAccessError`."""
    reports, lines = [], []
    for paper in open_readings(robot):
        arm = arm_from_paper(paper)
        write_folder(place / "models", model_files(arm))
        report = check_arm(arm, paper)
        lines.append(report.table().text())
        reports.append(report)
    write_file(place / "checks.txt", "\n\n".join(lines) + "\n")
    return reports


def check_line(report: CheckReport) -> str:
    """A report in one line."""
    failed = [v.name for v in report.verdicts if not v.holds]
    kept = len(report.verdicts) - len(failed)
    faults = f", FAIL: {', '.join(failed)}" if failed else ""
    return f"check {report.robot}, reading {report.reading}: {kept} hold{faults}"


def check_record(reports: Sequence[CheckReport]) -> dict[str, Any]:
    """Reports as JSON values, by reading."""
    return {r.reading: {v.name: {"value": v.value, "holds": v.holds} for v in r.verdicts} for r in reports}
