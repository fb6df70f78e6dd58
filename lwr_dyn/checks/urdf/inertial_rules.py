"""Rules of inertials that need no shape: missing, zero, negative, impossible, a stand-in, in grams or millimetres."""

import math
from collections.abc import Iterator

import numpy as np

from lwr_dyn.checks.urdf.document import FindingSeverity, UrdfDocument, UrdfFinding, tag_text, vector_text
from lwr_dyn.checks.urdf.elements import MOMENTS, InertialElement, LinkElement
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import number_text

ROUNDING = 1e-9
"""Smallest principal moment, relative to the largest, that rounding explains."""
CLEAR = 0.01
"""Excess over the triangle inequality, relative to the largest moment, that no rounding of digits explains."""
COARSE = 0.1
"""Excess, relative to the largest moment, that is worth a warning where the written digits could explain it."""


def _inertials(document: UrdfDocument) -> Iterator[tuple[LinkElement, InertialElement]]:
    """Links with an inertial."""
    for link in document.links:
        if link.inertial is not None:
            yield link, link.inertial


def inertials_missing(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A link that a joint moves has no `<inertial>`, or one of zeros, and nothing that is fixed to it has mass. Where
    links further out have mass it is an error only if it has shapes: a body was drawn. 108 of 353 public arms have such
    links; without mass at the end of a chain the mass matrix has no inverse.

    A file in which no link has mass describes kinematics only, and is not judged.
    """
    if not document.has_mass:
        return
    for link in document.links:
        inertial = link.inertial
        if link.name not in document.driven or not (inertial is None or inertial.is_zero):
            continue
        if inertial is None and any(x.tag.lower().startswith("inert") for x in link.element.children):
            continue  # misspelt, which has a finding of its own
        severity: FindingSeverity
        if document.mass_beyond(link.name, through_moving=False) > 0.0:
            severity, why = "note", "its mass is that of links fixed to it"
        elif document.mass_beyond(link.name, through_moving=True) > 0.0 and not link.shapes:
            severity, why = "note", "links further out have mass"
        else:
            severity, why = "error", "a joint moves it" + (" and it has shapes" if link.shapes else " and nothing else")
        said = "no <inertial>" if inertial is None else "mass and tensor are 0"
        yield UrdfFinding(
            said, why, link.place if inertial is None else inertial.place, link.subject,
            '<inertial> with <origin>, <mass> and <inertia>', severity=severity, link=link.name,
            cause="links without mass",
        )  # fmt: skip


def masses_negative(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mass below 0, which no body has: every torque and energy with it has the wrong sign. The reader refuses the
    file, wherever the link is.
    """
    for link, inertial in _inertials(document):
        if inertial.mass is not None and inertial.mass < 0.0:
            text = f'<mass value="{number_text(-inertial.mass)}"/>, if only the sign is wrong'
            yield UrdfFinding(
                f"mass {number_text(inertial.mass)} kg", "no body has it", inertial.mass_place, link.subject, text,
            )  # fmt: skip


def masses_zero(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mass of 0 with a tensor that is not 0: inertia is mass times distance squared, so one of the two is wrong."""
    for link, inertial in _inertials(document):
        if inertial.mass == 0.0 and inertial.tensor is not None and inertial.tensor.any():
            yield UrdfFinding(
                "mass 0 with an inertia that is not 0", "moments of inertia are mass times distance squared",
                inertial.mass_place, link.subject, '<mass value="..."/>, or no <inertial>', link=link.name,
            )  # fmt: skip


def half_digit(text: str) -> float:
    """Half a unit of the last digit of a number as written.

    >>> half_digit("0.0025"), half_digit("1.2e-3")
    (5e-05, 5e-05)
    """
    mantissa, _, exponent = text.strip().lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    try:
        return 0.5 * 10.0 ** (int(exponent or 0) - decimals)
    except (ValueError, OverflowError):
        return 0.0


def _tensors(document: UrdfDocument) -> Iterator[tuple[LinkElement, InertialElement, Array, Array]]:
    """Links with an inertial whose tensor is not 0, with its principal moments, ascending."""
    for link, inertial in _inertials(document):
        if inertial.tensor is not None and inertial.tensor.any():
            yield link, inertial, inertial.tensor, np.asarray(np.linalg.eigvalsh(inertial.tensor), float)


def tensors_not_positive(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A tensor with a principal moment below 0, which no body has: a turn about that axis would release energy, and the
    mass matrix can lose its inverse. A moment of exactly 0 is a rod without thickness, and only noted.
    """
    for link, inertial, tensor, moments in _tensors(document):
        if moments[0] < -ROUNDING * abs(moments).max():
            on_diagonal = np.diag(tensor).min() < 0.0
            products = np.abs(tensor - np.diag(np.diag(tensor))).max()
            why = "a diagonal moment is negative" if on_diagonal else f"a product of {number_text(products)} is large"
            yield UrdfFinding(
                f"the tensor is not positive definite: principal moments {vector_text(moments)} kg m^2", why,
                inertial.tensor_place, link.subject, link=link.name,
            )  # fmt: skip
        elif moments[0] <= ROUNDING * moments[2]:
            yield UrdfFinding(
                f"a principal moment is 0: {vector_text(moments)} kg m^2", "only a rod without thickness has it",
                inertial.tensor_place, link.subject, "", "possible", severity="note", link=link.name,
            )  # fmt: skip


def tensors_triangle(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The largest principal moment is above the sum of the two others, which no body has: each moment is a sum of two
    variances of the mass, so none can exceed the sum of the others. An excess that the written digits or 1 % explain
    is a note. 48 of 353 public arms break it.
    """
    for link, inertial, _, moments in _tensors(document):
        excess, largest = float(moments[2] - moments[0] - moments[1]), float(moments[2])
        element = inertial.element.child("inertia")
        cells = [] if element is None else [element.attributes.get(name, "0") for name in MOMENTS]
        slack = sum(map(half_digit, cells))
        if moments[0] <= -ROUNDING * largest or excess <= ROUNDING * largest:
            continue
        doubtful: FindingSeverity = "warning" if excess > COARSE * largest else "note"
        yield UrdfFinding(
            f"principal moments {vector_text(moments)} kg m^2 break the triangle inequality",
            f"{number_text(moments[2])} > {number_text(moments[0])} + {number_text(moments[1])}",
            inertial.tensor_place, link.subject,
            severity=None if excess > CLEAR * largest + slack else doubtful, link=link.name,
        )  # fmt: skip


def tensors_zero(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mass with a tensor of zeros: a point mass, which no link is; the joint before it may have no inertia at all."""
    for link, inertial in _inertials(document):
        if inertial.mass and inertial.mass > 0.0 and inertial.tensor is not None and not inertial.tensor.any():
            yield UrdfFinding(
                f"a mass of {number_text(inertial.mass)} kg with a tensor of 0", "only a point has no moments",
                inertial.tensor_place, link.subject, "the link's tensor", link=link.name,
            )  # fmt: skip


def placeholders(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A stand-in: three equal moments that are 1, or a power of ten, without products. A mass of 1 kg with moments of
    1 kg m^2 is a body of some metres, and an error. 26 of 288 public arms have stand-ins.
    """
    for link, inertial in _inertials(document):
        tensor = inertial.tensor
        if tensor is None or inertial.mass is None or inertial.mass <= 0.0:
            continue
        moment = float(tensor[0, 0])
        if moment <= 0.0 or not np.array_equal(tensor, moment * np.eye(3)):
            continue
        if abs(math.log10(moment) - round(math.log10(moment))) >= 1e-9:
            continue
        radius = math.sqrt(1.5 * moment / inertial.mass)
        yield UrdfFinding(
            f"a stand-in: mass {number_text(inertial.mass)} kg, moments {number_text(moment)} kg m^2",
            f"three equal round moments; the mass would be {number_text(radius)} m away on average",
            inertial.tensor_place, link.subject, "the link's mass and tensor",
            "likely", "stand-ins for unknown inertia", "error" if radius > 1.0 else None, link.name,
        )  # fmt: skip


def inertials_equal(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A link and the one that carries it have the same mass, centre and tensor to the last digit: perhaps a copy. Some
    sound files do it, so it is a note.
    """
    for link, inertial in _inertials(document):
        joint = document.joint_into(link.name)
        parent = None if joint is None else document.link(joint.parent)
        other = None if parent is None else parent.inertial
        if parent is None or other is None or not inertial.is_complete or not other.is_complete or not inertial.mass:
            continue
        pairs = ((inertial.com, other.com), (inertial.inertia, other.inertia))
        if inertial.mass == other.mass and all(np.array_equal(np.asarray(a), np.asarray(b)) for a, b in pairs):
            yield UrdfFinding(
                f"its inertial is that of link {parent.name}", "mass, centre and tensor are equal to the last digit",
                inertial.place, link.subject, sure="possible", link=link.name,
            )  # fmt: skip


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
