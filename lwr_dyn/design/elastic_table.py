"""Where laws are stable on elastic joints: poles at a moment of a motion, and unstable shares of the joint box."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lwr_dyn.control.linear_feedback import Linearised
from lwr_dyn.control.protocol import Controller, describe, reset
from lwr_dyn.design.elastic_loop import ElasticArm, continuous_poles
from lwr_dyn.design.joint_box import joint_box, wilson_interval
from lwr_dyn.design.sampled_loop import GROWS, Sampling
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.elasticity import JointElasticity
from lwr_dyn.model.run import Reference

POSES, SEED = 2000, 0
GROWTH = 1e-6
"""[1/s] A pole with a larger real part counts as unstable."""


class LinearisedController(Controller, Linearised, Protocol):
    """A controller with a linear form."""


Law = tuple[LinearisedController, str]
"""A controller, and the side that the encoders read."""


@dataclass(frozen=True, slots=True)
class ElasticShares:
    """Of `poses` at rest, how many are unstable where the law acts continuously, and sampled; the worst of each."""

    poses: int
    continuous: int
    sampled: int
    growth: float
    """The largest real part of all continuous poles [1/s]."""
    radius: float
    """The largest spectral radius of the sampled loop."""

    @property
    def intervals(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The shares of the whole box at 95 %, continuous and sampled."""
        return wilson_interval(self.continuous, self.poses), wilson_interval(self.sampled, self.poses)


def elastic_shares(
    arm: ElasticArm, controller: Linearised, q: Array, sampling: Sampling | None = None
) -> ElasticShares:
    """How many of the link poses q (k, n) are unstable at rest; raises as `ElasticArm.loop`."""
    loop = arm.loop(controller, q)
    growth, radius = continuous_poles(loop)[:, 0].real, loop.radius(sampling or Sampling())
    unstable = int((growth > GROWTH).sum()), int((radius > GROWS).sum())
    return ElasticShares(len(q), *unstable, float(growth.max()), float(radius.max()))


def elastic_table(
    arm: Arm,
    laws: Sequence[Law],
    stiffness: Sequence[JointElasticity | str | float],
    reference: Reference,
    t: float,
    sampling: Sampling | None = None,
    poses: int = POSES,
    seed: int = SEED,
) -> Table:
    """Every law on every stiffness: its largest pole frozen at t [s] of a reference, and unstable shares of the box.

    Parameters
    ----------
    arm : Arm
        Its limits are the box.
    laws : sequence of (controller, "motor" or "link")
        Controllers with a linear form, and the side that the encoders read.
    stiffness : sequence of "file", float or JointElasticity
        The largest stiffness [N m/rad] of each case.
    reference : Reference
    t : float
        [s]
    sampling : Sampling, optional
        1 kHz without delay if not given.
    poses, seed : int
        Number of poses drawn evenly, and the seed of the drawing.

    Raises
    ------
    OptionError, MissingDataError
        As `ElasticArm.of` and its `plant`.
    """
    sampling, motion = sampling or Sampling(), reference.sample(np.array([t]))
    lower, upper, _ = joint_box(arm)
    q = np.random.default_rng(seed).uniform(lower, upper, (poses, arm.n))
    rows = []
    for case in stiffness:
        for controller, side in laws:
            plant = ElasticArm.of(arm, case, side)
            reset(controller)
            pole = plant.frozen_poles(controller, motion)[0, 0]
            found = elastic_shares(plant, controller, q, sampling)
            shares = [_share(count, poses) for count in (found.continuous, found.sampled)]
            rows.append(
                (float(plant.elasticity.stiffness.max()), describe(controller)["name"], side, pole.real, *shares)
            )
    late = {0: "", 1: ", late by 1 sample"}.get(sampling.delay, f", late by {sampling.delay} samples")
    headings = (
        Heading("K", "N m/rad", "g"), "law", "reads", Heading(f"pole at {t:g} s", "1/s", "+.1f"),
        "unstable, continuous", f"unstable, {sampling.rate:g} Hz{late}",
    )  # fmt: skip
    title = f"{arm.name}, reading {arm.reading}, elastic joints: largest real part of the poles, and unstable at rest"
    note = f"of {poses} poses drawn evenly from the joint box (seed {seed}), with the share of the box at 95 %"
    return Table(title, headings, rows, note)


def _share(found: int, poses: int) -> str:
    """A share with its interval at 95 %.

    >>> _share(0, 2000), _share(209, 2000)
    ('0 (below 0.2 %)', '10.4 % (9.2 to 11.9 %)')
    """
    low, high = (100 * x for x in wilson_interval(found, poses))
    if found in (0, poses):
        return f"0 (below {high:.1f} %)" if found == 0 else f"all (above {low:.1f} %)"
    return f"{100 * found / poses:.1f} % ({low:.1f} to {high:.1f} %)"
