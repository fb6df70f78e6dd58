"""The folder of a sweep: a manifest, a copy of the study, and for each controller a folder with a file a chunk.

    study.toml  manifest.json  pid/chunk-00000.parquet  pid/chunk-00001.parquet ...

The manifest says what made the results (study, kernels, versions, processor), and those of two makers are never mixed.
Each file is written under a hidden temporary name, forced to the disk and renamed, so that none is ever incomplete. One
process at a time writes.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import json
import os
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from lwr_dyn.foundation.errors import FileAccessError, LwrDynError
from lwr_dyn.foundation.files import make_folder, read_text, reason_of
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.run import short_repr
from lwr_dyn.studies.sweep.running.chunk_file import chunk_stamp, decoded, joined
from lwr_dyn.studies.sweep.summary import ControllerRuns
from lwr_dyn.studies.sweep.sweep_study import MOST_RUNS

SCHEMA = 1
PACKAGES = ("numpy", "scipy", "pin", "casadi", "llvmlite", "pyarrow", "mpmath")
"""What numbers and bytes depend on."""
_LONGEST = 60

PROCESSOR = "processor"
"""Stands among the versions: rounding depends on it, and counts of encoders on rounding."""


class OtherSweepError(LwrDynError, ValueError):
    """A folder holds the results of another sweep: `what` differs, `found` there, `here` now."""

    def __init__(self, folder: str, what: str, found: str, here: str, allowed: str = "") -> None:
        super().__init__(
            f"{folder}: holds results of another {what}: {found}, here {here}; "
            f"allowed: {allowed or f'that {what}'}, or another folder"
        )
        self.folder, self.what, self.found, self.here = folder, what, found, here


def versions() -> dict[str, str]:
    """Package -> version, in this process; "none" where it is not installed. Beside them the processor."""
    found = {"lwr_dyn": VERSION, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    found[PROCESSOR] = _processor()
    return found


def _processor() -> str:
    """Its name and a digest of its features, as LLVM has them; "none" without LLVM."""
    try:
        from lwr_dyn.codegen.kernels.machine_code import host_cpu
    except ImportError:
        return "none"
    system, name, features = host_cpu()
    return f"{name} ({hashlib.sha256(f'{system} {features}'.encode()).hexdigest()[:8]})"


@dataclass(frozen=True, slots=True)
class SweptController:
    """A controller of a sweep: as typed, its folder, the digest of what computes it, and its chunks."""

    controller: str
    folder: str
    kernel: str
    """Digest of the kernel, or of the file for a controller from a file."""
    size: int
    """Runs of a chunk; the last one may have fewer."""
    runs: int
    slow: bool = False
    """Whether `simulate` makes the runs."""

    @property
    def count(self) -> int:
        """Number of chunks."""
        return -(-self.runs // self.size)

    def bounds(self, number: int) -> tuple[int, int]:
        """First run of a chunk, and the one after its last."""
        return number * self.size, min((number + 1) * self.size, self.runs)

    def record(self) -> dict[str, Any]:
        """As the manifest has it."""
        return {
            "controller": self.controller, "folder": self.folder, "kernel": self.kernel, "chunk": self.size,
            "chunks": self.count, "runs": self.runs, "by": "simulate" if self.slow else "kernel",
        }  # fmt: skip

    @classmethod
    def of_record(cls, x: Any) -> SweptController:
        """From the manifest; raises `ValueError` for a folder that leads elsewhere, and for counts below 1."""
        if folder_names([x["folder"]]) != [x["folder"]] or not all(
            type(x[k]) is int and x[k] > 0 for k in ("chunk", "runs")
        ):
            raise ValueError
        if x["runs"] > MOST_RUNS:  # as no study has; its chunks would be counted through for hours
            raise ValueError
        return cls(str(x["controller"]), x["folder"], str(x["kernel"]), x["chunk"], x["runs"], x["by"] == "simulate")


@dataclass(frozen=True, slots=True)
class SweepManifest:
    """Study, controllers and versions of a sweep."""

    study: str
    digest: str
    """Of the study."""
    controllers: tuple[SweptController, ...]
    versions: Mapping[str, str]

    def chunk_digest(self, controller: SweptController) -> str:
        """What the chunks of a controller carry."""
        made = [self.digest, controller.controller, controller.kernel, controller.size, sorted(self.versions.items())]
        return hashlib.sha256(json.dumps(made).encode()).hexdigest()

    def text(self) -> str:
        """The file; the same sweep gives the same text."""
        record = {
            "schema": SCHEMA, "study": self.study, "digest": self.digest,
            "controllers": [one.record() for one in self.controllers], "versions": dict(self.versions),
        }  # fmt: skip
        return json.dumps(record, indent=1) + "\n"

    @classmethod
    def read(cls, path: str, text: str) -> SweepManifest:
        """From the text of a file; raises `FileAccessError` for another text."""
        try:
            record = json.loads(text)
            if record["schema"] != SCHEMA:
                raise ValueError
            found = tuple(map(SweptController.of_record, record["controllers"]))
            return cls(str(record["study"]), str(record["digest"]), found, dict(record["versions"]))
        except (KeyError, TypeError, ValueError, RecursionError):
            raise FileAccessError(path, "no manifest of a sweep", "a folder that `lwr-dyn sweep` has written") from None

    @property
    def runs(self) -> int:
        """Of each controller."""
        return max((one.runs for one in self.controllers), default=0)

    def refuse_other(self, folder: str, here: SweepManifest) -> None:
        """Raise `OtherSweepError` where this one, found in a folder, is not the sweep asked for or fewer runs of it."""
        for name in sorted({*self.versions, *here.versions}):
            found, now = self.versions.get(name, "none"), here.versions.get(name, "none")
            if found != now:
                what, before = (PROCESSOR, found) if name == PROCESSOR else ("version", f"{name} {found}")
                raise OtherSweepError(folder, what, before, now)
        if self.digest != here.digest:
            raise OtherSweepError(folder, "study", f"{self.study} ({self.digest[:8]})", here.digest[:8])
        if here.runs < self.runs:
            raise OtherSweepError(folder, "number of runs", str(self.runs), str(here.runs), "as many or more")
        for old, new in zip(self.controllers, here.controllers, strict=False):
            if replace(old, runs=new.runs) != new:
                what = "kernel" if old.controller == new.controller else "controller"
                raise OtherSweepError(folder, what, f"{old.controller} ({old.kernel[:8]})", new.kernel[:8])
        if len(self.controllers) != len(here.controllers):
            raise OtherSweepError(folder, "study", f"{len(self.controllers)} controllers", str(len(here.controllers)))


def folder_names(controllers: Sequence[str]) -> list[str]:
    """A folder for each controller: letters, digits, dots, - and _; no two alike.

    >>> folder_names(["adaptive:omega-n=30", "my laws/pid.py"])
    ['adaptive-omega-n-30', 'my-laws-pid.py']
    """
    names: list[str] = []
    for text in controllers:
        plain = re.sub(r"[^A-Za-z0-9._-]+", "-", text).strip("-.")[-_LONGEST:].lstrip("-.") or "controller"
        name, i = plain, 2
        while name.lower() in [other.lower() for other in names]:
            name, i = f"{plain}-{i}", i + 1
        names.append(name)
    return names


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

        Where it holds fewer runs of the same sweep, its study and manifest are those of more from now on.

        Raises
        ------
        FileAccessError
            A folder that cannot be written, or that holds other files and no sweep.
        OtherSweepError
            Results of another study, kernel or version, or of more runs.
        SweepInUseError
            Another process writes there.
        """
        path = make_folder(folder)
        with _alone(path):
            found = manifest_in(path)
            if found is not None:
                found.refuse_other(str(folder), manifest)
            for place in (path, *(path / one.folder for one in manifest.controllers)):
                for left in place.glob(f".*{_UNFINISHED}"):
                    with contextlib.suppress(OSError):
                        left.unlink()
            if found is None or found.runs < manifest.runs:
                write_whole(path / STUDY, study_text.encode())
                write_whole(path / MANIFEST, manifest.text().encode())
            for controller in manifest.controllers:
                make_folder(path / controller.folder)
            yield cls(path, manifest)

    def file(self, controller: SweptController, number: int) -> Path:
        """The file of a chunk."""
        return self.path / controller.folder / f"chunk-{number:05d}.parquet"

    def kept(self, controller: SweptController) -> set[int]:
        """Numbers of the chunks that are there, whole, of this sweep, and in their own place."""
        found, digest = self._stamps(controller), self.manifest.chunk_digest(controller)
        bounds = {number: controller.bounds(number) for number in found}
        return {x for x, (first, stop) in bounds.items() if found[x] == (digest, first, stop - first)}

    def misplaced(self, controller: SweptController) -> dict[int, str]:
        """Number -> what stands there: a chunk of this sweep, copied or renamed from another place."""
        found, digest = self._stamps(controller), self.manifest.chunk_digest(controller)
        bounds = {number: controller.bounds(number) for number in found}
        return {
            x: f"{self.file(controller, x)} holds runs from {found[x][1]}, not {first}: copied or renamed, not used"
            for x, (first, _) in bounds.items()
            if found[x][0] == digest and found[x][1] != first
        }

    def _stamps(self, controller: SweptController) -> dict[int, tuple[str, int, int]]:
        names = (path.stem.removeprefix("chunk-") for path in (self.path / controller.folder).glob("chunk-*.parquet"))
        numbers = sorted(int(name) for name in names if name.isascii() and name.isdigit() and len(name) < _LONGEST)
        files = {number: self.file(controller, number) for number in numbers if number < controller.count}
        stamps = {number: chunk_stamp(path) for number, path in files.items() if path.exists()}
        return {number: stamp for number, stamp in stamps.items() if stamp is not None}

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
        found, controllers, missing = SweepFolder(path, manifest), {}, {}
        failures = found.read_failures()
        for one in manifest.controllers:
            kept = found.kept(one)
            if kept:
                parts = [decoded(found.file(one, number), one.controller) for number in sorted(kept)]
                controllers[one.controller] = joined(parts)
            if odd := found.misplaced(one):
                failures[one.controller] = failures.get(one.controller, {}) | odd
            missing[one.controller] = tuple(number for number in range(one.count) if number not in kept)
        return cls(path, manifest, controllers, missing, failures)

    @property
    def is_complete(self) -> bool:
        """Whether no chunk is missing."""
        return not any(self.missing.values())
