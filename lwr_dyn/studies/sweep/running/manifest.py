"""What made the results of a sweep: study, kernels, versions, processor; results of two makers are never mixed."""

from __future__ import annotations

import hashlib
import json
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from lwr_dyn.foundation.errors import FileAccessError, LwrDynError
from lwr_dyn.foundation.version import VERSION

SCHEMA = 1
PACKAGES = ("numpy", "scipy", "pin", "casadi", "numba", "llvmlite", "pyarrow", "mpmath")
"""What numbers and bytes depend on."""
_LONGEST = 60


PROCESSOR = "processor"
"""Stands among the versions: rounding depends on it, and counts of encoders on rounding."""


class OtherSweepError(LwrDynError, ValueError):
    """A folder holds the results of another sweep: `what` differs, `found` there, `here` now."""

    def __init__(self, folder: str, what: str, found: str, here: str) -> None:
        super().__init__(
            f"{folder}: holds results of another {what}: {found}, here {here}; allowed: that {what}, or another folder"
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
            found = tuple(
                SweptController(
                    str(x["controller"]), _inside(x["folder"]), str(x["kernel"]), _whole(x["chunk"]),
                    _whole(x["runs"]), x["by"] == "simulate",
                )
                for x in record["controllers"]
            )  # fmt: skip
            return cls(str(record["study"]), str(record["digest"]), found, dict(record["versions"]))
        except (KeyError, TypeError, ValueError, RecursionError):
            raise FileAccessError(path, "no manifest of a sweep", "a folder that `lwr-dyn sweep` has written") from None

    def refuse_other(self, folder: str, here: SweepManifest) -> None:
        """Raise `OtherSweepError` where this one, found in a folder, is not the sweep that is asked for."""
        if self.digest != here.digest:
            raise OtherSweepError(folder, "study", f"{self.study} ({self.digest[:8]})", here.digest[:8])
        for name in sorted({*self.versions, *here.versions}):
            found, now = self.versions.get(name, "none"), here.versions.get(name, "none")
            if found != now:
                what, before = (PROCESSOR, found) if name == PROCESSOR else ("version", f"{name} {found}")
                raise OtherSweepError(folder, what, before, now)
        for old, new in zip(self.controllers, here.controllers, strict=False):
            if old != new:
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


def _inside(name: Any) -> str:
    """The name of a folder in the folder; raises `ValueError` for a path that leads elsewhere."""
    if not isinstance(name, str) or folder_names([name]) != [name]:
        raise ValueError(name)
    return name


def _whole(x: Any) -> int:
    if not isinstance(x, int) or isinstance(x, bool) or x < 1:
        raise ValueError(x)
    return x
