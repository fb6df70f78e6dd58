"""Your own arm in one file: write the template, change a number, load it, check it, compute its dynamics."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.checks.arm.run_checks import check_arm


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/my_arm.toml"))
    options = parser.parse_args(arguments)

    text = template(str(options.out), "my_arm", joints="RRPR", convention="modified")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(text.replace("values = [2.0, 2.0, 2.0, 2.0]", "values = [4.2, 3.1, 1.5, 0.4]"))

    arm = lwr_dyn.load(options.out)
    report = check_arm(arm)
    for verdict in report.verdicts:
        print(f"{'holds' if verdict.holds else 'FAILS'}  {verdict.name}: {verdict.value:.2g} {verdict.unit}")
    torque = lwr_dyn.dynamics_of(arm).gravity_vector(np.full(arm.n, 0.3))
    print("torque that holds it at q = 0.3:", np.round(torque, 3), "N m (N for the sliding joint)")


if __name__ == "__main__":
    main()
