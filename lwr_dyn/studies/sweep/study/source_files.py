"""The files that a study names, looked at again when its runs are made."""

from hashlib import sha256

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import read_bytes
from lwr_dyn.studies.sweep.study.study_file import SweepStudy


class ChangedFileError(FileAccessError):
    """A file that a study names is not the one that was there when the study was read."""

    def __init__(self, path: str) -> None:
        super().__init__(path, "changed since the study was read", "the file as it was, or the study read again")


def digest_of(path: str) -> str:
    """SHA-256 of a file; raises `FileAccessError`."""
    return sha256(read_bytes(path, "a file that the study names")).hexdigest()


def refuse_changed(study: SweepStudy) -> None:
    """Raise `ChangedFileError` for a file of the study with another content, `FileAccessError` for one that is gone."""
    for path, digest in study.places.items():
        if digest_of(path) != digest:
            raise ChangedFileError(path)
