"""A file of numbers, looked at by every rule."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from lwr_dyn.audit.lint.copies import copies
from lwr_dyn.audit.lint.csv_sheet import sheet_of_csv
from lwr_dyn.audit.lint.extremes import extremes
from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.formulas import formulas
from lwr_dyn.audit.lint.proportions import proportions
from lwr_dyn.audit.lint.repeats import repeats
from lwr_dyn.audit.lint.sheet import Sheet
from lwr_dyn.audit.lint.shifts import shifts
from lwr_dyn.audit.lint.statements import statements
from lwr_dyn.audit.lint.symmetry import symmetry
from lwr_dyn.audit.lint.toml_sheet import sheet_of_toml
from lwr_dyn.audit.lint.totals import totals
from lwr_dyn.audit.lint.unit_sense import unit_sense
from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import read_text
from lwr_dyn.papers.catalog import data_files, open_paper

Rule = Callable[[Sheet], Iterator[Finding]]
RULES: tuple[Rule, ...] = (
    extremes, proportions, formulas, statements, totals, shifts, copies, repeats, symmetry, unit_sense,
)  # fmt: skip
"""In the order in which findings are told; a slip that an earlier rule explained is not told again."""
LARGEST = 20_000_000
"""Bytes of a file."""
FORMATS = "a .toml or .csv file of numbers"


def lint(sheet: Sheet) -> tuple[Finding, ...]:
    """What all rules find in a sheet; raises `TableError` for a declaration that cannot be read.

    >>> from lwr_dyn.audit.lint.toml_sheet import sheet_of_toml
    >>> [f.sentence for f in lint(sheet_of_toml('why = "1/2 x 0.0106 x 0.05^2 = 1.325e-7"', "x.toml"))]
    ['1/2 x 0.0106 x 0.05^2 = 1.325e-05, printed as 1.325e-7: off by 1e2']
    """
    found: list[Finding] = []
    for rule in RULES:
        for finding in rule(sheet):
            same = [f for f in found if f.rule == finding.rule and set(f.cells) == set(finding.cells)]
            if not same:
                found.append(replace(finding, known=_known(sheet, finding)))
    return tuple(found)


def _known(sheet: Sheet, finding: Finding) -> tuple[str, ...]:
    ids = [label for place, label in sheet.errata.items() if any(c.startswith(place) for c in finding.cells)]
    return tuple(dict.fromkeys(ids))


def lint_file(path: str | Path, joints: str = "") -> tuple[Finding, ...]:
    """What all rules find in a .toml or .csv file.

    Parameters
    ----------
    path : path
    joints : str
        "revolute" or "prismatic", for files that do not say what their joints are.

    Raises
    ------
    FileAccessError
        The file cannot be read, is too large, or is neither .toml nor .csv.
    TableError
        It can be read, but not as tables of numbers.
    """
    return lint(sheet_of_file(path, joints))


def sheet_of_file(path: str | Path, joints: str = "") -> Sheet:
    """A file as a sheet; raises as `lint_file`."""
    file = Path(path)
    if file.suffix.lower() not in (".toml", ".csv"):
        raise FileAccessError(str(path), "neither .toml nor .csv", FORMATS)
    text = read_text(path, FORMATS, "utf-8-sig", LARGEST)
    if file.suffix.lower() == ".csv":
        return sheet_of_csv(text, str(path), file.stem)
    return sheet_of_toml(text, str(path), joints)


def sheets_of_robot(robot: str) -> tuple[Sheet, ...]:
    """All files that come with the package about a robot, a sheet each; raises `UnknownNameError`."""
    files = data_files(robot)
    kinds = {kind.value for kind in open_paper(robot).kinds}
    joints = kinds.pop() if len(kinds) == 1 else ""
    return tuple(sheet_of_toml(text, name, joints) for name, text in files.items())
