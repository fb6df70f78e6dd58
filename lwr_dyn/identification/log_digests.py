"""Logs that a fit used by their digests, which a written model keeps."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.identification.regression.samples import Samples

_CHUNK = 1 << 20


@dataclass(frozen=True, slots=True)
class LogDigest:
    """A log that a fit used: its path, the SHA-256 of its bytes (of a folder: of its files in order), its instants."""

    source: str
    sha256: str
    instants: int

    def text(self) -> str:
        """`moves.csv (sha256 1f..., 982 instants)`."""
        digest = f"sha256 {self.sha256}" if self.sha256 else "not a file"
        return f"{Path(self.source).name} ({digest}, {self.instants} instants)"


def log_digests(samples: Samples) -> Iterator[LogDigest]:
    """The logs of instants, in their order."""
    for source in dict.fromkeys(samples.sources):
        numbers = [i for i, name in enumerate(samples.sources) if name == source]
        yield LogDigest(source, digest_of(Path(source)), int(np.isin(samples.recording, numbers).sum()))


def digest_of(path: Path) -> str:
    """SHA-256 of a file, or of the files of a folder one after the other by name; empty for what is neither."""
    files = [path] if path.is_file() else sorted(x for x in path.rglob("*") if x.is_file()) if path.is_dir() else []
    digest = hashlib.sha256()
    for file in files:
        with open(file, "rb") as stream:
            for chunk in iter(lambda: stream.read(_CHUNK), b""):
                digest.update(chunk)
    return digest.hexdigest() if files else ""
