"""Rules of units that need no shape: masses in grams, centres of mass in millimetres."""

from collections.abc import Iterator

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.finding import UrdfFinding, number_text, tag_text, vector_text

HEAVY = 2000.0
"""Mass of a link over the cube of the arm's length [kg/m^3] that no arm has: a KR210 has 30 in all, an iiwa 10."""
LONG = 10.0
"""A centre of mass [m] from its link's frame that no arm has."""
RATHER_LONG = 1.0
"""A centre of mass [m] that looks wrong where it is many times the largest distance of two joints."""


def arm_size(document: UrdfDocument) -> float:
    """Length scale of the file [m]: the distances from joint to joint along the longest path."""
    reach: dict[str, float] = {}
    waiting = [(name, 0.0) for name in document.roots]
    while waiting:
        name, length = waiting.pop()
        if name in reach:
            continue
        reach[name] = length
        for joint in document.joints_from(name):
            step = 0.0 if joint.origin.xyz is None else float(np.linalg.norm(joint.origin.xyz))
            waiting.append((joint.child, length + (step if step < LONG else 0.0)))
    return max(reach.values(), default=0.0)


def masses_in_grams(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mass over the cube of the arm's length (sum of the distances between its joints) above 2 000 kg/m^3: whole arms
    have 10 to 30. It looks like grams.
    """
    size = arm_size(document)
    for link in document.links:
        mass = None if link.inertial is None else link.inertial.mass
        if link.inertial is None or mass is None or size <= 0.0 or mass <= HEAVY * size**3 or mass < 10.0:
            continue
        element = link.inertial.element.child("mass")
        yield UrdfFinding(
            f"mass {number_text(mass)} kg in an arm of {number_text(size)} m",
            "whole arms have some 30 kg for a cube of their length",
            link.inertial.mass_place, link.subject,
            "" if element is None else tag_text(element, value=number_text(mass / 1000.0)), "likely",
            "masses in g", link=link.name,
        )  # fmt: skip


def centres_in_millimetres(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A centre of mass more than 10 m from its link's frame, or more than 1 m and three times the length of the whole
    arm: it looks like millimetres.
    """
    size = arm_size(document)
    for link in document.links:
        com = None if link.inertial is None else link.inertial.com
        if link.inertial is None or com is None:
            continue
        distance = float(np.linalg.norm(com))
        if distance > LONG or (distance > RATHER_LONG and 0.0 < 3.0 * size < distance):
            element = link.inertial.origin.element
            yield UrdfFinding(
                f"its centre of mass is {number_text(distance)} m from its frame",
                f"the whole arm is {number_text(size)} m long", link.inertial.origin.place, link.subject,
                "" if element is None else tag_text(element, xyz=vector_text(com / 1000.0)), "likely",
                "centres of mass in mm", link=link.name,
            )  # fmt: skip
