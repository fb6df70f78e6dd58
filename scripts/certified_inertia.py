"""Prove the largest inertias of every robot and reading again, and write the table of docs/certified_inertia.md.

python scripts/certified_inertia.py
"""

from __future__ import annotations

import re
import time
from pathlib import Path

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.control.inertia.certificate import InertiaCertificate, inertia_certificate
from lwr_dyn.control.inertia.worst_case import InertiaMaximum, worst_case_inertias
from lwr_dyn.foundation.files import write_file
from lwr_dyn.model.arm import Arm

PAGE = Path(__file__).resolve().parent.parent / "docs" / "certified_inertia.md"
PLACE = re.compile(r"(?<=<!-- certificates -->\n).*(?=\n<!-- certificates: end -->)", re.DOTALL)
GAPS = (1e-6, 1e-9)
HEAD = (
    "| robot | reading | joint | largest met | " + " | ".join(f"gap ({g:.0e} asked) | boxes | s" for g in GAPS)
    + " | rounding |"
)  # fmt: skip


def arms() -> list[Arm]:
    """Every robot with inertias in every reading."""
    found = [lwr_dyn.load(robot, reading=one) for robot in studied() for one in lwr_dyn.readings(robot)]
    return [arm for arm in found if arm.chain.bodies is not None]


def cells(arm: Arm, maximum: InertiaMaximum, proven: list[tuple[InertiaCertificate, float]]) -> list[str]:
    """A row of the table; `proven` has the certificates of `GAPS` and the seconds that they took."""
    row = [f"`{arm.name}`", arm.reading or "", f"`{arm.joint_names[maximum.joint]}`", f"{maximum.value:.9g}"]
    for one, seconds in proven:
        row += [f"{one.gap:.1e}" + ("" if one.holds else " (not as asked)"), str(one.boxes), f"{seconds:.2f}"]
    return [*row, f"{proven[-1][0].allowance / maximum.value:.0e}"]


def table() -> str:
    """All rows, made now."""
    lines = [HEAD, "|---" * (HEAD.count("|") - 1) + "|"]
    for arm in arms():
        for maximum in worst_case_inertias(arm):
            proven = []
            for gap in GAPS:
                start = time.process_time()
                proven.append((inertia_certificate(arm, maximum, gap), time.process_time() - start))
            lines.append(f"| {' | '.join(cells(arm, maximum, proven))} |")
            print(lines[-1], flush=True)
    return "\n".join(lines)


def rows(page: str) -> list[list[str]]:
    """The cells of the page's table, row by row, without its head."""
    lines = PLACE.search(page)[0].splitlines()[2:]
    return [[cell.strip().strip("`") for cell in line.strip("|").split("|")] for line in lines]


def main() -> None:
    arm = lwr_dyn.load("kr30ha")
    inertia_certificate(arm, worst_case_inertias(arm)[0])  # compiles
    made = table()
    write_file(PAGE, PLACE.sub(lambda _: made, PAGE.read_text(encoding="utf-8")))


if __name__ == "__main__":
    main()
