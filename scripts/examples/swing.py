"""The arm let go without torque: upright at rest, with speed, and 1e-3 rad off; its energy stays constant."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.simulation.simulate import CASES, free_swing


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="lwr4plus")
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--out", type=Path, default=Path("out/swing"), help="folder of the run files and the page")
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load(options.robot)
    options.out.mkdir(parents=True, exist_ok=True)
    runs = []
    for name, case in CASES.items():
        run = free_swing(arm, name, duration=options.seconds)
        run.save(options.out / f"{name}.npz")
        runs.append(run)
        state = "an equilibrium" if run.meta["note"]["equilibrium"] else "no equilibrium"
        pull = run.meta["note"]["acceleration_at_rest"]
        drift = np.abs(run.energy - run.energy[0]).max()
        moved = np.degrees(np.abs(run.q - run.q[0]).max())
        print(f"{case.title}: {state} (let go it pulls at {pull:.1e} rad/s^2);", end=" ")
        print(f"moved {moved:.4g} deg, energy drift {drift:.1e} J")
    page = options.out / "swing.html"
    lwr_dyn.replay(runs, page, labels=list(CASES), title=f"{arm.title}: torque-free swing")
    print(f"wrote {page}")


if __name__ == "__main__":
    main()
