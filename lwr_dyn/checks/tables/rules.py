"""A file of numbers, examined by every rule."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from lwr_dyn.arms.papers.catalog import data_files, open_paper
from lwr_dyn.checks.tables.consistency import repeats, symmetry, totals
from lwr_dyn.checks.tables.csv_sheet import sheet_of_csv
from lwr_dyn.checks.tables.formulas import formulas
from lwr_dyn.checks.tables.min_mean_max import min_mean_max
from lwr_dyn.checks.tables.proportions import proportions
from lwr_dyn.checks.tables.repeated_digits import repeated_digits
from lwr_dyn.checks.tables.sentences import sentences
from lwr_dyn.checks.tables.sheet import Finding, Sheet
from lwr_dyn.checks.tables.shifts import shifts
from lwr_dyn.checks.tables.toml_sheet import sheet_of_toml
from lwr_dyn.checks.tables.unit_sense import unit_sense
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import read_text

Rule = Callable[[Sheet], Iterator[Finding]]
RULES: tuple[Rule, ...] = (
    min_mean_max, proportions, formulas, sentences, totals, shifts, repeated_digits, repeats, symmetry, unit_sense,
)  # fmt: skip
"""In the order of their findings; a fault that an earlier rule explains is not reported again."""
LARGEST = 20_000_000
"""Bytes of a file."""
FORMATS = "a .toml or .csv file of numbers"


def lint(sheet: Sheet) -> tuple[Finding, ...]:
    """The findings of all rules; raises `TableError` for a declaration that cannot be read.

    >>> from lwr_dyn.checks.tables.toml_sheet import sheet_of_toml
    >>> [f.sentence for f in lint(sheet_of_toml('why = "1/2 x 0.0106 x 0.05^2 = 1.325e-7"', "x.toml"))]
    ['1/2 x 0.0106 x 0.05^2 = 1.325e-05, printed as 1.325e-7: off by 1e2']
    """
    findings: dict[tuple[str, frozenset[str]], Finding] = {}
    for finding in (finding for rule in RULES for finding in rule(sheet)):
        ids = [label for place, label in sheet.errata.items() if any(c.startswith(place) for c in finding.cells)]
        known = tuple(dict.fromkeys(ids))
        findings.setdefault((finding.rule, frozenset(finding.cells)), replace(finding, file=sheet.file, known=known))
    return tuple(findings.values())


def lint_file(path: str | Path, joints: str = "") -> tuple[Finding, ...]:
    """The findings of all rules in a .toml or .csv file.

    Parameters
    ----------
    path : path
    joints : str
        "revolute" or "prismatic", for files that do not state the kind of their joints.

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
