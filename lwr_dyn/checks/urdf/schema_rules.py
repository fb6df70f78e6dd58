"""Rules of the format: the outermost element, names, tags, attributes, numbers.

A misspelt tag or attribute is the worst of them: every engine passes over it in silence. What each element may and must
hold, and how many numbers an attribute has, comes from the XML specification of urdf (wiki.ros.org/urdf/XML) with
urdfdom 4's `capsule`; Drake's, Gazebo's and ros2_control's own elements are named and not looked into.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from lwr_dyn.arms.urdf.parse import xacro_tag
from lwr_dyn.checks.urdf.document import UrdfDocument, UrdfFinding, tag_text
from lwr_dyn.checks.urdf.elements import JointElement, LinkElement
from lwr_dyn.checks.urdf.xml_tree import LARGEST, XmlElement
from lwr_dyn.foundation.arrays import number_of

_POSE = {"xyz": 3, "rpy": 3}
_ALIEN = ("gazebo", "ros2_control", "sensor", "transmission", "mujoco", "plugin", "pybullet", "isaac", "loop_joint")
"""Elements of other programs, at any place, beside those with a prefix (`drake:...`)."""


@dataclass(frozen=True, slots=True, eq=False)
class TagRule:
    """What an element may hold."""

    children: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()
    """Attributes that must be there."""
    texts: tuple[str, ...] = ()
    """Attributes that are words."""
    figures: Mapping[str, int] = field(default_factory=dict)
    """Attributes that are numbers, and how many."""
    only: tuple[str, ...] = ()
    """Children that engines read once: a second one is passed over."""

    @property
    def attributes(self) -> tuple[str, ...]:
        """All attributes that are known."""
        return (*self.texts, *self.figures)


def _figures(*needed: str, optional: tuple[str, ...] = (), texts: tuple[str, ...] = ()) -> TagRule:
    """An element whose attributes are single numbers."""
    return TagRule(needed=needed, texts=texts, figures={name: 1 for name in (*needed, *optional)})


_SHAPE = ("origin", "geometry", "material", "verbose", "contact_coefficients", "surface")
_ENDS = TagRule(texts=("link",), needed=("link",))

TAGS: Mapping[str, TagRule] = {
    "robot": TagRule(("link", "joint", "material", "frame", "muscle"), ("name",), ("name", "version")),
    "link": TagRule(
        ("inertial", "visual", "collision", "contact", "self_collision_checking"), ("name",), ("name", "type"),
        only=("inertial",),
    ),
    "joint": TagRule(
        ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller",
         "joint_properties", "hardwareInterface"),
        ("name", "type"), ("name", "type"),
        only=("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    ),
    "inertial": TagRule(("origin", "mass", "inertia"), only=("origin", "mass", "inertia")),
    "visual": TagRule(_SHAPE, texts=("name", "concave", "group"), only=("origin", "geometry")),
    "collision": TagRule(_SHAPE, texts=("name", "concave", "group"), only=("origin", "geometry")),
    "origin": TagRule(figures={**_POSE, "quat_xyzw": 4, "quat_wxyz": 4}),
    "mass": _figures("value"),
    "inertia": _figures("ixx", "iyy", "izz", optional=("ixy", "ixz", "iyz")),
    "geometry": TagRule(("box", "cylinder", "sphere", "mesh", "capsule", "plane", "cdf", "ellipsoid")),
    "box": TagRule(needed=("size",), figures={"size": 3}),
    "cylinder": _figures("radius", "length"),
    "capsule": _figures("radius", "length"),
    "sphere": _figures("radius"),
    "mesh": TagRule(needed=("filename",), texts=("filename",), figures={"scale": 3}),
    "material": TagRule(("color", "texture"), texts=("name",)),
    "color": TagRule(needed=("rgba",), figures={"rgba": 4}),
    "texture": TagRule(texts=("filename",)),
    "axis": TagRule(needed=("xyz",), figures={"xyz": 3}),
    "parent": _ENDS,
    "child": _ENDS,
    "limit": _figures("effort", "velocity", optional=("lower", "upper", "acceleration", "jerk", "deceleration")),
    "dynamics": _figures(optional=("damping", "friction", "spring_reference", "spring_stiffness", "armature")),
    "mimic": _figures(optional=("multiplier", "offset"), texts=("joint",)),
    "calibration": _figures(optional=("rising", "falling", "reference_position")),
    "safety_controller": _figures("k_velocity", optional=("k_position", "soft_lower_limit", "soft_upper_limit")),
}  # fmt: skip
"""Elements that are looked into; children and attributes of others are not."""


@lru_cache(maxsize=4096)
def nearest(name: str, known: tuple[str, ...]) -> str:
    """The known name that a misspelt one is meant to be; empty where none is near.

    One slip (a letter left out, added, wrong, or two exchanged) in short names, two in those of six letters or more.

    >>> nearest("intertial", ("inertial", "visual")), nearest("xzy", ("xyz", "rpy")), nearest("gravity", ("inertial",))
    ('inertial', 'xyz', '')
    """
    slips = {other: _distance(name.lower(), other.lower()) for other in known}
    near = [other for other, count in slips.items() if count <= (2 if len(other) >= 6 else 1)]
    return min(near, key=lambda other: slips[other], default="")


def _distance(a: str, b: str) -> int:
    """Slips between two words: letters left out, added, wrong, neighbours exchanged."""
    if abs(len(a) - len(b)) > 2:
        return 9
    rows = [list(range(len(b) + 1))]
    for i, letter in enumerate(a, start=1):
        row = [i]
        for j, other in enumerate(b, start=1):
            best = min(row[-1] + 1, rows[-1][j] + 1, rows[-1][j - 1] + (letter != other))
            if i > 1 and j > 1 and letter == b[j - 2] and a[i - 2] == other:
                best = min(best, rows[-2][j - 2] + 1)
            row.append(best)
        rows.append(row)
    return rows[-1][-1]


Owned = tuple[XmlElement, str]
"""An element, and the link or joint that it belongs to in words."""
_LIMITS = ("lower", "upper", "effort", "velocity")
_OTHER_FORMATS = {"sdf": "SDF (Gazebo)", "mujoco": "MJCF (MuJoCo)", "html": "a web page", "COLLADA": "a COLLADA mesh"}
"""Outermost elements of what is taken for a URDF by mistake."""
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_FOREIGN_TYPES = ("ball", "universal", "screw", "spherical")
"""Joint types of Drake and PyBullet."""


@lru_cache(maxsize=4)
def owned(document: UrdfDocument) -> tuple[Owned, ...]:
    """The elements of a URDF that are known, each with its link or joint; not what is inside an unknown one."""
    if document.root is None or document.root.tag != "robot":
        return ()
    found: list[Owned] = []
    waiting: list[Owned] = [(document.root, "")]
    while waiting:
        element, owner = waiting.pop()
        found.append((element, owner))
        for child in reversed(element.children):
            if child.tag in TAGS[element.tag].children and child.tag in TAGS:
                named = child.tag in ("link", "joint", "material") and element.tag == "robot"
                own = f"{child.tag} {child.attributes.get('name', '')}".strip()
                waiting.append((child, own if named else owner))
    return tuple(found)


def root_tag(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The outermost element of a URDF is `<robot name="...">`; in a file with another one nothing can be judged."""
    root = document.root
    if root is not None and root.tag != "robot":
        other = _OTHER_FORMATS.get(root.tag)
        why = f"it is {other}; this command judges URDF and xacro" if other else "a URDF is one <robot>"
        instead = "" if other else "<robot>"
        yield UrdfFinding(f"the outermost element is <{root.tag}>", why, root.place, "", instead)
    elif root is not None and not document.links:
        macros = any(x.tag.startswith("xacro:") for x in root.children)
        instead = "the URDF that it expands to; name the file .xacro, or run xacro" if macros else ""
        yield UrdfFinding("no <link>", "a robot has at least one link", root.place, "", instead)


