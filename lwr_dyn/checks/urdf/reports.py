"""What `lwr-dyn lint` makes of URDFs: the files of folders, findings grouped by cause, and their outputs.

One line says what one slip did to many links, the largest group first. Outputs are text with places, what could not be
judged and a summary; SARIF 2.1.0 for code scanning; annotations of GitHub's workflow log.
"""

import hashlib
import os
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import click

from lwr_dyn.checks.urdf.document import SEVERITIES, FindingSeverity, UrdfFinding
from lwr_dyn.checks.urdf.lint import LintReport, about, explanation, lint_file, severity_of
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file
from lwr_dyn.foundation.tables import json_text, log_line
from lwr_dyn.foundation.version import VERSION

FOLLOWING = {
    "masses in g": ("density", "effort-weight", "inertia-spread", "inertia-bound", "inertia-slip"),
    "origins in mm": ("bodies-apart", "joint-off-bodies", "effort-weight"),
    "centres of mass in mm": ("centre-outside", "effort-weight"),
    "rpy in degrees": ("bodies-apart", "joint-off-bodies", "effort-weight"),
}
"""Causes, and rules whose findings follow from them: they stand in the group of the cause."""

_FURTHER = ("effort-weight", "bodies-apart", "joint-off-bodies")
"""Rules that also find at other links and joints what one link did; the others must be at the same link."""


@dataclass(frozen=True, slots=True)
class FindingGroup:
    """Findings of one cause."""

    cause: str
    findings: tuple[UrdfFinding, ...]
    following: tuple[UrdfFinding, ...] = ()
    """Findings that most likely follow from these."""

    @property
    def severity(self) -> FindingSeverity:
        """The worst severity."""
        return min((f.level for f in self.findings), key=SEVERITIES.index)

    @property
    def codes(self) -> tuple[str, ...]:
        """The codes of its own findings."""
        return tuple(dict.fromkeys(f.code for f in self.findings))


def grouped(findings: Sequence[UrdfFinding]) -> tuple[FindingGroup, ...]:
    """The groups: errors first, then warnings, then notes; of these the largest first."""
    by_cause: dict[str, list[UrdfFinding]] = defaultdict(list)
    for finding in findings:
        by_cause[finding.cause or about(finding.code)].append(finding)
    causes = {cause: {f.subject for f in own} for cause, own in by_cause.items() if cause in FOLLOWING}
    follows = [(f, cause) for f in findings if (cause := _followed(f, causes))]
    absorbed = {id(f) for f, _ in follows}
    groups = []
    for cause, own in by_cause.items():
        stay = tuple(f for f in own if id(f) not in absorbed)
        if stay:
            groups.append(FindingGroup(cause, stay, tuple(f for f, into in follows if into == cause)))
    return tuple(sorted(groups, key=lambda g: (SEVERITIES.index(g.severity), -len(g.findings))))


def _followed(finding: UrdfFinding, causes: Mapping[str, Collection[str]]) -> str:
    """The cause that a finding follows from; empty where there is none."""
    for cause, subjects in causes.items():
        near = finding.code in _FURTHER or finding.subject in subjects
        if finding.code in FOLLOWING[cause] and finding.cause not in causes and near:
            return cause
    return ""


SHOWN = 5
"""Findings of a group that are printed without `--all`; of a group of notes one."""


def report_text(report: LintReport, everything: bool = False) -> str:
    """The findings of a file, grouped by cause (with `everything` all of each group), and what was not judged."""
    lines = [line for group in grouped(report.findings) for line in _group(group, everything)]
    lines += [f"{report.file}: {remark}" for remark in report.remarks]
    return "\n".join(map(log_line, [*lines, summary([report])]))


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
    judged = f"{links} link{'' if links == 1 else 's'}, {moved} of them moving: " if links else ""
    return f"{where}: {judged}{found}" + (f"; {ignored} ignored" if ignored else "")


SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
MOST = 5000
"""Results that code scanning keeps of a run: the worst come first."""


def sarif_record(reports: Sequence[LintReport]) -> dict[str, Any]:
    """One run over some files.

    Lines and columns count from 1, columns in code points; file names are relative to the working directory. The
    fingerprint of a result is that of its line's text, so it lasts when lines above it change.
    """
    findings = _worst_first(reports)[:MOST]
    codes = list(dict.fromkeys(f.code for f in findings))
    driver = {"name": "lwr_dyn", "version": VERSION, "semanticVersion": VERSION, "rules": [*map(_rule, codes)]}
    marked = zip(findings, _fingerprints(findings), strict=True)
    results = [_result(f, codes.index(f.code), fingerprint) for f, fingerprint in marked]
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _worst_first(reports: Iterable[LintReport]) -> list[UrdfFinding]:
    return sorted((f for report in reports for f in report.findings), key=lambda f: SEVERITIES.index(f.level))


def _rule(code: str) -> dict[str, Any]:
    texts = {"shortDescription": {"text": about(code)}, "fullDescription": {"text": about(code)}}
    level = {"level": severity_of(code)}
    return {"id": code, **texts, "help": {"text": explanation(code)}, "defaultConfiguration": level}


