"""A report as text: groups of findings with their places, what could not be judged, a summary."""

from collections.abc import Iterator, Mapping, Sequence

from lwr_dyn.checks.arm.verdict import FileVerdict
from lwr_dyn.checks.urdf.finding import SEVERITIES, UrdfFinding
from lwr_dyn.checks.urdf.grouping import FindingGroup, grouped
from lwr_dyn.checks.urdf.lint import LintReport, lint_file

SHOWN = 5
"""Findings of a group that are printed without `--all`; of a group of notes one."""


def report_text(report: LintReport, everything: bool = False) -> str:
    """The findings of a file, grouped by cause, and what was not judged.

    Parameters
    ----------
    report : LintReport
    everything : bool
        All findings of each group.
    """
    lines = [line for group in grouped(report.findings) for line in _group(group, everything)]
    lines += [f"{report.file}: {remark}" for remark in report.remarks]
    return "\n".join([*lines, summary([report])])


def file_verdict(path: str, xacro_args: Mapping[str, str]) -> FileVerdict:
    """A file's report, as `lwr-dyn check` prints it before its own checks; raises as `lint_file`."""
    report = lint_file(path, xacro_args=xacro_args)
    return FileVerdict(report_text(report), [finding.record() for finding in report.findings], report.holds())


def _group(group: FindingGroup, everything: bool) -> Iterator[str]:
    yield f"{group.severity}: {group.cause}{_many(group.findings)} [{', '.join(group.codes)}]"
    shown = len(group.findings) if everything else SHOWN if group.severity != "note" else 1
    for finding in group.findings[:shown]:
        yield from _finding(finding, group.severity)
    if len(group.findings) > shown:
        yield f"  and {len(group.findings) - shown} more (--all)"
    if group.following:
        codes = ", ".join(dict.fromkeys(f.code for f in group.following))
        yield f"  {len(group.following)} more findings most likely follow from it: {codes}"
        for finding in group.following if everything else ():
            yield from _finding(finding, group.severity)


def _many(findings: Sequence[UrdfFinding]) -> str:
    """How many places, and how many links or joints where these are fewer."""
    subjects = {f.subject for f in findings}
    kinds = {subject.partition(" ")[0] for subject in subjects}
    kind = f"{kinds.pop()}s" if kinds in ({"link"}, {"joint"}) else "links or joints"
    if len(findings) == 1:
        return ""
    if len(subjects) == len(findings):
        return f" ({len(subjects)} {kind})"
    return f" ({len(findings)} places, {len(subjects)} {kind})" if len(subjects) > 1 else f" ({len(findings)} places)"


def _finding(finding: UrdfFinding, around: str) -> Iterator[str]:
    level = "" if finding.level == around else f"{finding.level}: "
    sure = "" if finding.sure == "certain" else f" ({finding.sure})"
    subject = f"{finding.subject}: " if finding.subject else ""
    yield f"  {finding.place}: {level}{subject}{finding.what}{sure}"
    if finding.why:
        yield f"      {finding.why}"
    if finding.instead:
        yield f"      instead: {finding.instead}"


def summary(reports: Sequence[LintReport]) -> str:
    """Counts over some files."""
    counts = [f"{n} {name}{'' if n == 1 else 's'}" for name in SEVERITIES if (n := sum(r.count(name) for r in reports))]
    ignored = sum(report.ignored for report in reports)
    links, moved = sum(report.links for report in reports), sum(report.moved for report in reports)
    where = reports[0].file if len(reports) == 1 else f"{len(reports)} files"
    found = ", ".join(counts) or "no findings"
    judged = f"{links} link{'' if links == 1 else 's'}, {moved} of them moved: " if links else ""
    return f"{where}: {judged}{found}" + (f"; {ignored} ignored" if ignored else "")
