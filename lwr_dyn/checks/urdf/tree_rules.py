"""Rules of the tree: every joint joins two links of the file, every link but one is carried once, none is in a loop."""

from collections.abc import Iterator

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.finding import UrdfFinding, tag_text
from lwr_dyn.checks.urdf.vocabulary import nearest


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
    reached, waiting = set(document.roots), list(document.roots)
    while waiting:
        for joint in document.joints_from(waiting.pop()):
            if joint.child not in reached:
                reached.add(joint.child)
                waiting.append(joint.child)
    lost = [link for link in document.by_name.values() if link.name not in reached]
    if lost:
        names = ", ".join(link.name for link in lost[:6]) + (", ..." if len(lost) > 6 else "")
        carrier = document.joint_into(lost[0].name)
        place = lost[0].place if carrier is None else carrier.place
        yield UrdfFinding(f"a loop through {names}", "no root reaches them", place, lost[0].subject)


def unknown_mimics(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A joint mimics a joint that the file does not have, or itself."""
    joints = {joint.name for joint in document.joints}
    for joint in document.joints:
        element = joint.element.child("mimic")
        if element is not None and (joint.mimic not in joints or joint.mimic == joint.name):
            said = "itself" if joint.mimic == joint.name else f"{joint.mimic!r}, which is no joint of the file"
            meant = nearest(joint.mimic or "", tuple(joints - {joint.name}))
            yield UrdfFinding(
                f"it mimics {said}", "it has nothing to follow", element.place, joint.subject,
                tag_text(element, joint=meant) if meant else "",
            )  # fmt: skip
