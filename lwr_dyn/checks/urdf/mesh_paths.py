"""The file that a mesh of a URDF names: by its package, by `file://`, or beside the URDF."""

from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from lwr_dyn.arms.urdf.xacro_file import package_folder

_SCHEMES = ("package://", "model://")
REMOTE = ("http://", "https://")


@dataclass(frozen=True, slots=True)
class MeshPath:
    """Where a mesh lies; without `path` it is not there, or its package is not."""

    path: Path | None
    package_missing: str = ""
    """The package whose folder is not on this machine."""
    expected: Path | None = None
    """Where the file should be, if that is known."""


def mesh_path(mesh: str, document: Path) -> MeshPath:
    """The file of a mesh.

    `package://NAME/...` is looked for in folders named NAME above the URDF and beside these, and in ROS_PACKAGE_PATH
    and AMENT_PREFIX_PATH; where there is none, in the folders above under the rest of the name.

    Parameters
    ----------
    mesh : str
        As written in the URDF.
    document : path
        The URDF.
    """
    if "\0" in mesh or mesh.startswith(REMOTE):
        return MeshPath(None)
    if not mesh.startswith(_SCHEMES):
        local = Path(document).parent / unquote(mesh.removeprefix("file://"))
        return _there(local)
    package, _, rest = mesh.partition("://")[2].partition("/")
    folder = package_folder(package, document)
    if folder is not None:
        return _there(folder / rest)
    for above in document.resolve().parents:
        if rest and (above / rest).is_file():
            return MeshPath(above / rest)
    return MeshPath(None, package_missing=package)


def _there(path: Path) -> MeshPath:
    try:
        return MeshPath(path if path.is_file() else None, expected=path)
    except OSError:  # a name longer than the file system takes
        return MeshPath(None, expected=path)
