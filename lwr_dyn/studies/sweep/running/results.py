"""The results of a sweep as arrays, controller by controller, from the folder that `lwr-dyn sweep` has written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import read_text
from lwr_dyn.model.shown import repr_html, short_repr
from lwr_dyn.studies.sweep.running.chunk_file import decoded, joined
from lwr_dyn.studies.sweep.running.manifest import SweepManifest
from lwr_dyn.studies.sweep.running.sweep_folder import MANIFEST, SweepFolder
from lwr_dyn.studies.sweep.statistics.controller_runs import ControllerRuns

NEEDED = "a folder that `lwr-dyn sweep` has written"


@dataclass(frozen=True, slots=True, eq=False)
class SweepResults:
    """What a sweep has computed so far.

    `controllers` maps each controller, as typed, to its runs in the order of their numbers; one without any finished
    chunk is not there. `missing` are the numbers of the chunks that have no file, `failures` says why, where a chunk
    was tried.
    """

    folder: Path
    manifest: SweepManifest
    controllers: Mapping[str, ControllerRuns]
    missing: Mapping[str, tuple[int, ...]]
    failures: Mapping[str, Mapping[int, str]]
    __repr__ = short_repr
    _repr_html_ = repr_html

    @classmethod
    def load(cls, folder: str | Path) -> SweepResults:
        """The results in a folder, also while a sweep writes into it.

        Raises
        ------
        FileAccessError
            No sweep in the folder, or a file that is damaged.
        MissingPackageError
            Without pyarrow.
        """
        path = Path(folder)
        if not (path / MANIFEST).exists():
            raise FileAccessError(str(folder), f"no {MANIFEST}", NEEDED)
        manifest = SweepManifest.read(str(path / MANIFEST), read_text(path / MANIFEST, NEEDED))
        found = SweepFolder(path, manifest)
        kept = {one.controller: sorted(found.kept(one)) for one in manifest.controllers}
        controllers = {
            one.controller: joined(
                [decoded(found.file(one, number), one.controller) for number in kept[one.controller]]
            )
            for one in manifest.controllers
            if kept[one.controller]
        }
        missing = {
            one.controller: tuple(sorted(set(range(one.count)) - set(kept[one.controller])))
            for one in manifest.controllers
        }
        return cls(path, manifest, controllers, missing, found.read_failures())

    @property
    def is_complete(self) -> bool:
        """Whether no chunk is missing."""
        return not any(self.missing.values())
