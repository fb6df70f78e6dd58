"""Rules of drives: friction, rotors, travel, speeds that look like rpm, efforts against the weight and the others."""

import math
from collections.abc import Iterator

import numpy as np

from lwr_dyn.checks.urdf.document import TURNING, FindingSeverity, UrdfDocument, UrdfFinding, link_poses, tag_text
from lwr_dyn.checks.urdf.elements import JointElement
from lwr_dyn.checks.urdf.inertia_shape_rules import largest_weight
from lwr_dyn.checks.urdf.inertial_rules import arm_size
from lwr_dyn.checks.urdf.joint_rules import FAST, LONG_TRAVEL
from lwr_dyn.checks.urdf.xml_tree import scalar
from lwr_dyn.foundation.number_text import number_text


def losses_negative(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A damping or friction below 0: the joint would push on whatever moves it, and energy would come from nowhere.
    No simulation of such a file is stable; the reader of this package refuses it.
    """
    for joint in document.joints:
        dynamics = joint.element.child("dynamics") if joint.moves else None
        for name in ("damping", "friction"):
            value = scalar(dynamics, name)
            if dynamics is not None and value is not None and value < 0.0:
                yield UrdfFinding(
                    f"{name} {number_text(value)}", "it would drive the joint", dynamics.place, joint.subject,
                    tag_text(dynamics, **{name: number_text(-value)}) + ", if only the sign is wrong",
                )  # fmt: skip


def armatures_unread(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """`<dynamics armature="...">`: no part of the format, and no reader that we know takes a rotor inertia from it, nor
    does this package. What rests on rotor inertia (gains, margins, stability of a loop) is then said of an arm without.
    """
    for joint in document.joints:
        dynamics = joint.element.child("dynamics")
        if dynamics is not None and scalar(dynamics, "armature"):
            yield UrdfFinding(
                f"armature {dynamics.attributes['armature']} of <dynamics>", "nothing reads it: the arm counts as one "
                "without rotors", dynamics.place, joint.subject,
                "<drake:rotor_inertia> and <drake:gear_ratio> in the <actuator> of a <transmission>",
                cause="rotor inertia as armature: nothing reads it",
            )  # fmt: skip


def travels_long(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A slide behind a turning joint that travels further than the whole arm is long (the distances from joint to joint
    along its longest path): its limits look like cm, inches or mm. A slide before all turning joints, a rail or a
    gantry, may be longer than its arm and is left alone.
    """
    size = arm_size(document)
    for joint in document.joints:
        low, up = joint.lower or 0.0, joint.upper or 0.0
        travel = max(up - low, abs(low), abs(up))
        if joint.type != "prismatic" or joint.limit is None or not 0.0 < size < travel <= LONG_TRAVEL:
            continue
        if any(x.type in TURNING for x in joints_before(document, joint)):
            yield UrdfFinding(
                f"a travel of {number_text(up - low)} m" if up > low else f"a limit of {number_text(low)} m",
                f"from joint to joint the whole arm is {size:.3g} m long", joint.limit.place, joint.subject,
                "limits in m", "likely", "travels in another unit",
            )  # fmt: skip


def joints_before(document: UrdfDocument, joint: JointElement) -> list[JointElement]:
    """The joints between the root and a joint, the nearest first."""
    path: list[JointElement] = []
    before = document.joint_into(joint.parent)
    while before is not None and before not in path and before is not joint:
        path.append(before)
        before = document.joint_into(before.parent)
    return path


RPM, DEGREE = math.pi / 30.0, math.pi / 180.0
"""[rad/s] One turn a minute, one degree a second."""
ODD_SPEED = 4.5
"""Speed over the fastest other joint of the same chain that no sound arm has."""
SLOW = 6.0
"""[rad/s] At or below this a speed is odd for no joint: one turn a second."""
FELLOWS = 3
"""Other turning joints of a chain that it takes to tell."""
TIP_SPEED = 22.0
"""[m/s] Of the farthest link when one joint turns at its limit: sound arms up to 6, legs of humanoids 21 and 31."""
SHORT = 4
"""Digits of a speed that someone may have read off a motor in rpm; more come from a conversion to rad/s."""


def velocities_in_rpm(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A speed that looks like turns a minute (9.55 times too large) or deg/s (57 times): more than 4.5 times that of
    each other turning joint in the same chain (at least three), or one at which the farthest link would move at more
    than 22 m/s (sound arms: up to 6, legs of humanoids 21 and 31). The latter is a note where the speed has more than
    four digits, such as 41.3433: it was converted already. Speeds up to 6 rad/s and fingers are left alone; those above
    50 rad/s have a rule of their own.
    """
    reaches = link_poses(document)
    for joint in document.joints:
        speed = joint.velocity
        if joint.type not in TURNING or joint.limit is None or joint.mimic is not None or not speed:
            continue
        if not SLOW < speed <= FAST:
            continue
        others = _other_speeds(document, joint)
        fastest = max(others, default=math.inf)
        tip = speed * _reach(document, joint, reaches)
        noted: FindingSeverity | None = None
        if len(others) >= FELLOWS and speed > ODD_SPEED * fastest and not _is_finger(document, joint):
            why = f"{speed / fastest:.2g} times the fastest of the {len(others)} other joints of its chain"
        elif tip > TIP_SPEED:
            why = f"the farthest link would move at {tip:.2g} m/s"
            noted = "note" if digits(joint.limit.attributes.get("velocity", "")) > SHORT else None
        else:
            continue
        in_rpm = not 0.5 * fastest < speed * DEGREE < 2.0 * fastest
        unit, factor = ("rpm", RPM) if in_rpm else ("deg/s", DEGREE)
        yield UrdfFinding(
            f"velocity limit {number_text(speed)} rad/s, which looks like {unit}", why, joint.limit.place,
            joint.subject, tag_text(joint.limit, velocity=number_text(speed * factor)), "likely",
            f"velocity limits in {unit}", noted,
        )  # fmt: skip


def digits(text: str) -> int:
    """Significant digits of a number as written; zeros at its end do not count.

    >>> digits("41.3433"), digits("0.50"), digits("3.0e1")
    (6, 1, 1)
    """
    return len(text.strip().lower().partition("e")[0].lstrip("+-").replace(".", "").strip("0"))


def _other_speeds(document: UrdfDocument, joint: JointElement) -> list[float]:
    """Speeds of the other turning joints between the root and a joint, and beyond it."""
    beyond = [x for name in document.carried_by(joint.child) for x in document.joints_from(name)]
    mates = [x for x in (*joints_before(document, joint), *beyond) if x.type in TURNING and x.mimic is None]
    return [x.velocity for x in mates if x is not joint and x.velocity is not None and 0.0 < x.velocity < 1e6]


def _is_finger(document: UrdfDocument, joint: JointElement) -> bool:
    """Whether it is one of several last joints on the same link, which are driven by motors of another size."""
    beyond = [x for name in document.carried_by(joint.child) for x in document.joints_from(name) if x.moves]
    return not beyond and sum(x.moves for x in document.joints_from(joint.parent)) > 1


def _reach(document: UrdfDocument, joint: JointElement, poses: dict[str, np.ndarray]) -> float:
    """Largest distance of a link's frame beyond a joint from its axis [m]."""
    length = 0.0 if joint.axis is None else float(np.linalg.norm(joint.axis))
    frames = [poses[name][:, :3, 3] for name in document.carried_by(joint.child) if name in poses]
    if joint.axis is None or not length > 0.0 or joint.child not in poses:
        return 0.0
    here = poses[joint.child]
    axis = here[:, :3, :3] @ (joint.axis / length)
    return max(float(np.linalg.norm(np.cross(axis, x - here[:, :3, 3]), axis=1).max()) for x in frames)


WEAK, STRONG = 0.6, 20000.0
"""Effort over the largest weight moment: good arms 0.8 to 1 312."""
UNLIKE = 30.0
UNKNOWN = 1e6
"""Effort [N m, N] from which it stands for "unknown"."""
STANDING = 0.1
"""Effort over the largest weight moment below which no mounting saves it."""
_STAND_INS = 3
_FEWEST = 2
_NO_LIMIT = 1e9
"""An effort from here on stands for none."""


def effort_against_weight(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The effort cannot hold the weight behind the joint, or could lift it thousands of times.

    The largest moment of the weight over 12 positions of the joints and any mounting, m g times the distance of the
    centre of the moved links from the axis; odd masses and centres are replaced by usual ones. Good arms: effort 0.8 to
    1 312 times that; of robots that always stand upright 4 of 28 joints 0.15 to 0.54 times. Warning below 0.6, and
    above 20 000 times the moment at a distance of at least 5 cm. A note where the effort is above 0.1 times and holds
    the arm as the file stands, and where a large one stands for "unknown": a round number at three joints or more.
    1e6 and more always do.
    """
    poses = link_poses(document)
    for joint in document.joints:
        if joint.effort is None or not 0.0 < joint.effort < UNKNOWN:
            continue
        moment, least = largest_weight(document, joint, poses)
        weak, strong = joint.effort < WEAK * moment, joint.effort > STRONG * max(moment, least) > 0.0
        if weak or strong:
            unit = "N m" if joint.type in TURNING else "N"
            ratio = joint.effort / max(moment, 0.0 if weak else least)
            what = f"effort {joint.effort:.4g} {unit} is {ratio:.2g} times the weight that it holds"
            why = f"the links behind the joint weigh up to {moment:.3g} {unit}, any mounting"
            if strong and least > moment:
                why = f"5 cm from the axis the links behind the joint weigh {least:.3g} N m"
            standing = weak and joint.effort > STANDING * moment and _holds_upright(document, joint, joint.effort)
            noted: FindingSeverity | None = "note" if standing or (strong and _is_stand_in(document, joint)) else None
            yield UrdfFinding(
                what, why, joint.place_of("limit"), joint.subject, "", "likely", severity=noted, link=joint.child
            )


def _holds_upright(document: UrdfDocument, joint: JointElement, effort: float) -> bool:
    """Whether an effort holds the links behind a joint where z of the root points upward."""
    return effort >= WEAK * largest_weight(document, joint, link_poses(document), upright=True)[0]


def _is_stand_in(document: UrdfDocument, joint: JointElement) -> bool:
    """Whether an effort is a round number that three joints or more share."""
    text = f"{joint.effort:.15e}".partition("e")[0]
    shared = sum(x.effort == joint.effort for x in document.joints)
    return not text.replace(".", "").strip("0")[1:] and shared >= _STAND_INS


def unlike_others(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The effort is 30 times the largest, or a thirtieth of the smallest, of all other joints of its type.

    Within a good arm the efforts of neighbours in size lie within a factor of 10. A single one far from all others
    points to its unit (N mm, kg cm).
    """
    for moving in (TURNING, ("prismatic",)):
        efforts = [(x, e) for x in document.joints if x.type in moving and 0.0 < (e := x.effort or 0.0) < _NO_LIMIT]
        for joint, effort in efforts if len(efforts) > _FEWEST else ():
            others = [other for its, other in efforts if its is not joint]
            if effort > UNLIKE * max(others) or effort < min(others) / UNLIKE:
                near = max(others) if effort > max(others) else min(others)
                what = f"effort {effort:.4g} is {effort / near:.2g} times that of the nearest other joint"
                why = f"the other {len(others)} joints of its type have {min(others):.4g} to {max(others):.4g}"
                yield UrdfFinding(what, why, joint.place_of("limit"), joint.subject, "", "likely", link=joint.child)
