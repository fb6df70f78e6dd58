"""Rules of shapes that need no geometry: files that are not there, scales, sizes."""

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.elements import LinkElement, ShapeElement
from lwr_dyn.checks.urdf.finding import UrdfFinding, number_text, vector_text
from lwr_dyn.checks.urdf.mesh_paths import REMOTE, mesh_path


def _shapes(document: UrdfDocument) -> Iterator[tuple[LinkElement, ShapeElement]]:
    for link in document.links:
        for shape in link.shapes:
            yield link, shape


def meshes_missing(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mesh whose file is not there though its folder or package is: loaders refuse the file or draw nothing, and
    contacts are missed. Upper and lower case count.
    """
    for link, shape in _shapes(document):
        if shape.kind != "mesh" or not shape.mesh or shape.mesh.startswith(REMOTE):
            continue
        found = mesh_path(shape.mesh, document.path)
        if found.path is None and (not found.package_missing or found.package_missing in _packages_here(document)):
            expected = f"looked for {found.expected}" if found.expected else "a name that no file has"
            near = next((x for x in _beside(found.expected) if x.lower() == shape.mesh.rpartition("/")[2].lower()), "")
            instead = shape.mesh.rpartition("/")[0] + "/" + near if near else ""
            yield UrdfFinding(
                f"the mesh {shape.mesh} is not there", expected, shape.geometry_place, link.subject, instead,
                cause="mesh files are not there",
            )  # fmt: skip


@lru_cache(maxsize=4)
def _packages_here(document: UrdfDocument) -> frozenset[str]:
    """Packages of which a mesh was found: their folder has another name, and is above the file."""
    meshes = {shape.mesh for _, shape in _shapes(document) if "://" in shape.mesh}
    found = {mesh for mesh in meshes if mesh_path(mesh, document.path).path is not None}
    return frozenset(mesh.partition("://")[2].partition("/")[0] for mesh in found)


def _beside(path: object) -> list[str]:
    """Names of the files beside a path."""
    try:
        return [x.name for x in Path(str(path)).parent.iterdir()] if path is not None else []
    except OSError:
        return []


def packages_missing(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """The package of a mesh (`package://NAME/...`) is on this machine neither above the file nor in ROS_PACKAGE_PATH or
    AMENT_PREFIX_PATH. The links drawn with it are judged without their shapes. One note for each package.
    """
    said: set[str] = set()
    for link, shape in _shapes(document):
        if shape.kind == "mesh" and shape.mesh:
            package = mesh_path(shape.mesh, document.path).package_missing
            if package and package not in said and package not in _packages_here(document):
                said.add(package)
                count = sum(s.mesh.partition("://")[2].startswith(f"{package}/") for _, s in _shapes(document))
                yield UrdfFinding(
                    f"the package {package} is not on this machine", f"{count} meshes come from it",
                    shape.geometry_place, link.subject,
                    f"put the folder {package} above or beside the file, or into ROS_PACKAGE_PATH",
                )  # fmt: skip


def mesh_scales(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A mesh scale with a 0, which makes the shape flat; one that differs between the axes by 100 or more, or is
    negative on one or three axes (a mirror image), is a note.
    """
    for link, shape in _shapes(document):
        if shape.kind != "mesh" or shape.scale is None:
            continue
        sizes = np.abs(shape.scale)
        if not sizes.all():
            what, why, severity = "0", "the shape has no volume", None
        elif sizes.max() >= 100.0 * sizes.min():
            what, why, severity = vector_text(shape.scale), "the axes differ 100-fold or more", "warning"
        elif np.prod(shape.scale) < 0.0:
            what, why, severity = vector_text(shape.scale), "the shape is a mirror image", "note"
        else:
            continue
        yield UrdfFinding(
            f"a mesh scale of {what}", why, shape.geometry_place, link.subject, severity=severity,  # type: ignore[arg-type]
        )  # fmt: skip


def shape_sizes(document: UrdfDocument) -> Iterator[UrdfFinding]:
    """A box, cylinder or sphere with a length of 0 or less. A cylinder of length 0 or a sphere of radius 0 is a
    stand-in of exporters: a note where all of its lengths are 0 or more.
    """
    for link, shape in _shapes(document):
        smallest = min(shape.size, default=1.0) if shape.size is not None else 1.0
        if smallest <= 0.0:
            yield UrdfFinding(
                f"a {shape.kind} with a length of {number_text(smallest)} m",
                "no body has it" if smallest < 0.0 else "the shape has no volume", shape.geometry_place, link.subject,
                severity=None if smallest < 0.0 else "note",
            )  # fmt: skip
