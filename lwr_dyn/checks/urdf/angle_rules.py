"""Rules of angles: roll, pitch, yaw that look like degrees."""

import math
from collections.abc import Iterator

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.elements import OriginElement
from lwr_dyn.checks.urdf.finding import UrdfFinding, number_text, tag_text, vector_text

_TURN = math.tau + 0.01
"""Angle [rad] above which it is more than a turn, with rounding."""
_QUARTER = 0.01
"""Deviation [rad] from whole quarter turns that rounding explains."""


def angles_in_degrees(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An angle in an `<origin>` of more than a turn (6.28 rad), unless it is a whole number of quarter turns: `rpy` is
    in rad. 90 and 180 are seen; degrees below 6.28 are not.
    """
    places = [(j.origin, j.subject, "") for j in document.joints]
    for link in document.links:
        if link.inertial is not None:
            places.append((link.inertial.origin, link.subject, link.name))
        places += [(shape.origin, link.subject, "") for shape in link.shapes]
    for origin, subject, judged in places:
        yield from _angles(origin, subject, judged)


def _angles(origin: OriginElement, subject: str, judged: str) -> Iterator[UrdfFinding]:
    if origin.rpy is None or origin.element is None:
        return
    large = [float(a) for a in origin.rpy if abs(a) > _TURN]
    meant = [a for a in large if abs(a - round(a / (math.pi / 2)) * (math.pi / 2)) > _QUARTER]
    if meant:
        worst = max(meant, key=abs)
        yield UrdfFinding(
            f"rpy {vector_text(origin.rpy)} rad", f"{number_text(worst)} rad is {abs(worst) / math.tau:.1f} turns",
            origin.place, subject, tag_text(origin.element, rpy=vector_text(np.radians(origin.rpy))), "likely",
            "rpy in degrees", link=judged,
        )  # fmt: skip
