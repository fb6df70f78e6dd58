"""The KRL files of a folder."""

from pathlib import Path

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import reason_of

ENDINGS = (".src", ".dat", ".sub")


def krl_files(path: str | Path) -> list[Path]:
    """The file itself, or all .src, .dat and .sub files in a folder and below, in order of their paths.

    Links to folders are not followed. Raises `FileAccessError` for another ending and a folder without such a file.
    """
    target = Path(path)
    if not target.is_dir():
        if target.suffix.lower() not in ENDINGS:
            raise FileAccessError(
                str(path), f"ends in {target.suffix or 'nothing'!r}", "a .src, .dat, .sub or a folder"
            )
        return [target]
    try:
        files = sorted(x for x in target.rglob("*") if x.suffix.lower() in ENDINGS and x.is_file())
    except OSError as fault:
        raise FileAccessError(str(path), reason_of(fault), "a folder that can be read") from None
    if not files:
        raise FileAccessError(str(path), "a folder without .src, .dat or .sub", "a folder of KRL files")
    return files