def _result(finding: UrdfFinding, index: int, fingerprint: str) -> dict[str, Any]:
    place = finding.place
    region = {"startLine": place.line, "startColumn": place.column}
    return {
        "ruleId": finding.code,
        "ruleIndex": index,
        "level": finding.level,
        "message": {"text": finding.message},
        "locations": [{"physicalLocation": {"artifactLocation": {"uri": uri_of(place.file)}, "region": region}}],
        "partialFingerprints": {"primaryLocationLineHash": fingerprint},
    }


def uri_of(file: str) -> str:
    """A file as a URI: relative to the working directory, absolute where it lies outside.

    >>> uri_of("robots/my arm.urdf")
    'robots/my%20arm.urdf'
    """
    relative = os.path.relpath(file)
    return Path(file).resolve().as_uri() if relative.startswith("..") else quote(Path(relative).as_posix())


def _fingerprints(findings: Iterable[UrdfFinding]) -> Iterator[str]:
    """Numbers that name each finding by code, subject and the text of its line, and count equal ones."""
    files: dict[str, list[bytes]] = {}
    given: Counter[str] = Counter()
    for finding in findings:
        place = finding.place
        if place.file not in files:
            try:
                files[place.file] = Path(place.file).read_bytes().split(b"\n")
            except (OSError, ValueError):
                files[place.file] = []
        text = b"".join(files[place.file][place.line - 1 : place.line]).strip()
        digest = hashlib.sha256(f"{finding.code}\0{finding.subject}\0".encode() + text).hexdigest()[:16]
        given[digest] += 1
        yield f"{digest}:{given[digest]}"


def annotations(reports: Iterable[LintReport]) -> Iterable[str]:
    """One line for each finding, which GitHub shows beside the file's line."""
    kinds = {"error": "error", "warning": "warning", "note": "notice"}
    for finding in _worst_first(reports):
        place = finding.place
        where = {"file": os.path.relpath(place.file), "line": place.line, "col": place.column, "title": finding.code}
        properties = ",".join(f"{name}={_escaped(str(value), ':,')}" for name, value in where.items())
        yield f"::{kinds[finding.level]} {properties}::{_escaped(finding.message)}"


def _escaped(text: str, more: str = "") -> str:
    for letter in "%\r\n" + more:
        text = text.replace(letter, f"%{ord(letter):02X}")
    return text


ENDINGS = (".urdf", ".xacro")
IN_FOLDERS = ("*.urdf", "*.urdf.xacro")
"""Names that are looked for in folders; other `.xacro` files are macros without a robot."""


def is_urdf(name: str) -> bool:
    """Whether a name on the command line is a URDF, a xacro or a folder of these."""
    return ends_in(name, *ENDINGS) or ("\0" not in name and Path(name).is_dir())


def urdf_files(names: Iterable[str]) -> Iterator[str]:
    """The files that are meant: of a folder, all below it, in order; raises `OptionError` for one without a URDF."""
    for name in names:
        if not Path(name).is_dir():
            yield name
            continue
        found = sorted(str(path) for pattern in IN_FOLDERS for path in Path(name).rglob(pattern) if path.is_file())
        if not found:
            raise OptionError(name, "no .urdf or .urdf.xacro file below it", "a folder with some")
        yield from found


def judge_all(
    names: Sequence[str],
    ignore: Collection[str],
    sarif: str | None,
    say: Callable[[str], None],
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
    require_meshes: bool = False,
) -> tuple[LintReport, ...]:
    """The reports of all files; writes them as SARIF. Raises as `lint_file`, `urdf_files` and `write_file`.

    With `require_meshes` a mesh that is not there, or cannot be read, is an error. A xacro in a folder is passed over,
    with one line, where xacro is not installed; one that is trusted has its name typed, so a folder with `trust_xacro`
    is an `OptionError`.
    """
    if trust_xacro and (folder := next((name for name in names if Path(name).is_dir()), None)):
        raise OptionError("--trust-xacro", f"given for the folder {folder}", "files by name: a folder is never trusted")
    if sarif is not None:
        check_writable(sarif)
    reports = []
    for file in dict.fromkeys(urdf_files(names)):
        try:
            report = lint_file(file, ignore, xacro_args, trust_xacro)
            reports.append(with_required_meshes(report) if require_meshes else report)
        except MissingPackageError as fault:
            if file in names:
                raise
            say(log_line(f"{file} passed over: {fault}"))
    if sarif is not None:
        write_file(sarif, json_text(sarif_record(reports)) + "\n")
    return tuple(reports)


MESHES = ("mesh-missing", "mesh-package", "mesh-unreadable")
"""Rules of meshes that are not there or cannot be read: links drawn with them are judged without their shapes."""


def with_required_meshes(report: LintReport) -> LintReport:
    """A report in which each finding about a mesh that was not judged is an error."""
    findings = [replace(f, severity="error") if f.code in MESHES else f for f in report.findings]
    return replace(report, findings=tuple(sorted(findings, key=lambda f: SEVERITIES.index(f.level))))


def print_reports(reports: Sequence[LintReport], everything: bool, github: bool) -> None:
    """The reports as text, or as annotations of GitHub's workflow log."""
    if github:
        for line in annotations(reports):
            click.echo(line)
    else:
        for report in reports:
            click.echo(report_text(report, everything))
    if github or len(reports) > 1:
        click.echo(log_line(summary(reports)))
