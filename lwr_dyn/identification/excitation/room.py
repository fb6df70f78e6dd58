"""Whether an arm has any room beside floor, column and own links, and what the column is; before a search begins."""

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.excitation.clearance import Clearance, random_positions
from lwr_dyn.identification.excitation.motion_design import HOPELESS, ExcitationError
from lwr_dyn.kinematics.forward import joint_axes

POSES = 2000
"""Random poses; where all are far from clear, no search is begun."""


def check_room(clearance: Clearance, column: float | None = None) -> None:
    """Raise where nothing can be clear.

    Raises
    ------
    OptionError
        A `column` [m] that was asked for holds the whole arm inside in most poses.
    ExcitationError
        Each of `POSES` random poses is more than `HOPELESS` too near something.
    """
    if column and len(links_inside(clearance)) == _links(clearance):
        raise OptionError("column", column, "a radius in m that does not hold the whole arm inside")
    distances = clearance.of(random_positions(clearance.arm, POSES, np.random.default_rng(0)))
    if not distances.size:
        return
    nearest = distances.min(axis=1)
    best = int(np.argmax(nearest))
    if nearest[best] < HOPELESS:
        name = clearance.names[int(np.argmin(distances[best]))]
        words = f"the clearest of {POSES} random poses is {-nearest[best]:.3g} m too near ({name})"
        raise ExcitationError(f"excitation of {clearance.arm.name}", words, "a lower floor, or less to keep")


def links_inside(clearance: Clearance) -> tuple[str, ...]:
    """Links that are not held against the column: those beside it, and those inside it in most poses."""
    if not _has_column(clearance):
        return ()
    held = {b for a, b in clearance.pairs if a == 0}
    return tuple(
        clearance.arm.chain.links[start].link for b, (start, _) in enumerate(clearance.capsules) if b and b not in held
    )


def column_words(clearance: Clearance) -> str:
    """How thick the column is, to which height it reaches, and what is not held against it; empty without one."""
    if not _has_column(clearance):
        return ""
    arm, radius = clearance.arm, clearance.radii[0]
    top = float(joint_axes(arm.chain, np.zeros((1, arm.n))).p[0, 0, 2])
    inside = links_inside(clearance)
    but = f"; not held against it (next to it, or inside in most poses): {', '.join(inside)}" if inside else ""
    return f"column of radius {radius:.3g} m up to {arm.joint_names[0]} at {top:.3g} m, rounded above it{but}"


def _has_column(clearance: Clearance) -> bool:
    return bool(clearance.capsules) and clearance.capsules[0] == (0, clearance.arm.n + 1)


def _links(clearance: Clearance) -> int:
    return len(clearance.capsules) - 1
