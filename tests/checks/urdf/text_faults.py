"""Faults of spelling, names, numbers and files; each edit returns 1, None where there is nothing to edit."""

import copy
import xml.etree.ElementTree as ET

from tests.checks.urdf.plant_site import PlantSite, moving_joints, number, vector


def _element(site: PlantSite, path: str) -> ET.Element | None:
    """`inertial/mass` and `inertial` of the link, `limit` of the joint; None where the inertial is not usable."""
    if path.startswith("inertial"):
        return site.inertial if path == "inertial" or site.inertial is None else site.inertial.find(path[9:])
    return site.joint.find(path)


def tag_misspelt(site: PlantSite, path: str, written: str) -> float | None:
    """A tag with a slip of the keyboard."""
    element = _element(site, path)
    if element is None or (path == "limit" and site.joint.get("type") == "continuous"):
        return None
    element.tag = written
    return 1.0


def attribute_misspelt(site: PlantSite, path: str, name: str, written: str) -> float | None:
    """An attribute with a slip of the keyboard."""
    element = _element(site, path)
    if element is None or element.get(name) is None:
        return None
    attributes = [(written if key == name else key, value) for key, value in element.items()]
    for key in list(element.attrib):
        del element.attrib[key]
    element.attrib.update(attributes)
    return 1.0


def not_a_number(site: PlantSite, path: str, name: str) -> float | None:
    """nan, as a spreadsheet or a program wrote it."""
    element = _element(site, path)
    if element is None:
        return None
    element.set(name, "nan")
    return 1.0


def no_inertia(site: PlantSite) -> float | None:
    """Mass and tensor 0, as a program writes them that has none."""
    if (inertial := site.inertial) is None:
        return None
    inertial.find("mass").set("value", "0")
    for name in list(inertial.find("inertia").attrib):
        inertial.find("inertia").set(name, "0")
    return 1.0


def link_twice(site: PlantSite) -> float:
    """The link a second time."""
    site.robot.append(copy.deepcopy(site.link))
    return 1.0


def joint_twice(site: PlantSite) -> float | None:
    """The joint under the name of another one."""
    others = [j.get("name") for j in moving_joints(site.robot) if j is not site.joint]
    if not others:
        return None
    site.joint.set("name", others[-1])
    return 1.0


def mesh_gone(site: PlantSite) -> float | None:
    """A mesh file that is not there."""
    meshes = _meshes(site)
    if not meshes:
        return None
    stem, dot, ending = meshes[0].get("filename").rpartition(".")
    meshes[0].set("filename", f"{stem}_gone{dot}{ending}")
    return 1.0


def mesh_times(site: PlantSite, factor: float) -> float | None:
    """The link's meshes in another unit; size: the factor."""
    meshes = _meshes(site)
    for mesh in meshes:
        mesh.set("scale", " ".join(number(x) for x in vector(mesh, "scale", "1 1 1") * factor))
    return factor if meshes else None


def _meshes(site: PlantSite) -> list[ET.Element]:
    return [mesh for role in ("visual", "collision") for x in site.link.findall(role) for mesh in x.iter("mesh")]
