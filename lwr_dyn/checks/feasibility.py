"""Feasibility of each link: positive definite, triangle inequality, radius of gyration.

The first two are exact conditions (a density >= 0 exists). The third bounds plausibility, since a tensor ten times too
large passes both: no mass is farther from the centre of mass than the link reaches.
"""

import numpy as np

from lwr_dyn.checks.verdict import Verdict
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.feasibility import ROUNDING
from lwr_dyn.model.spatial import principal_moments

THICKNESS = 0.12
"""Share of the arm's reach that a link may extend past its joints and centre of mass: half the thickness of a heavy
link. LWR links are at 0.4 to 0.65 of the resulting bound, tensors ten times too large exceed it."""


def feasibility_verdicts(arm: Arm) -> list[Verdict]:
    """Three verdicts for every link with a body."""
    joints, flange = arm.joints(), arm.flange()
    ends = [*(j.origin.position for j in joints[1:]), flange.position]
    total = sum(float(np.linalg.norm(p)) for p in (*(j.origin.position for j in joints), flange.position))
    verdicts = []
    for link, body, end in zip(arm.chain.links, arm.bodies(), ends, strict=True):
        if body is None or body.mass <= 0.0:
            continue
        name, (first, second, third) = link.link, principal_moments(body.inertia_com).tolist()
        triangle = -(first + second - third) / max(abs(third), 1e-300)
        gyration = float(np.sqrt(max(third, 0.0) / body.mass))
        reach = max(float(np.linalg.norm(body.com - p)) for p in (np.zeros(3), end)) + THICKNESS * total
        verdicts += [
            Verdict(f"{name}: smallest principal moment", first, 0.0, "kg m^2", "above"),
            Verdict(f"{name}: triangle inequality, I3 over I1 + I2, less 1", triangle, ROUNDING, "relative"),
            Verdict(f"{name}: radius of gyration over the link's reach", gyration / reach, 1.0, "ratio"),
        ]
    return verdicts
