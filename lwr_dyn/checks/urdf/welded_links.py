"""Links that fixed joints weld together, and the mass that hangs on a link."""

from lwr_dyn.checks.urdf.document import UrdfDocument


def has_mass(document: UrdfDocument) -> bool:
    """Whether any link of the file has mass; without, it describes kinematics only."""
    return any(link.inertial is not None and not link.inertial.is_zero for link in document.links)


def welded_mass(document: UrdfDocument, name: str) -> float:
    """Mass [kg] of the links that are fixed to a link, further out, without its own."""
    return _mass_beyond(document, name, through_moving=False)


def heavier_beyond(document: UrdfDocument, name: str) -> bool:
    """Whether any link further out has mass."""
    return _mass_beyond(document, name, through_moving=True) > 0.0


def _mass_beyond(document: UrdfDocument, name: str, through_moving: bool) -> float:
    mass, seen, waiting = 0.0, {name}, [name]
    while waiting:
        for joint in document.joints_from(waiting.pop()):
            if joint.child in seen or (joint.moves and not through_moving):
                continue
            seen.add(joint.child)
            waiting.append(joint.child)
            link = document.link(joint.child)
            if link is not None and link.inertial is not None:
                mass += max(link.inertial.mass or 0.0, 0.0)
    return mass
