"""A folder of KRL files, such as a backup with KRC/R1/Program, read as a project."""

import os
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.krl.language.source import read_source
from lwr_dyn.krl.project.module import ModuleFile, module_file
from lwr_dyn.krl.project.project import Project, project_of

ENDINGS = (".src", ".sub", ".dat")


def load_project(folder: str | Path) -> Project:
    """All `.src`, `.sub` and `.dat` files of a folder and its folders.

    Raises
    ------
    FileAccessError
        It is no folder that can be read, or holds no such file.
    """
    path = Path(folder)
    if not path.is_dir():
        raise FileAccessError(str(folder), "no folder", "a folder of .src, .sub and .dat files")
    return project_of(read_files(path, path), path)


def read_files(folder: Path, relative_to: Path) -> list[ModuleFile]:
    """The KRL files of a folder, named by their paths from `relative_to`; raises `FileAccessError` for none."""
    paths = _paths(folder)
    if not paths:
        raise FileAccessError(str(folder), "a folder without KRL files", "a folder of .src, .sub and .dat files")
    names = (os.path.relpath(x, relative_to).replace(os.sep, "/") for x in paths)
    return [module_file(*read_source(path, name)) for path, name in zip(paths, names, strict=True)]


def is_program_file(path: Path) -> bool:
    """Whether its name is one of a KRL file."""
    return path.suffix.lower() in ENDINGS


def _paths(folder: Path) -> list[Path]:
    """Regular files only: a pipe would never end; folders whose names begin with a point are left out."""
    out = []
    for root, folders, names in os.walk(folder):
        folders[:] = sorted(x for x in folders if not x.startswith("."))
        out += [
            path for path in (Path(root) / name for name in sorted(names)) if is_program_file(path) and path.is_file()
        ]
    return out
