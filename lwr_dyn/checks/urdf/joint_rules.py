"""Rules of joints: the tree that they make, limits, axes, origins, angles in degrees or parts of quaternions.

Every joint joins two links of the file, every link but one is carried once, none is in a loop.
"""

import math
from collections.abc import Iterator

import numpy as np

from lwr_dyn.checks.urdf.document import TURNING, UrdfDocument, UrdfFinding, tag_text, vector_text
from lwr_dyn.checks.urdf.elements import JointElement, OriginElement
from lwr_dyn.checks.urdf.schema_rules import nearest
from lwr_dyn.checks.urdf.xml_tree import XmlElement
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import number_text
from lwr_dyn.model.spatial import to_rpy


def unknown_links(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The parent or child of a joint is no link of the file. A missing `world` is added unwritten by Drake only."""
    names = tuple(document.by_name)
    for joint in document.joints:
        for tag in ("parent", "child"):
            element = joint.element.child(tag)
            if element is None:
                yield UrdfFinding(f"no <{tag}>", "a joint joins two links", joint.place, joint.subject,
                                  f'<{tag} link="..."/>')  # fmt: skip
            elif (name := element.attributes.get("link", "")) not in document.by_name:
                meant = nearest(name, names)
                instead = tag_text(element, link=meant) if meant else ""
                if name == "world":
                    instead = '<link name="world"/>'
                yield UrdfFinding(
                    f"{tag} {name!r} is no link of the file", f"its {len(names)} links have other names",
                    element.place, joint.subject, instead,
                )  # fmt: skip


def carried_twice(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A link is the child of two joints. A URDF is a tree; each engine writes closed loops its own way."""
    for joint in document.joints:
        first = document.joint_into(joint.child)
        if first is not None and first is not joint and joint.child in document.by_name:
            yield UrdfFinding(
                f"link {joint.child} is carried by two joints", f"{first.name} carries it too, line {first.place.line}",
                joint.place_of("child"), joint.subject,
            )  # fmt: skip


def several_roots(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """More than one link has no parent, so the file is several trees; engines refuse it, or drop the rest."""
    roots = document.roots
    if len(roots) > 1:
        link = document.by_name[roots[1]]
        yield UrdfFinding(
            f"{len(roots)} links without a parent: {', '.join(roots[:6])}{', ...' if len(roots) > 6 else ''}",
            "a URDF is one tree", link.place, link.subject, "a joint that carries it",
        )  # fmt: skip


def loops(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """Joints that follow each other in a circle: no link of the circle has a place."""
    reached = set(document.carried_by(*document.roots))
    lost = [link for link in document.by_name.values() if link.name not in reached]
    if lost:
        names = ", ".join(link.name for link in lost[:6]) + (", ..." if len(lost) > 6 else "")
        carrier = document.joint_into(lost[0].name)
        place = lost[0].place if carrier is None else carrier.place
        yield UrdfFinding(f"a loop through {names}", "no root reaches them", place, lost[0].subject)


def unknown_mimics(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A joint mimics a joint that the file does not have, or itself."""
    joints = tuple(joint.name for joint in document.joints)
    for joint in document.joints:
        element = joint.element.child("mimic")
        if element is not None and (joint.mimic not in joints or joint.mimic == joint.name):
            said = "itself" if joint.mimic == joint.name else f"{joint.mimic!r}, which is no joint of the file"
            meant = nearest(joint.mimic or "", tuple(name for name in joints if name != joint.name))
            yield UrdfFinding(
                f"it mimics {said}", "it has nothing to follow", element.place, joint.subject,
                tag_text(element, joint=meant) if meant else "",
            )  # fmt: skip


TWO_TURNS = 4.0 * math.pi
"""Position limit [rad] that no arm of the corpus with sound limits reaches: two turns to one side."""
DEGREES = 720.0
"""Largest angle that is taken for degrees; beyond it a number stands for "no limit"."""
FAST = 50.0
"""Joint speed [rad/s] above those of sound arms: up to 49 (a humanoid's ankle), 25 (an industrial arm)."""
LONG_TRAVEL = 20.0
"""Travel of a slide [m] above which its limits look like millimetres; a gantry has some metres."""
ENDLESS = 5000.0
"""Travel of a slide [m] that no unit explains, so that it stands for "no limit"."""
FAR = 10.0
"""Distance between two joints [m] that no arm has."""
RATHER_FAR = 2.0
"""Distance between two joints [m] that looks wrong where it is many times the others."""
UNIT = 1e-3
"""Deviation of an axis' length from 1 that rounding to three digits does not explain."""
_BOUNDED = ("revolute", "prismatic")
_MOTORS = (*_BOUNDED, "continuous")
_UNITS = {"effort": ("N m", "N"), "velocity": ("rad/s", "m/s")}
"""Of a turning joint, of a sliding one."""


def _bounded(document: UrdfDocument) -> Iterator[tuple[JointElement, XmlElement, float | None, float | None]]:
    """Joints that need position limits and have a `<limit>`, with this and its lower and upper limit.

    Not written is 0, as all readers take it; None where it is no finite number.
    """
    for joint in document.joints:
        if joint.type in _BOUNDED and joint.limit is not None:
            written = joint.limit.attributes
            low, up = joint.lower if "lower" in written else 0.0, joint.upper if "upper" in written else 0.0
            yield joint, joint.limit, low, up


def limits_missing(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A revolute or prismatic joint without `<limit>`: the format requires it, most engines refuse the file."""
    for joint in document.joints:
        if joint.type in _BOUNDED and joint.limit is None:
            yield UrdfFinding(
                "no <limit>", f"a {joint.type} joint needs one", joint.place, joint.subject,
                '<limit lower="..." upper="..." effort="..." velocity="..."/>'
                + (', or type="continuous"' if joint.type == "revolute" else ""),
            )  # fmt: skip


def limits_in_degrees(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A position limit of a revolute joint of more than two turns (12.57 rad) and at most 720: limits are in rad. Of
    163 joints of arms judged by hand none reaches two turns. The other limit counts as degrees too, unless it is a
    fraction of at most one turn in rad, such as -2.967 beside 170.
    """
    for joint, limit, *ends in _bounded(document):
        values = [v for v in ends if v is not None]
        largest = max(map(abs, values), default=0.0)
        if joint.type == "revolute" and TWO_TURNS < largest <= DEGREES:
            written = {"lower": joint.lower, "upper": joint.upper}
            changed = {name: number_text(math.radians(v)) for name, v in written.items() if v and not _is_in_rad(v)}
            left = [number_text(v) for v in values if v and _is_in_rad(v)]
            why = f"{largest / math.tau:.0f} turns to one side" + "".join(f"; {v} looks like rad" for v in left)
            yield UrdfFinding(
                f"limits {' to '.join(map(number_text, values))} rad", why, limit.place, joint.subject,
                tag_text(limit, **changed), "likely", "limits in degrees",
            )  # fmt: skip


def _is_in_rad(limit: float) -> bool:
    """Whether a limit beside one in degrees looks like rad: a fraction, and at most one turn."""
    return abs(limit) <= math.tau and limit != round(limit)


def limits_without_bound(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A position limit that stands for "none": more than 720 rad for a revolute joint, which `continuous` says better;
    or a travel of more than 20 m for a slide, which looks like millimetres (from
    5 km on it stands for "no limit", and is only noted).
    """
    for joint, limit, *ends in _bounded(document):
        largest, slides = max((abs(v) for v in ends if v is not None), default=0.0), joint.type == "prismatic"
        if largest <= (LONG_TRAVEL if slides else DEGREES):
            continue
        yield UrdfFinding(
            f"a limit of {number_text(largest)} {'m' if slides else 'rad'}",
            f"no joint {'travels' if slides else 'turns'} so far; sampling and scaling by the range break",
            limit.place, joint.subject, "limits in m" if slides else 'type="continuous"', "likely",
            severity="note" if slides and largest > ENDLESS else None,
        )  # fmt: skip


def limits_equal(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """Lower and upper limit are the same number (or neither is written, so both are 0): the joint cannot move."""
    for joint, limit, low, up in _bounded(document):
        if low is not None and low == up:
            written = {"lower", "upper"} & set(limit.attributes)
            yield UrdfFinding(
                f"lower = upper = {number_text(low)}", "the joint cannot move" if written else "neither is written",
                limit.place, joint.subject, 'the range, or type="fixed"', "likely",
            )  # fmt: skip


def limits_exchanged(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The lower limit is above the upper one: no position is allowed."""
    for joint, limit, low, up in _bounded(document):
        if low is not None and up is not None and low > up:
            yield UrdfFinding(
                f"lower {number_text(low)} is above upper {number_text(up)}", "no position is allowed", limit.place,
                joint.subject, tag_text(limit, lower=number_text(up), upper=number_text(low)),
            )  # fmt: skip


def velocity_zero(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A velocity limit of 0 or less: the joint may not move, so planners and controllers stop or divide by zero."""
    return _not_above_zero(document, "velocity", "the joint may not move")


def effort_zero(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An effort limit of 0 or less: the joint has no torque, so controllers hold nothing and some simulators let the
    arm fall. 94 of 353 public arms have it, most of them from exporters that write 0 for "unknown".
    """
    return _not_above_zero(document, "effort", "the joint has no torque")


def _not_above_zero(document: UrdfDocument, name: str, why: str) -> Iterator[UrdfFinding]:
    for joint in document.joints:
        value = joint.effort if name == "effort" else joint.velocity
        if joint.type in _MOTORS and joint.limit is not None and value is not None and value <= 0.0:
            yield UrdfFinding(
                f"{name} limit {number_text(value)}", why, joint.limit.place, joint.subject,
                f"the motor's {name}, in {_UNITS[name][joint.type == 'prismatic']}",
                cause=f"{name} limits of 0 stand for unknown", severity=None if joint.mimic is None else "note",
            )  # fmt: skip


def velocity_in_degrees(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A velocity limit above 50 rad/s (sound arms: up to 25, a humanoid 49), which looks like deg/s. Numbers above
    2 865 are too large for deg/s as well and stand for "unknown": a note, and above 1e6 nothing.
    """
    for joint in document.joints:
        speed = joint.velocity
        if joint.type in TURNING and joint.limit is not None and speed and FAST < speed < 1e6:
            turned = math.radians(speed)
            fits = 0.3 <= turned <= FAST
            yield UrdfFinding(
                f"velocity limit {number_text(speed)} rad/s", "arms have up to 25 rad/s, humanoids 49",
                joint.limit.place, joint.subject,
                tag_text(joint.limit, velocity=number_text(turned)) if fits else "the joint's speed in rad/s",
                "likely", "velocity limits in deg/s" if fits else "",
                "note" if turned > FAST else None,
            )  # fmt: skip


def axes_zero(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An axis of length zero: the joint has no direction; engines divide by zero or refuse the file."""
    for joint in document.joints:
        if joint.moves and joint.type != "floating" and joint.axis is not None and not joint.axis.any():
            yield UrdfFinding(
                "the axis is 0 0 0", "it has no direction", joint.place_of("axis"), joint.subject,
                '<axis xyz="0 0 1"/>, or the direction that is meant',
            )  # fmt: skip


def axes_not_unit(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An axis whose length is not 1 (by more than 1e-3, which rounding to three digits explains): some engines make it
    a unit vector, some scale the motion by it.
    """
    for joint in document.joints:
        if not joint.moves or joint.axis is None or joint.type == "floating":
            continue
        length = float(np.linalg.norm(joint.axis))
        if length > 0.0 and abs(length - 1.0) > UNIT:
            yield UrdfFinding(
                f"the axis {vector_text(joint.axis)} has length {number_text(length)}",
                "some engines take its direction only, some scale the motion by it", joint.place_of("axis"),
                joint.subject, f'<axis xyz="{vector_text(joint.axis / length)}"/>',
            )  # fmt: skip


def origins_in_millimetres(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The origin of a joint is more than 10 m from that of its parent, or more than 2 m and 20 times the median of the
    others: it looks like millimetres.
    """
    lengths = {j: float(np.linalg.norm(j.origin.xyz)) for j in document.joints if j.origin.xyz is not None}
    others = sorted(v for v in lengths.values() if v > 0.0)
    median = others[len(others) // 2] if len(others) > 2 else math.inf
    for joint, length in lengths.items():
        if length > FAR or (length > RATHER_FAR and length > 20.0 * median):
            metres = vector_text(np.asarray(joint.origin.xyz) / 1000.0)
            element = joint.origin.element
            at_root = document.joint_into(joint.parent) is None and not joint.moves
            yield UrdfFinding(
                f"its origin is {number_text(length)} m from its parent",
                f"the median of the file is {number_text(median)} m" if median < FAR else "no arm is that long",
                joint.origin.place, joint.subject, "" if element is None else tag_text(element, xyz=metres), "likely",
                "origins in mm", "note" if at_root else None,
            )  # fmt: skip


def fixed_with_limits(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A fixed joint with `<limit>`: it was meant to move, or the limit is a leftover. All zero is taken for a leftover
    of an exporter and only noted.
    """
    for joint in document.joints:
        if joint.type == "fixed" and joint.limit is not None:
            values = (joint.lower, joint.upper, joint.effort, joint.velocity)
            yield UrdfFinding(
                "a fixed joint with limits", "a fixed joint has no position", joint.limit.place, joint.subject,
                'another type, such as type="revolute", or no <limit>', "possible",
                severity=None if any(values) else "note",
            )  # fmt: skip


_TURN = math.tau + 0.01
"""Angle [rad] above which it is more than a turn, with rounding."""
_QUARTER = 0.01
"""Deviation [rad] from whole quarter turns that rounding explains."""


def angles_in_degrees(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An angle in an `<origin>` of more than a turn (6.28 rad), unless it is a whole number of quarter turns: `rpy` is
    in rad. 90 and 180 are seen; degrees below 6.28 are not.
    """
    for origin, subject, judged in _origins(document):
        if origin.rpy is None or origin.element is None:
            continue
        large = [float(a) for a in origin.rpy if abs(a) > _TURN]
        meant = [a for a in large if abs(a - round(a / (math.pi / 2)) * (math.pi / 2)) > _QUARTER]
        if meant:
            worst = max(meant, key=abs)
            yield UrdfFinding(
                f"rpy {vector_text(origin.rpy)} rad", f"{number_text(worst)} rad is {abs(worst) / math.tau:.1f} turns",
                origin.place, subject, tag_text(origin.element, rpy=vector_text(np.radians(origin.rpy))), "likely",
                "rpy in degrees", link=judged,
            )  # fmt: skip


def _origins(document: UrdfDocument) -> Iterator[tuple[OriginElement, str, str]]:
    """Every `<origin>`, the link or joint that it belongs to in words, and the link whose inertial it is."""
    yield from ((joint.origin, joint.subject, "") for joint in document.joints)
    for link in document.links:
        if link.inertial is not None:
            yield link.inertial.origin, link.subject, link.name
        yield from ((shape.origin, link.subject, "") for shape in link.shapes)


_HALF, _EIGHTH, _REST = math.sqrt(0.5), math.sin(math.pi / 8.0), math.cos(math.pi / 8.0)
PARTS = np.array([
    (0.0, 0.0, _HALF), (0.0, _HALF, _HALF), (0.5, 0.5, 0.5), (0.0, 0.0, 1.0),
    (0.0, 0.0, _EIGHTH), (0.0, 0.0, _REST), (0.0, _EIGHTH, _REST),
])  # fmt: skip
"""Three of the four parts of the quaternions of quarter turns, and of 45 degrees about one axis; sizes, ascending."""
_HALF_TURN = 0.99
_WRITTEN = 1.5e-4
"""Deviation that rounding to 0.707 explains."""


def angles_of_quaternions(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """Angles in an `<origin>` that are three of the four parts of a quaternion: 0.7071 once or twice (a quarter turn),
    0.5 0.5 0.5, 0.3827 or 0.9239 (45 degrees), 1 0 0 (half a turn). As angles in rad they would be 40.5, 28.6, 21.9,
    52.9 and 57.3 degrees, which hardly any part is turned by. 1 0 0 alone is a note: it may be one rad. Parts of other
    turns are not seen.
    """
    for origin, subject, judged in _origins(document):
        if origin.rpy is None or origin.element is None:
            continue
        sizes = np.sort(np.abs(origin.rpy))
        if np.abs(PARTS - sizes).max(axis=1).min() <= _WRITTEN:
            degrees = " ".join(f"{x:.1f}" for x in np.degrees(origin.rpy))
            meant = tag_text(origin.element, rpy=vector_text(np.round(_rpy_of_parts(origin.rpy), 6)))
            yield UrdfFinding(
                f"rpy {vector_text(origin.rpy)} looks like parts of a quaternion", f"as angles {degrees} degrees",
                origin.place, subject, f"{meant}, if they are its x, y, z", "likely", "parts of quaternions as rpy",
                "note" if sizes[2] > _HALF_TURN else None, judged,
            )  # fmt: skip


def _rpy_of_parts(parts: Array) -> Array:
    """Roll, pitch, yaw of the unit quaternion with these x, y, z and w of at least 0."""
    x, y, z = parts / max(1.0, float(np.linalg.norm(parts)))
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    w = math.sqrt(max(0.0, 1.0 - x * x - y * y - z * z))
    return np.array(to_rpy(np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross))