def missing_names(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The robot, every link and every joint need a name: joints refer to links by it, programs to joints."""
    for element, _ in owned(document):
        if element.tag in ("robot", "link", "joint") and not element.attributes.get("name"):
            what, instead = f"<{element.tag}> without a name", tag_text(element, name="...")
            yield UrdfFinding(what, "nothing can refer to it", element.place, "", instead)


def names_twice(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """Two links, or two joints, must not share a name: engines refuse the file, or keep one of the two in silence."""
    kinds: tuple[tuple[LinkElement | JointElement, ...], ...] = (document.links, document.joints)
    for parts in kinds:
        first = {part.name: part for part in reversed(parts)}
        for part in parts:
            before = first[part.name]
            if part.name and part is not before:
                why = f"first in line {before.place.line}"
                yield UrdfFinding("its name is used twice", why, part.place, part.subject, "another name")


def misspelt_tags(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A tag that is one or two letters off a known one: `<intertial>`, `<mas>`. Engines pass over it in silence, so the
    link has no mass or the joint no limit.
    """
    for element, child, owner in _unknown_children(document):
        meant = nearest(child.tag, TAGS[element.tag].children)
        if meant and not (meant in TAGS[element.tag].only and element.child(meant)):
            yield UrdfFinding(
                f"<{child.tag}> looks like <{meant}>", "engines pass over a tag that they do not know", child.place,
                owner, f"<{meant}>", "likely",
            )  # fmt: skip


def unknown_tags(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A tag that no URDF reader knows at this place. Those of Drake, Gazebo, ros2_control, MuJoCo and PyBullet, and
    every tag with a prefix, are known.
    """
    for element, child, owner in _unknown_children(document):
        if not nearest(child.tag, TAGS[element.tag].children):
            cause = f"<{child.tag}> in <{element.tag}>: no part of a URDF"
            known = ", ".join(TAGS[element.tag].children) or "no elements"
            why = f"<{element.tag}> holds {known}"
            yield UrdfFinding(f"<{child.tag}> is not known here", why, child.place, owner, cause=cause)


def leftovers_of_xacro(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """Tags of xacro in a file that is expanded, such as `<xacro:include>` or the call of a macro that makes no link and
    no joint: no reader of a URDF looks at them. What they include is not there.
    """
    first: dict[str, XmlElement] = {}
    waiting = [] if document.root is None else [*document.root.children]
    for element in waiting:
        tag = xacro_tag(element.tag)
        if tag:
            first.setdefault(element.tag, element)
        waiting += () if tag == "macro" else element.children
    for element in first.values():
        yield UrdfFinding(f"<{element.tag}> is left over from xacro", "no reader looks at it", element.place, "")


def _unknown_children(document: UrdfDocument) -> Iterator[tuple[XmlElement, XmlElement, str]]:
    """Parent, child and owner of each child that its parent should not have."""
    for element, owner in owned(document):
        for child in element.children:
            if child.tag not in TAGS[element.tag].children and ":" not in child.tag and child.tag not in _ALIEN:
                own = f"{child.tag} {child.attributes['name']}" if not owner and "name" in child.attributes else owner
                yield element, child, own


def misspelt_attributes(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An attribute that is a letter or two off a known one: `<origin xzy=...>`, `<mass vaule=...>`. Engines pass over
    it in silence and use the default, most often zero.
    """
    for element, name, owner in _unknown_attributes(document):
        meant = nearest(name, TAGS[element.tag].attributes)
        if meant and meant not in element.attributes:
            text = {k: v for k, v in element.attributes.items() if k != name}
            right = XmlElement(element.tag, {**text, meant: element.attributes[name]}, element.place, frozenset())
            yield UrdfFinding(
                f"{name} of <{element.tag}> looks like {meant}",
                f"engines pass over an attribute that they do not know; {meant} counts as not written",
                element.place, owner, tag_text(right), "likely",
            )  # fmt: skip


def unknown_attributes(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An attribute that no URDF reader knows at this element; those with a prefix are known."""
    by_element: dict[Owned, list[str]] = {}
    for element, name, owner in _unknown_attributes(document):
        meant = nearest(name, TAGS[element.tag].attributes)
        if not meant or meant in element.attributes:
            by_element.setdefault((element, owner), []).append(name)
    for (element, owner), names in by_element.items():
        known = ", ".join(TAGS[element.tag].attributes) or "no attributes"
        what = f"{', '.join(names)} of <{element.tag}>"
        yield UrdfFinding(
            f"{what} {'is' if len(names) == 1 else 'are'} not known", f"<{element.tag}> has {known}", element.place,
            owner, cause=f"{what}: no part of a URDF",
        )  # fmt: skip


def _unknown_attributes(document: UrdfDocument) -> Iterator[tuple[XmlElement, str, str]]:
    for element, owner in owned(document):
        known = TAGS[element.tag].attributes
        for name in element.attributes:
            if name not in known and ":" not in name:
                yield element, name, owner


def missing_attributes(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An attribute that the format requires: a mass without value, an inertia without izz, a limit without effort. Some
    engines refuse the file, others take 0 or 1.
    """
    for element, owner in owned(document):
        misspelt = {nearest(name, TAGS[element.tag].attributes) for name in element.attributes}
        for name in TAGS[element.tag].needed:
            if name not in misspelt and name != "name":
                yield UrdfFinding(
                    f"<{element.tag}> without {name}", "engines refuse the file, or take 0 or 1", element.place, owner,
                    tag_text(element, **{name: "..."}),
                )  # fmt: skip


def missing_elements(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An `<inertial>` without `<mass>` or without `<inertia>`: some readers refuse the file, others take 0 or 1."""
    for element, owner in owned(document):
        known = TAGS[element.tag].children if element.tag == "inertial" else ()
        there = {nearest(child.tag, known) for child in element.children} if known else set()
        for tag in known:
            if tag != "origin" and tag not in there:
                yield UrdfFinding(
                    f"<{element.tag}> without <{tag}>", "readers refuse the file, or take 0 or 1", element.place, owner,
                    f"<{tag} {' '.join(f'{name}=...' for name in TAGS[tag].needed)}/>",
                )  # fmt: skip


def elements_twice(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """An element that counts once is written twice: two `<inertial>` in a link, two `<origin>` in a joint. Readers take
    the first, or the last.
    """
    for element, owner in owned(document):
        for tag in TAGS[element.tag].only:
            for second in element.all(tag)[1:]:
                yield UrdfFinding(
                    f"a second <{tag}> in <{element.tag}>", "some readers take the first, some the last", second.place,
                    owner, f"one <{tag}>",
                )  # fmt: skip


def joint_types(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The type of a joint is one of revolute, continuous, prismatic, fixed, floating, planar; `ball`, `universal` and
    `screw` are read by Drake or PyBullet only.
    """
    for joint in document.joints:
        if "type" in joint.element.attributes and joint.type not in JOINT_TYPES:
            meant = nearest(joint.type, JOINT_TYPES)
            foreign = joint.type in _FOREIGN_TYPES
            yield UrdfFinding(
                f"type {joint.type!r}", f"known: {', '.join(JOINT_TYPES)}", joint.place, joint.subject,
                f'type="{meant}"' if meant else "", severity="warning" if foreign else None,
            )  # fmt: skip


def malformed_numbers(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A numeric attribute holds something else than its count of finite numbers: nan, a decimal comma, a unit, a xacro
    expression that was not expanded. Limits may be infinite.
    """
    for element, owner in owned(document):
        for name, width in TAGS[element.tag].figures.items():
            text = element.attributes.get(name)
            fault = "" if text is None else _number_fault(text, width, name in _LIMITS)
            if fault and text is not None:
                dotted = text.replace(",", ".")
                mended = fault == _COMMA and not _number_fault(dotted, width, True)
                yield UrdfFinding(
                    f"{name} of <{element.tag}> is {text[:60]!r}", fault, element.place, owner,
                    tag_text(element, **{name: dotted}) if mended else "",
                )  # fmt: skip


_COMMA = "a decimal comma"


def _number_fault(text: str, width: int, may_be_infinite: bool) -> str:
    """What is wrong with the numbers of an attribute; empty where nothing is."""
    if "${" in text or "$(" in text:
        return "a xacro expression that was not expanded"
    words = text.split()
    counted = "" if len(words) == width else f"{len(words)} numbers where {width} belong"
    return next((fault for word in words if (fault := _word_fault(word, may_be_infinite))), counted)


def _word_fault(word: str, may_be_infinite: bool) -> str:
    try:
        value = number_of(word)
    except ValueError:
        return _COMMA if "," in word and word.replace(",", "").replace(".", "").lstrip("+-").isdigit() else "no number"
    if math.isnan(value) or (math.isinf(value) and not may_be_infinite):
        return "not finite"
    return "larger than any robot; it is not judged" if abs(value) >= LARGEST and not may_be_infinite else ""
