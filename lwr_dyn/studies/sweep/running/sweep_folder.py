"""The folder of a sweep: a manifest, a copy of the study, and for each controller a folder with a file a chunk.

    study.toml  manifest.json  pid/chunk-00000.parquet  pid/chunk-00001.parquet ...

Each file is written under a hidden temporary name, forced to the disk and renamed, so that none is ever incomplete. One
process at a time writes.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError, LwrDynError
from lwr_dyn.foundation.files import make_folder, read_text, reason_of
from lwr_dyn.studies.sweep.running.chunk_file import chunk_digest
from lwr_dyn.studies.sweep.running.manifest import SweepManifest, SweptController

MANIFEST, STUDY, FAILURES = "manifest.json", "study.toml", "failures.json"
_UNFINISHED = ".part"


class SweepInUseError(LwrDynError, OSError):
    """Another process writes into the folder of a sweep."""

    def __init__(self, folder: str) -> None:
        super().__init__(f"{folder}: another process sweeps into it; allowed: one at a time, or another folder")
        self.folder = folder


@dataclass(frozen=True, slots=True)
class SweepFolder:
    """A folder that holds, or will hold, the sweep of this manifest."""

    path: Path
    manifest: SweepManifest

    @classmethod
    @contextmanager
    def opened(cls, folder: str | Path, manifest: SweepManifest, study_text: str) -> Iterator[SweepFolder]:
        """The folder, made or checked, while this process alone may write; what a killed process left is deleted.

        Raises
        ------
        FileAccessError
            A folder that cannot be written, or that holds other files and no sweep.
        OtherSweepError
            Results of another study, kernel or version.
        SweepInUseError
            Another process writes there.
        """
        path = make_folder(folder)
        with _alone(path):
            opened = cls(path, manifest)
            if (path / MANIFEST).exists():
                found = SweepManifest.read(str(path / MANIFEST), read_text(path / MANIFEST, "a manifest of a sweep"))
                found.refuse_other(str(folder), manifest)
            opened._clear()
            if not (path / MANIFEST).exists():
                others = sorted(x.name for x in path.iterdir() if x.name != STUDY)
                if others:
                    raise FileAccessError(
                        str(folder), f"holds {others[0]} and no sweep", "an empty folder or a new one"
                    )
                write_whole(path / STUDY, study_text.encode())
                write_whole(path / MANIFEST, manifest.text().encode())
            for controller in manifest.controllers:
                make_folder(path / controller.folder)
            yield opened

    def file(self, controller: SweptController, number: int) -> Path:
        """The file of a chunk."""
        return self.path / controller.folder / f"chunk-{number:05d}.parquet"

    def kept(self, controller: SweptController) -> set[int]:
        """Numbers of the chunks that are there, whole, and of this sweep."""
        digest = self.manifest.chunk_digest(controller)
        bounds = {number: controller.bounds(number) for number in range(controller.count)}
        return {
            number
            for number, (first, stop) in bounds.items()
            if (path := self.file(controller, number)).exists() and chunk_digest(path, stop - first) == digest
        }

    def write_failures(self, failures: Mapping[str, Mapping[int, str]]) -> None:
        """Why chunks are missing, controller by controller; no file where none is."""
        found = {text: {str(k): why for k, why in sorted(each.items())} for text, each in failures.items() if each}
        if found:
            write_whole(self.path / FAILURES, (json.dumps(found, indent=1) + "\n").encode())
        else:
            (self.path / FAILURES).unlink(missing_ok=True)

    def read_failures(self) -> dict[str, dict[int, str]]:
        """What `write_failures` has written; raises `FileAccessError` for another text."""
        path = self.path / FAILURES
        if not path.exists():
            return {}
        try:
            found = json.loads(read_text(path, "what a sweep writes"))
            return {str(name): {int(k): str(why) for k, why in each.items()} for name, each in found.items()}
        except (ValueError, AttributeError, RecursionError):
            raise FileAccessError(str(path), "not what a sweep writes", "to delete it, and sweep again") from None

    def _clear(self) -> None:
        """Delete files under temporary names."""
        for place in (self.path, *(self.path / one.folder for one in self.manifest.controllers)):
            for left in place.glob(f".*{_UNFINISHED}"):
                with contextlib.suppress(OSError):
                    left.unlink()


def manifest_in(folder: Path) -> SweepManifest | None:
    """The manifest in a folder, None in an empty one; raises `FileAccessError` for a folder with other files only."""
    if (folder / MANIFEST).exists():
        return SweepManifest.read(str(folder / MANIFEST), read_text(folder / MANIFEST, "a manifest of a sweep"))
    names = sorted(path.name for path in folder.iterdir())
    others = [name for name in names if name != STUDY and not name.endswith(_UNFINISHED)]
    if others:
        raise FileAccessError(str(folder), f"holds {others[0]} and no sweep", "an empty folder or a new one")
    return None


def write_whole(path: Path, data: bytes) -> None:
    """Write a file, forced to the disk before it gets its name; raises `FileAccessError` and leaves nothing."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}{_UNFINISHED}")
    try:
        with open(temporary, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, path)
        _force(path.parent)
    except OSError as fault:
        with contextlib.suppress(OSError):
            temporary.unlink()
        full = fault.errno in (errno.ENOSPC, errno.EDQUOT)
        allowed = "more room: all finished chunks are kept, and the same command goes on" if full else "a writable file"
        raise FileAccessError(str(path), reason_of(fault), allowed) from None


def _force(folder: Path) -> None:
    """Force the names in a folder to the disk, where the system can."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Hold the folder; the system lets go of it when the process ends, however it ends."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError as fault:
        raise FileAccessError(str(folder), reason_of(fault), "a directory that can be read and written") from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise SweepInUseError(str(folder)) from None
        except OSError:  # a file system without locks
            pass
        yield
    finally:
        os.close(handle)
