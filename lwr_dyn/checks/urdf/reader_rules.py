"""What this package's own reader of arms refuses in a file: the reader itself is asked, so that the two are one.

A fault that another rule names is not said again. A sound file of which no serial chain is chosen, such as one of four
legs, has no fault: that is a remark.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from lwr_dyn.arms.urdf.parse import checked_xml
from lwr_dyn.arms.urdf.reader import chosen_chain, joint_limits
from lwr_dyn.arms.urdf.tree import build_tree
from lwr_dyn.checks.urdf.document import UrdfDocument, UrdfFinding
from lwr_dyn.checks.urdf.elements import JointElement, LinkElement
from lwr_dyn.foundation.arrays import number_of
from lwr_dyn.foundation.errors import UrdfError

CODE = "reader-refuses"


class Refusal(NamedTuple):
    """What the reader says."""

    fault: UrdfError
    wants_a_choice: bool
    """The file is sound, and no serial chain is chosen in it or there is none."""


def refused(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """Something that no other rule names and for which `check`, `simulate` and all other commands refuse the file:
    another XML namespace, leftovers of xacro, a number that cannot be read in an unknown element, a second
    <inertial> that is broken, elements nested over 100 deep. The reader itself is asked.
    """
    said = refusal(document)
    if said is not None and not said.wants_a_choice:
        part = _part(document, said.fault.element)
        place = document.root.place if part is None and document.root is not None else part.place if part else None
        if place is not None:
            yield UrdfFinding(
                f"the reader refuses {said.fault.element}: {said.fault.found}", "no command loads the file", place,
                "" if part is None else part.subject, f"allowed: {said.fault.allowed}",
            )  # fmt: skip


OF_THE_TREE = (
    "root-tag",
    "name-missing",
    "name-twice",
    "link-unknown",
    "link-carried-twice",
    "tree-roots",
    "tree-loop",
)
"""Rules after whose errors the reader gets no further."""


def unsaid(findings: Iterable[UrdfFinding]) -> list[UrdfFinding]:
    """The findings, without the reader's where another error is about the same link or joint, or about the tree."""
    found = list(findings)
    errors = {x for f in found if f.level == "error" and f.code != CODE for x in (f.subject, f.code)}
    tree = not errors.isdisjoint(OF_THE_TREE)
    return [f for f in found if f.code != CODE or not (tree or f.subject in errors)]


def remark(document: UrdfDocument) -> Iterator[str]:
    """Why no arm is read of a sound file."""
    said = refusal(document)
    if said is not None and said.wants_a_choice:
        yield f"no arm is read of it as it stands: {said.fault.element}: {said.fault.found}; {said.fault.allowed}"


def refusal(document: UrdfDocument) -> Refusal | None:
    """What the reader says of a file that it refuses, whatever the tip."""
    choosing = False
    try:
        checked = checked_xml(document.content, Path(document.file).name)
        links = {element.get("name", ""): None for element in checked.root.findall("link")}
        urdf = checked.urdf_file(links, {x.name: x for x in map(_joint, checked.root.findall("joint"))})
        tree, choosing = build_tree(urdf, {}), True
        groups, choosing = chosen_chain(tree).groups, False
        for group in groups[1:]:
            joint_limits(urdf, group.joint)
    except UrdfError as fault:
        return Refusal(fault, choosing and "<" not in fault.element)
    return None


def _joint(element: ElementTree.Element) -> SimpleNamespace:
    """A joint with the fields that yourdfpy's has and that decide whether a chain is read; poses do not."""
    axis, limit, dynamics, mimic = (element.find(tag) for tag in ("axis", "limit", "dynamics", "mimic"))
    ends = {tag: x.get("link") for tag in ("parent", "child") if (x := element.find(tag)) is not None}
    direction = "1 0 0" if axis is None else axis.get("xyz", "1 0 0")
    return SimpleNamespace(
        name=element.get("name"), type=element.get("type"), **ends, origin=None,
        axis=np.array([number_of(word) for word in direction.split()]),
        limit=None if limit is None else _fields(limit, "lower", "upper", "velocity", "effort"),
        dynamics=None if dynamics is None else _fields(dynamics, "damping", "friction"),
        mimic=None if mimic is None else _fields(mimic, "joint", multiplier=1.0, offset=0.0),
    )  # fmt: skip


def _fields(element: ElementTree.Element, *names: str, **defaults: float) -> SimpleNamespace:
    """The attributes of an element, numbers but for the name of a joint; None or the default where not written."""
    read: dict[str, Any] = dict.fromkeys(names) | defaults
    for name in read:
        if (text := element.get(name)) is not None:
            read[name] = text if name == "joint" else number_of(text)
    return SimpleNamespace(**read)


def _part(document: UrdfDocument, element: str) -> LinkElement | JointElement | None:
    """The link or joint that a refusal names, `link 'a' <mass> value`; None where it is about the file."""
    parts: tuple[LinkElement | JointElement, ...] = (*document.links, *document.joints)
    named = [x for x in parts if x.name and element.startswith((f"{x.subject} ", _quoted(x)))]
    named += [x for x in parts if x.name and element == x.subject]
    return max(named, key=lambda x: len(x.name), default=None)


def _quoted(part: LinkElement | JointElement) -> str:
    return f"{part.subject.split(' ', 1)[0]} {part.name!r}"
