"""A data file of a robot held against what `lwr-dyn check` says of it: what that refuses or fails is a finding.

The rules of this package look at one table after the other and need no model; a tensor that no body has, or a mass
below 0, shows only once the file is read as an arm. So the same checks are run, in the default reading.
"""

import tomllib
from collections.abc import Iterator
from math import isfinite
from pathlib import Path

from lwr_dyn.checks.tables.sheet import Finding
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.foundation.files import ends_in

ROBOT = ("dh", "joints")
"""Tables that a robot's data file has, and no other."""


def holds_a_robot(text: str, file: str) -> bool:
    """Whether a TOML text is a robot's: it has a DH table or joints by kind, or its name says so.

    >>> holds_a_robot("[dh]\\na = 1", "x.toml"), holds_a_robot("[gains]\\nKp = [1, 2]", "x.toml")
    (True, False)
    """
    if ends_in(file, ".kuka.toml"):
        return True
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError):
        return False
    return isinstance(tables.get("dh"), dict) or (
        isinstance(tables.get("joints"), dict) and "kinds" in tables["joints"] and "schema" in tables
    )


def robot_findings(robot: str | Path) -> Iterator[Finding]:
    """What `check` of a robot, by name or file, refuses or finds failing; each an error."""
    from lwr_dyn.arms.loading import load_with_paper
    from lwr_dyn.checks.arm.run_checks import check_arm

    try:
        arm, paper = load_with_paper(robot)
        report = check_arm(arm, paper)
    except LwrDynError as fault:
        said = " ".join(str(fault).split())
        yield Finding("refused", "error", "certain", ("as a robot",), "", "", said, file=str(robot))
        return
    for verdict in report.verdicts:
        if not verdict.holds:
            unit = f" {verdict.unit}" if verdict.unit else ""
            bare = "" if verdict.unit in ("1", "relative", "ratio") else unit
            numbers = {"value": float(verdict.value), "tolerance": float(verdict.tolerance)}
            yield Finding(
                "check", "error", "certain", (verdict.name,), f"{verdict.value:.6g}{unit}",
                f"{verdict.bound} {verdict.tolerance:.6g}{unit}",
                f"{verdict.value:.3g}{bare} where {verdict.bound} {verdict.tolerance:.3g} is allowed (lwr-dyn check)",
                {k: v for k, v in numbers.items() if isfinite(v)}, file=str(robot),
            )  # fmt: skip
