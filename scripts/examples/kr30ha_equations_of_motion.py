"""Equations of motion of some joints of an arm in symbols, with numbers beside Pinocchio's; --latex writes a document.

python scripts/examples/kr30ha_equations_of_motion.py --joints A1,A2 --latex equations.tex
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.symbolic.arm_equations import equations_of_motion
from lwr_dyn.dynamics.symbolic.equation_forms import compile_equations, equations_latex, equations_text
from lwr_dyn.foundation.files import write_file


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot", nargs="?", default="kr30ha")
    parser.add_argument("--joints", default="A1,A2", help="names of the joints that move")
    parser.add_argument(
        "--hold", nargs="*", default=[], metavar="JOINT=RAD", help="joints before or between that do not"
    )
    parser.add_argument("--any-links", action="store_true", help="keep letters that the arm's own symmetry makes zero")
    parser.add_argument("--latex", help="a .tex file to write")
    options = parser.parse_args(arguments)

    arm, paper = lwr_dyn.load(options.robot), open_paper(options.robot)
    held = {name: float(value) for name, value in (text.split("=") for text in options.hold)}
    begin = time.perf_counter()
    part = equations_of_motion(arm, options.joints.split(","), held, paper, keep_zeros=not options.any_links)
    seconds = time.perf_counter() - begin
    print(equations_text(part.equations))

    symbolic, pinocchio = compile_equations(part.equations).at(part.values), lwr_dyn.dynamics_of(part.arm)
    q, dq, ddq = np.random.default_rng(1).uniform(-2, 2, (3, 100, part.arm.n))
    tau = pinocchio.inverse_dynamics(q, dq, ddq)
    apart = np.abs(symbolic.inverse_dynamics(q, dq, ddq) - tau).max()
    print(f"derived in {seconds:.1f} s; at 100 states tau is Pinocchio's to {apart:.1e} of {np.abs(tau).max():.0f} N m")
    if options.latex:
        write_file(options.latex, equations_latex(part.equations))
        print(f"wrote {options.latex}")


if __name__ == "__main__":
    main()
