"""The projects that an editor has open, and to which of them a file belongs; a whole machine is never read.

A file belongs to the innermost folder of the editor above it. Where there is none, or that folder has more entries than
any backup (a root such as / or a home folder), the project is the backup in which the file stands: the folder that
holds the KRC, R1 or STEU on its path. Without one, the file sees those beside it.
"""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from lwr_dyn.krl.editor.edited_project import EditedProject
from lwr_dyn.krl.names.known_names import KnownNames, known_names

MOST_ENTRIES = 20_000
"""Files and folders below a folder; one that has more is no project."""
_OF_CONTROLLER = re.compile(r"KRC|STEU|R\d", re.IGNORECASE)


def backup_above(path: Path) -> Path | None:
    """The backup in which a file stands: the folder that holds the KRC, R1 or STEU on its path; None without one.

    >>> backup_above(Path("/cells/left/KRC/R1/Program/main.src")).as_posix()
    '/cells/left'
    """
    parts = path.parts
    at = next((i for i in range(len(parts) - 2, 0, -1) if _OF_CONTROLLER.fullmatch(parts[i])), 0)
    while at > 1 and _OF_CONTROLLER.fullmatch(parts[at - 1]):
        at -= 1
    return Path(*parts[:at]) if at else None


def has_more_entries(folder: Path, most: int = MOST_ENTRIES) -> bool:
    """Whether a folder has more files and folders below it, without those whose names begin with a point."""
    seen = 0
    for _, folders, names in os.walk(folder):
        folders[:] = [x for x in folders if not x.startswith(".")]
        seen += len(folders) + len(names)
        if seen > most:
            return True
    return False


@dataclass(slots=True, eq=False)
class Session:
    """The folders that an editor has open, each a project."""

    folders: dict[Path, EditedProject] = field(default_factory=dict)
    known: KnownNames = field(default_factory=known_names)
    large: dict[Path, bool] = field(default_factory=dict)
    """Whether a folder has too many entries, once it was looked at."""

    def add_folder(self, folder: Path) -> None:
        """Take a folder as a project."""
        self.folders.setdefault(folder, EditedProject(folder, known=self.known))

    def remove_folder(self, folder: Path) -> None:
        """The editor has closed a folder."""
        self.folders.pop(folder, None)
        self.large.pop(folder, None)

    def place(self, path: Path) -> tuple[EditedProject, str]:
        """The project of a file, and its name there."""
        above = [x for x, project in self.folders.items() if project.whole and x in path.parents]
        folder = max((x for x in above if not self._is_large(x)), key=lambda x: len(x.parts), default=None)
        folder = folder or backup_above(path)
        whole = folder is not None and not self._is_large(folder)
        if folder is None or not whole:
            folder = path.parent
            if whole is False and folder in self.folders and self.folders[folder].whole:
                del self.folders[folder]  # a root with too many entries: its own files see those beside them
        project = self.folders.setdefault(folder, EditedProject(folder, whole, self.known))
        return project, os.path.relpath(path, folder).replace(os.sep, "/")

    def projects(self) -> Iterator[EditedProject]:
        """Those that can be looked through as a whole."""
        yield from (x for x in list(self.folders.values()) if not (x.whole and self._is_large(x.folder)))

    def _is_large(self, folder: Path) -> bool:
        if folder not in self.large:
            self.large[folder] = has_more_entries(folder)
        return self.large[folder]
