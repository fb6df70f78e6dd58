"""A URDF judged by every rule: the findings with their severity, without those that the user ignores."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument, read_document
from lwr_dyn.checks.urdf.finding import SEVERITIES, FindingSeverity, UrdfFinding
from lwr_dyn.checks.urdf.rules import RULES, codes, severity_of
from lwr_dyn.checks.urdf.welded_links import has_mass
from lwr_dyn.checks.urdf.xml_tree import Place, XmlElement
from lwr_dyn.foundation.errors import UnknownNameError

ALL = "all"
"""In a comment of the file: every code."""


@dataclass(frozen=True, slots=True, eq=False)
class LintReport:
    """The judgement of one file."""

    file: str
    findings: tuple[UrdfFinding, ...]
    """Errors, warnings, notes; each in the order of the rules and of the file."""
    remarks: tuple[str, ...]
    """What could not be judged, and why."""
    links: int
    moved: int
    """How many of the links a joint moves."""
    ignored: int
    """How many findings the user's `ignore` left out."""

    def count(self, severity: FindingSeverity) -> int:
        """How many findings have this severity."""
        return sum(f.level == severity for f in self.findings)

    def holds(self, strict: bool = False) -> bool:
        """No error; with `strict`, no warning either."""
        return not (self.count("error") or (strict and self.count("warning")))


def lint_file(
    path: str | Path, ignore: Collection[str] = (), xacro_args: Mapping[str, str] | None = None
) -> LintReport:
    """Judge a URDF or xacro file.

    Parameters
    ----------
    path : path
    ignore : collection of str
        Codes to leave out.
    xacro_args : mapping, optional
        Arguments of a xacro file.

    Raises
    ------
    FileAccessError, MissingPackageError, UrdfError
        As `read_document`.
    UnknownNameError
        A code to ignore that no rule has.
    """
    return lint_document(read_document(path, xacro_args), ignore)


def lint_document(document: UrdfDocument, ignore: Collection[str] = ()) -> LintReport:
    """Judge a document; raises `UnknownNameError` as `lint_file`."""
    for code in ignore:
        if code not in codes():
            raise UnknownNameError("code of a rule", code, codes())
    found = _found(document)
    places = dict(_ignored_places(document.root))
    kept = [f for f in found if f.code not in ignore and not {f.code, ALL} & places.get(f.place, frozenset())]
    kept.sort(key=lambda f: SEVERITIES.index(f.level))
    return LintReport(
        document.file,
        tuple(kept),
        tuple(_remarks(document)),
        len(document.links),
        len(document.moved_links),
        len(found) - len(kept),
    )


def _found(document: UrdfDocument) -> list[UrdfFinding]:
    """The findings of all rules, each once, with code and severity."""
    found = {(f.code, f.place, f.subject, f.what): replace(f, severity="error") for f in document.faults}
    if document.root is None:
        return list(found.values())
    with np.errstate(all="ignore"):
        for code in RULES.names:
            for finding in RULES.load(code)(document):
                named = replace(finding, code=code, severity=_severity(finding, code, document))
                found.setdefault((code, finding.place, finding.subject, finding.what), named)
    return list(found.values())


def _remarks(document: UrdfDocument) -> Iterable[str]:
    """What could not be judged."""
    from lwr_dyn.checks.urdf.shape_rules import remarks  # loads SciPy, which `--explain` and tables do without

    asked = {code for _, ignored in _ignored_places(document.root) for code in ignored}
    for code in sorted(asked - {ALL, *codes()}):
        yield f"a comment asks to ignore {code!r}: no rule has this code"
    if document.links and not has_mass(document):
        yield "no link has mass: kinematics only, nothing about mass and inertia is judged"
    elif document.links:
        yield from remarks(document)


def _severity(finding: UrdfFinding, code: str, document: UrdfDocument) -> FindingSeverity:
    """That of the finding or of its rule; of a link fixed to a moved one a level lower, of one that rests a note."""
    severity = finding.severity or severity_of(code)
    if not finding.link or finding.link in document.driven:
        return severity
    if finding.link in document.moved and severity == "error":
        return "warning"
    return "note"


def _ignored_places(root: XmlElement | None) -> Iterable[tuple[Place, frozenset[str]]]:
    """Every place where a comment of the file asks to ignore codes."""
    waiting = [root] if root is not None else []
    while waiting:
        element = waiting.pop()
        if element.ignored:
            yield element.place, element.ignored
        waiting += element.children
