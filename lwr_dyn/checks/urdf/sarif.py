"""Reports as SARIF 2.1.0, for code scanning, and as annotations of GitHub's workflow log."""

import hashlib
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from lwr_dyn.checks.urdf.finding import SEVERITIES, UrdfFinding
from lwr_dyn.checks.urdf.lint import LintReport
from lwr_dyn.checks.urdf.rules import READING, RULES, explanation, severity_of
from lwr_dyn.foundation.version import VERSION

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
    lines = _Lines()
    driver = {"name": "lwr_dyn", "version": VERSION, "semanticVersion": VERSION, "rules": [_rule(c) for c in codes]}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(f, codes.index(f.code), lines) for f in findings],
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _worst_first(reports: Iterable[LintReport]) -> list[UrdfFinding]:
    return sorted((f for report in reports for f in report.findings), key=lambda f: SEVERITIES.index(f.level))


def _rule(code: str) -> dict[str, Any]:
    about = READING[code] if code in READING else RULES[code].about
    return {
        "id": code,
        "shortDescription": {"text": about},
        "fullDescription": {"text": about},
        "help": {"text": explanation(code)},
        "defaultConfiguration": {"level": severity_of(code)},
    }


def _result(finding: UrdfFinding, index: int, lines: "_Lines") -> dict[str, Any]:
    place = finding.place
    region = {"startLine": place.line, "startColumn": place.column}
    return {
        "ruleId": finding.code,
        "ruleIndex": index,
        "level": finding.level,
        "message": {"text": finding.message},
        "locations": [{"physicalLocation": {"artifactLocation": {"uri": uri_of(place.file)}, "region": region}}],
        "partialFingerprints": {"primaryLocationLineHash": lines.fingerprint(finding)},
    }


def uri_of(file: str) -> str:
    """A file as a URI: relative to the working directory, absolute where it lies outside.

    >>> uri_of("robots/my arm.urdf")
    'robots/my%20arm.urdf'
    """
    relative = os.path.relpath(file)
    return Path(file).resolve().as_uri() if relative.startswith("..") else quote(Path(relative).as_posix())


class _Lines:
    """The lines of the files with findings, and how often each fingerprint was given."""

    def __init__(self) -> None:
        self._files: dict[str, list[bytes]] = {}
        self._given: Counter[str] = Counter()

    def fingerprint(self, finding: UrdfFinding) -> str:
        """A number that names a finding by code, subject and the text of its line, and counts equal ones."""
        text = self._line(finding.place.file, finding.place.line).strip()
        words = "\0".join((finding.code, finding.subject)).encode()
        digest = hashlib.sha256(words + b"\0" + text).hexdigest()[:16]
        self._given[digest] += 1
        return f"{digest}:{self._given[digest]}"

    def _line(self, file: str, line: int) -> bytes:
        if file not in self._files:
            try:
                self._files[file] = Path(file).read_bytes().split(b"\n")
            except (OSError, ValueError):
                self._files[file] = []
        lines = self._files[file]
        return lines[line - 1] if line <= len(lines) else b""


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
