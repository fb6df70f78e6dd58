"""Rules of the shapes: files that cannot be read, units that differ, bodies that do not meet at their joint."""

from collections.abc import Iterable

import numpy as np

from lwr_dyn.arms.urdf.xml_text import DRAWN_HERE
from lwr_dyn.checks.urdf.believed_masses import misscaled
from lwr_dyn.checks.urdf.bodies import bodies_of
from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.elements import JointElement
from lwr_dyn.checks.urdf.finding import FindingSeverity, UrdfFinding, vector_text
from lwr_dyn.checks.urdf.hulls import Hull, depth, gap
from lwr_dyn.checks.urdf.joint_slips import JointSlip, axis_slip, origin_slip
from lwr_dyn.checks.urdf.meshes import OTHER_FORMAT
from lwr_dyn.foundation.arrays import Array

APART = 0.06
"""Gap between neighbours, and distance of a joint from both, over the larger diameter: 0.010 and 0.041 on good arms."""
NEARER, FREER, _NAMED = 0.42, 0.3, 0.1


def mesh_unreadable(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """A mesh file is there and cannot be read as what its ending says.

    STL, OBJ and DAE are read; other formats get a note, and their links are judged without that shape. Programs that
    load a damaged file show nothing in its place or stop; export the mesh again.
    """
    for body in bodies_of(document).values():
        for shape, reason in body.unread:
            what = f"the mesh {shape.mesh} cannot be read"
            severity: FindingSeverity | None = "note" if reason.startswith(OTHER_FORMAT) else None
            instead = "" if severity else "export it again"
            place, link = shape.geometry_place, body.link
            yield UrdfFinding(what, reason, place, link.subject, instead, severity=severity, link=link.name)


def shapes_differ(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """Visual and collision shapes of a link differ 8-fold in volume and 2-fold in diameter: one is in another unit.

    Collision shapes are simplified, but on good arms rarely by more than a factor of 3 in volume. A DAE states its unit
    in the file (`<unit meter="0.001"/>`); an STL has none, so a scale is written in the URDF.
    """
    for body in bodies_of(document).values():
        if body.units_differ and body.visual and body.collision:
            wide = body.visual.diameter / body.collision.diameter
            what = f"its visual shapes have {body.ratio:.3g} times the volume of its collision shapes"
            why = f"diameters {body.visual.diameter:.3g} m and {body.collision.diameter:.3g} m, {wide:.3g} times"
            first = body.link.shapes[0]
            yield UrdfFinding(
                what, why, first.geometry_place, body.link.subject, "both in metres (scale)", "likely",
                "visual and collision shapes in different units", link=body.link.name,
            )  # fmt: skip


def bodies_apart(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """At q = 0 the bodies on both sides of a joint do not meet.

    Good arms have at most 0.010 diameters between the hulls of neighbours (one 0.046), those of other makers 0.021. A
    gap of more than 0.06 points to the origin of the joint or of a shape: in mm, with a sign or an axis exchanged. A
    sign or order that brings the joint 0.1 diameters of the parent nearer to it is named, with the text to write. Where
    a mesh of either body could not be read it is a note: the body may be larger.
    """
    for joint, parent, child, pose in _neighbours(document):
        apart = gap(parent, child, pose) / max(parent.diameter, child.diameter)
        if apart > APART:
            what = f"its bodies {joint.parent} and {joint.child} lie {apart:.2g} diameters apart"
            why = "at q = 0; bodies that a joint holds together meet there"
            yield _at_origin(document, joint, what, why, origin_slip(parent, child, pose))


def joint_off_bodies(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The origin of a joint lies outside both bodies that it holds together.

    On good arms it lies at most 0.041 diameters outside, on those of other makers 0.029. More than 0.06 outside both
    points to the origin of the joint or of a shape.
    """
    for joint, parent, child, pose in _neighbours(document):
        off = _off_both(parent, child, pose)
        if off > APART:
            what = f"its origin lies {off:.2g} diameters outside both {joint.parent} and {joint.child}"
            why = "a joint's axis goes through the bodies that it holds"
            yield _at_origin(document, joint, what, why, origin_slip(parent, child, pose))


def _off_both(parent: Hull, child: Hull, pose: Array) -> float:
    return min(depth(parent, pose[:3, 3]) / parent.diameter, depth(child, np.zeros(3)) / child.diameter)


def origins_doubted(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The origin of a joint with another sign, or its numbers in another order, lies much nearer to the parent.

    Tried are the three signs and five orders at which the bodies still meet. On 147 good joints the best of them comes
    at most 0.34 diameters of the parent nearer; of 122 of other makers the four fingers of one robot 0.56, wrongly.
    Warning above 0.42, with the text to write.
    """
    for joint, parent, child, pose in _neighbours(document):
        apart = gap(parent, child, pose) / max(parent.diameter, child.diameter)
        slip = origin_slip(parent, child, pose) if apart <= APART and _off_both(parent, child, pose) <= APART else None
        if slip is not None and slip.cut > NEARER:
            yield _at_origin(document, joint, "its origin lies far from its parent", "at q = 0", slip)


def axes_doubted(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """A turn about the axis takes much of the child into its parent, a turn about another axis of the frame does not.

    Measured is the share of points of the child's hull inside the parent's hull over the range of the joint. About
    another axis it changes by at most 0.29 less on 146 of 147 good joints. A note from 0.3 less on, with the axis to
    write, where at most a third of the file's joints come half as far: simple arms are drawn through themselves.
    """
    slips = [(joint, axis_slip(joint, parent, child, pose)) for joint, parent, child, pose in _neighbours(document)]
    through = sum(slip is not None and slip.cut > FREER / 2.0 for _, slip in slips)
    for joint, slip in slips if 3 * through <= len(slips) else ():
        if slip is not None and slip.cut > FREER:
            what = f"the axis turns {joint.child} into {joint.parent}: {slip.says}"
            why = f"{slip.cut:.2g} of the child's hull less would go into the parent's"
            instead = f'<axis xyz="{vector_text(slip.values)}"/>'
            yield UrdfFinding(what, why, joint.place_of("axis"), joint.subject, instead, "possible", link=joint.child)


def _at_origin(document: UrdfDocument, joint: JointElement, what: str, why: str, slip: JointSlip | None) -> UrdfFinding:
    instead = ""
    bodies = bodies_of(document)
    severity: FindingSeverity | None = None if bodies[joint.parent].whole and bodies[joint.child].whole else "note"
    if slip is not None and slip.cut > _NAMED and joint.origin.rpy is not None:
        what = f"{slip.says}: {what}"
        why = f"{why}; with it put right the joint lies {slip.cut:.2g} diameters of {joint.parent} nearer to that"
        instead = f'<origin xyz="{vector_text(slip.values)}" rpy="{vector_text(joint.origin.rpy)}"/>'
    return UrdfFinding(what, why, joint.origin.place, joint.subject, instead, "likely", "", severity, joint.child)


def _neighbours(document: UrdfDocument) -> Iterable[tuple[JointElement, Hull, Hull, Array]]:
    """The turning or sliding joints with a hull on both sides, and the child's pose in the parent at q = 0.

    Without those of links whose shapes are in another unit: that is said of the shapes.
    """
    bodies, off = bodies_of(document), misscaled(document)
    for joint in document.joints:
        if {joint.parent, joint.child} & off:
            continue
        parent, child, pose = bodies.get(joint.parent), bodies.get(joint.child), joint.origin.pose
        if joint.moves and pose is not None and parent and child and parent.hull and child.hull:
            yield joint, parent.hull, child.hull, pose


def remarks(document: UrdfDocument) -> Iterable[str]:
    """What cannot be judged because links have no shapes."""
    if document.is_drawn_here:
        yield f"shapes {DRAWN_HERE}: mass, centre and inertia are not held against them"
        return
    bodies = bodies_of(document)
    heavy = [x for x in bodies.values() if x.link.name in document.moved and x.link.inertial and x.link.inertial.mass]
    unseen = [x.link.name for x in heavy if x.hull is None]
    if heavy and len(unseen) == len(heavy):
        yield "no shapes: a third of the faults cannot be seen (mass, centre and inertia against the body)"
    elif unseen:
        yield f"no shapes with a volume: {', '.join(unseen)}; there a third of the faults cannot be seen"
