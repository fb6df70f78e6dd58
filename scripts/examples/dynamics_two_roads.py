"""B, C and g of the LWR 4+ by both roads at one state, and how far they are apart over many."""

from __future__ import annotations

import argparse

import numpy as np

import lwr_dyn


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot", nargs="?", default="lwr4plus")
    parser.add_argument("--states", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load(options.robot)
    road_a = lwr_dyn.dynamics_of(arm, engine="pinocchio")  # table -> URDF text -> Pinocchio
    road_b = lwr_dyn.dynamics_of(arm, engine="newton-euler")  # table -> the paper's recursion on its own frames
    rng = np.random.default_rng(options.seed)
    q, dq = rng.uniform(-2, 2, (2, options.states, arm.n))

    with np.printoptions(precision=5, suppress=True, linewidth=120):
        print("B(q) [kg m^2]\n", road_a.mass_matrix(q[0]))
        print("C(q, dq) [N m s/rad]\n", road_a.coriolis_matrix(q[0], dq[0]))
        print("g(q) [N m]\n", road_a.gravity_vector(q[0]))
    for name, x in (("mass_matrix", (q,)), ("coriolis_matrix", (q, dq)), ("gravity_vector", (q,))):
        a, b = getattr(road_a, name)(*x), getattr(road_b, name)(*x)
        print(f"{name:16s} largest difference {np.abs(a - b).max():.1e} of {np.abs(a).max():.3g}")


if __name__ == "__main__":
    main()
