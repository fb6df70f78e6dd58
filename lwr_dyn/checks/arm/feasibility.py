"""Feasibility of each link: positive definite, triangle inequality, radius of gyration.

The first two are exact conditions (a density >= 0 exists). The third bounds plausibility, since a tensor ten times too
large passes both: no mass is farther from the centre of mass than the link reaches. The links of a URDF are judged as
the file writes them: in the sum of welded links a fault can vanish.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from lwr_dyn.checks.arm.verdict import Verdict
from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.feasibility import ROUNDING, is_physical
from lwr_dyn.model.file_layout import fitting
from lwr_dyn.model.spatial import principal_moments
from lwr_dyn.model.written_link import WrittenLink, is_weightless, welded

THICKNESS = 0.12
"""Share of the arm's reach that a link may extend past its joints and centre of mass: half the thickness of a heavy
link. LWR links are at 0.4 to 0.65 of the resulting bound, tensors ten times too large exceed it."""


def feasibility_verdicts(arm: Arm) -> list[Verdict]:
    """The verdicts on every link with an inertial, one by one."""
    joints, flange = arm.uninstalled().joints(), arm.flange()
    ends = [*(j.origin.position for j in joints[1:]), flange.position]
    total = sum(float(np.linalg.norm(p)) for p in (*(j.origin.position for j in joints), flange.position))
    verdicts: list[Verdict] = []
    for index, (body, end) in enumerate(zip(arm.bodies(), ends, strict=True)):
        bodies = [(x.link, x.body) for x in _written(arm, index, body) if x.body is not None and not x.body.unknown]
        heavy = [(name, part) for name, part in bodies if not is_weightless(part)]
        points = [np.zeros(3), end, *(part.com for _, part in heavy)]
        for name, part in heavy:
            verdicts += _of_body(name, part, points, THICKNESS * total)
    return verdicts


def _written(arm: Arm, index: int, body: Body | None) -> Sequence[WrittenLink]:
    """The links of the file that move with a link of the chain, in its URDF frame; the link itself where there are
    none, or where the arm's body is no longer theirs (a payload, another mass)."""
    own, layout = arm.chain.links[index], fitting(arm.layout, arm.uninstalled().chain)
    parts = layout.written.get(own.link, ()) if layout is not None else ()
    whole = welded(parts) if parts else None
    if whole is None or own.body is None or not _same(whole, own.body):
        return (WrittenLink(own.link, body),)
    return [WrittenLink(x.link, None if x.body is None else x.body.seen_from(own.after)) for x in parts]


def _same(a: Body, b: Body) -> bool:
    return a.mass == b.mass and np.array_equal(a.com, b.com) and np.array_equal(a.inertia_com, b.inertia_com)


def _of_body(name: str, body: Body, points: Sequence[Array], thickness: float) -> Iterable[Verdict]:
    """The verdicts on one body: `points` are its joints and the centres of the links that are welded to it."""
    first, second, third = principal_moments(body.inertia_com).tolist()
    if body.mass <= 0.0:
        return [Verdict(f"{name}: mass of a link with a tensor", body.mass, 0.0, "kg", "above")]
    if not body.inertia_com.any():
        return [Verdict(f"{name}: largest principal moment of a link with mass", third, 0.0, "kg m^2", "above")]
    triangle = -(first + second - third) / max(abs(third), 1e-300)
    verdicts = [
        Verdict(f"{name}: smallest principal moment", first, 0.0, "kg m^2", "above"),
        Verdict(f"{name}: triangle inequality, I3 over I1 + I2, less 1", triangle, ROUNDING, "relative"),
    ]
    reach = max(float(np.linalg.norm(body.com - p)) for p in points) + thickness
    if reach > 0.0:
        gyration = float(np.sqrt(max(third, 0.0) / body.mass))
        verdicts.append(Verdict(f"{name}: radius of gyration over the link's reach", gyration / reach, 1.0, "ratio"))
    return verdicts


def missing_mass(arm: Arm) -> list[Verdict]:
    """A failing verdict for each link that moves without any mass at it or further out, where other links have some."""
    bare = [link.link for link in arm.chain.links if link.body is None]
    if len(bare) == arm.n:
        return []
    return [Verdict(f"{name}: mass that moves with the link and beyond it", 0.0, 0.0, "kg", "above") for name in bare]


def not_judged(arm: Arm) -> list[str]:
    """The links whose inertia no verdict is about, and why."""
    if all(link.body is None for link in arm.chain.links):
        return ["masses and inertias are not given: no dynamics"]
    out = []
    for link in arm.chain.links:
        body = link.body
        if body is None:
            out.append(f"{link.link}: no <inertial>")
        elif body.unknown:
            names = ", ".join(INERTIAL[k] for k in body.unknown)
            out.append(f"{link.link}: inertia known in part; no torque depends on {names} about its frame's origin")
        elif is_weightless(body):
            out.append(f"{link.link}: massless, by zeros or by no <inertial>")
    if _length(arm) == 0.0:
        out.append("radius of gyration of links whose centre of mass is on their joint: the chain has no length")
    return out


def _length(arm: Arm) -> float:
    poses = (*(joint.origin for joint in arm.uninstalled().joints()), arm.flange())
    return max(float(np.linalg.norm(pose.position)) for pose in poses)


def at_rest(arm: Arm) -> list[str]:
    """Notes on links that do not move, whose inertials no body can have: they enter no verdict."""
    layout = fitting(arm.layout, arm.uninstalled().chain)
    links = layout.written.get("", ()) if layout is not None else ()
    return [
        f"{x.link} does not move with this arm; no body can have its inertial"
        for x in links
        if x.body is not None and not is_physical(x.body)
    ]
