"""Feasibility of each link: positive definite, triangle inequality, radius of gyration.

The first two are exact conditions (a density >= 0 exists). The third bounds plausibility, since a tensor ten times too
large passes both: no mass is farther from the centre of mass than the link reaches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.verdict import Verdict
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.feasibility import ROUNDING
from lwr_dyn.model.spatial import principal_moments

THICKNESS = 0.12
"""Share of the arm's reach that a link may extend past its joints and centre of mass: half the thickness of a heavy
link. LWR links are at 0.4 to 0.65 of the resulting bound, tensors ten times too large exceed it."""


@dataclass(frozen=True, slots=True)
class LinkFeasibility:
    """Inertia of one link against its size: moments [kg m^2], lengths [m]."""

    link: str
    principal: tuple[float, float, float]
    triangle: float
    """I1 + I2 - I3 over I3, not negative for a body."""
    gyration: float
    """Largest radius of gyration about the centre of mass."""
    reach: float
    """Largest possible distance of the link's mass from its centre of mass."""


def links_feasibility(arm: Arm) -> tuple[LinkFeasibility, ...]:
    """Feasibility of every link with a body."""
    joints, flange = arm.joints(), arm.flange()
    ends = [*(j.origin.position for j in joints[1:]), flange.position]
    total = sum(float(np.linalg.norm(p)) for p in (*(j.origin.position for j in joints), flange.position))
    rows = []
    for link, body, end in zip(arm.chain.links, arm.bodies(), ends, strict=True):
        if body is None or body.mass <= 0.0:
            continue
        moments = principal_moments(body.inertia_com)
        spans = [float(np.linalg.norm(body.com - p)) for p in (np.zeros(3), end)]
        rows.append(
            LinkFeasibility(
                link=link.link,
                principal=(float(moments[0]), float(moments[1]), float(moments[2])),
                triangle=float((moments[0] + moments[1] - moments[2]) / max(abs(moments[2]), 1e-300)),
                gyration=float(np.sqrt(max(moments[2], 0.0) / body.mass)),
                reach=max(spans) + THICKNESS * total,
            )
        )
    return tuple(rows)


def feasibility_verdicts(arm: Arm) -> list[Verdict]:
    """Three verdicts a link."""
    rows = []
    for f in links_feasibility(arm):
        rows.append(Verdict(f"{f.link}: smallest principal moment", f.principal[0], 0.0, "kg m^2", "above"))
        rows.append(
            Verdict(f"{f.link}: triangle inequality, I3 over I1 + I2, less 1", -f.triangle, ROUNDING, "relative")
        )
        rows.append(Verdict(f"{f.link}: radius of gyration over the link's reach", f.gyration / f.reach, 1.0, "ratio"))
    return rows
