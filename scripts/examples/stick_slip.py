"""Stick and slip in three scenes: a slider braking to rest, a load below and above break-away, the WAM's joint 4."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.files import make_folder
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.spatial import Pose
from lwr_dyn.pages.figures.run_figures import register_figure
from lwr_dyn.pages.plotting.plots import save_figure
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.wam7.runs import cruise_error, experiment
from lwr_dyn.reproduction.wam7.study import verdict

MASS, FRICTION = 2.0, JointFriction(Direction(coulomb=3.0, viscous=0.5, static=4.0), Direction(2.0, 0.5, 2.5))


def slider() -> Arm:
    body = Body(MASS, np.zeros(3), 0.01 * np.eye(3))
    link = ChainLink("joint_1", "link_1", JointKind.PRISMATIC, Pose.identity(), Pose.identity(), body)
    return Arm("slider", "none", "slider", Chain((link,), Pose.identity(), np.zeros(3)), (JointLimits(),))


def scene(force: float, duration: float, speed: float = 0.0) -> lwr_dyn.Run:
    arm = slider()
    still = lwr_dyn.reference("hold", arm, q=[0.0], duration=duration)
    return lwr_dyn.simulate(arm, lambda *_: np.array([force]), still, friction=[FRICTION], dq0=[speed])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--speed", type=float, default=0.7, help="of the slider, m/s")
    parser.add_argument("--out", type=Path, help="folder for a plot of joint 4")
    options = parser.parse_args()
    exact = MASS / 0.5 * np.log1p(0.5 * options.speed / 3.0)
    print(f"stops at {scene(0.0, 2.0, options.speed).events[0].t:.12f} s, closed form {exact:.12f} s")
    for share in (0.99, 1.01):
        moved = scene(share * FRICTION.breakaway[1], 1.0).q[-1, 0]
        print(f"{share:.0%} of break-away for 1 s: moves by {moved:g} m")
    arm = lwr_dyn.load("wam7")
    for side in (1, -1):
        result = experiment(arm, 3, side, substeps=1)
        print(f"joint 4 {'up' if side > 0 else 'down'}: {verdict(cruise_error(arm, result))}")
        if options.out and side > 0:
            figure = replace(register_figure(0, 3), title="joint 4 up: sticks and slips")
            save_figure(figure, make_folder(options.out) / "joint_4", replayed_runs([result.run], arm))


if __name__ == "__main__":
    main()
