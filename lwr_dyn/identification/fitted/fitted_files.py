"""Files of a fitted arm: a data file, or a URDF with its sidecars."""

from pathlib import Path

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file, write_folder
from lwr_dyn.identification.fitted.fitted_arm import fitted_arm
from lwr_dyn.identification.fitted.fitted_values import fitted_values
from lwr_dyn.identification.fitted.paper_text import fitted_paper_text
from lwr_dyn.identification.motion.motion_fit import MotionIdentification

ENDINGS = (".toml", ".urdf")


def check_fitted_path(path: str | Path, paper: Paper | None) -> None:
    """Raise `FileAccessError` now for a path that a fitted arm could not be written to later."""
    if not ends_in(path, *ENDINGS):
        raise FileAccessError(str(path), f"ends in {Path(path).suffix or 'nothing'!r}", "a path in .toml or .urdf")
    if paper is None and ends_in(path, ".toml"):
        allowed = "a .urdf, or a robot from a data file (lwr-dyn urdf ROBOT --out arm.toml makes one)"
        raise FileAccessError(str(path), "the robot comes from a .urdf", allowed)
    check_writable(path)


def write_fitted(path: str | Path, result: MotionIdentification, paper: Paper | None) -> tuple[Path, ...]:
    """Write the arm of an identification.

    Parameters
    ----------
    path : str or path
        Ends in .toml (a data file, for an arm from a data file) or .urdf (with sidecars, for any arm).
    result : MotionIdentification
    paper : Paper or None
        The arm's data file under its reading; None for an arm from a URDF.

    Returns
    -------
    tuple of Path
        The files.

    Raises
    ------
    FileAccessError
        Another ending, a .toml for an arm from a URDF, or a place that cannot be written.
    MissingDataError
        The arm has no masses.
    """
    check_fitted_path(path, paper)
    target, values = Path(path), fitted_values(result)
    if ends_in(path, ".toml"):
        assert paper is not None
        write_file(target, fitted_paper_text(paper, values))
        return (target,)
    files = model_files(fitted_arm(result.arm, values), target.stem)
    write_folder(target.parent, files)
    return tuple(target.parent / name for name in files)
