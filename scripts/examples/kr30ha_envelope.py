"""Reach, envelope volume and the section with the report's points: python scripts/examples/kr30ha_envelope.py"""

from __future__ import annotations

import argparse
from pathlib import Path

import lwr_dyn
from lwr_dyn.checks.datasheet.envelope import SECTION, working_envelope
from lwr_dyn.foundation.files import make_folder
from lwr_dyn.pages.plotting.plots import save_figure
from lwr_dyn.reproduction.kr30ha.points import right_points
from lwr_dyn.reproduction.kr30ha.study import envelope_figures


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/kr30ha_envelope"), help="the figure without its ending")
    options = parser.parse_args(arguments)
    arm = lwr_dyn.load("kr30ha")
    envelope, rated = working_envelope(arm), arm.ratings
    print(f"reach {1e3 * envelope.reach:.2f} mm, data sheet {1e3 * (rated.reach or 0.0):.0f}")
    print(f"envelope volume {SECTION}: {envelope.volume:.4f} m^3, data sheet {rated.envelope_volume}")
    print(envelope.overhead)
    print(f"outline: {len(envelope.outline)} arcs")
    points = {point.name: point.wrist_mm / 1e3 for point in right_points(arm)}
    make_folder(options.out.parent)
    files = save_figure(envelope_figures(arm, points), options.out)
    print(f"wrote {', '.join(str(file) for file in files)}")


if __name__ == "__main__":
    main()
