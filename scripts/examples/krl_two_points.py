"""A KUKA program from two points: written with Status and Turn, checked, run on the KR 30 HA."""

from __future__ import annotations

import argparse

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.files import make_folder
from lwr_dyn.krl.diagnostics import summary
from lwr_dyn.krl.running.program_run import check_program, run_program
from lwr_dyn.krl.writing.point_program import generate_program, point_program_of

TASK = {
    "name": "TwoPoints",
    "wait": 2.0,
    "point": [
        {"name": "Point1", "xyz": [91, -1139, 1392], "abc": [0, 0, 0], "wait": 2.0},
        {"name": "Point2", "xyz": [91, -1117, 1447], "abc": [0, 0, 0], "wait": 2.0},
    ],
}


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="out/krl_two_points", help="folder for TwoPoints.src, .dat and .npz")
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load("kr30ha")
    program = generate_program(point_program_of(TASK, arm), arm)
    print(program.source.text().replace("\r\n", "\n"))
    print(f"check: {summary(check_program(program, arm))}")

    run = run_program(program, arm)
    for motion, pose in zip(run.executed, run.poses(), strict=True):
        place = f"({pose.x_mm:.3f}, {pose.y_mm:.3f}, {pose.z_mm:.3f}) mm"
        print(f"{motion.begin:7.3f} s to {motion.end:7.3f} s  {motion.kind:12} {place}")
    peak = ", ".join(f"{x:.0f}" for x in np.abs(run.torque).max(axis=0))
    print(f"cycle {run.duration:.3f} s; largest torques {peak} N m (masses estimated)")

    folder = make_folder(options.out)
    program.source.save(folder / program.source.name)
    if program.data is not None:
        program.data.save(folder / program.data.name)
    file = folder / "TwoPoints.npz"
    run.to_run().save(file)
    print(f"wrote {file}; see it:  lwr-dyn replay {file} --html {file.with_suffix('.html')}")


if __name__ == "__main__":
    main()
