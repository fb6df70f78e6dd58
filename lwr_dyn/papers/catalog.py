"""The robots that come with the package: one TOML file per paper or data sheet, found by name."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from lwr_dyn.errors import UnknownNameError
from lwr_dyn.papers.reader import parse_paper, read_paper
from lwr_dyn.papers.schema import Paper


def robots() -> tuple[str, ...]:
    """Names of the robots in the data room.

    >>> "lwr4plus" in robots()
    True
    """
    room = resources.files("lwr_dyn.papers")
    return tuple(sorted(f.name.removesuffix(".toml") for f in room.iterdir() if f.name.endswith(".toml")))


def open_paper(robot: str, reading: str | None = None) -> Paper:
    """The paper of a robot by name, or of a user's own `.toml` file.

    Raises
    ------
    UnknownNameError
        No robot or no reading of that name; says which there are.
    FileAccessError, PaperError
        See `read_paper`.
    """
    if robot.endswith(".toml"):
        return read_paper(Path(robot), reading)
    if robot not in robots():
        raise UnknownNameError("robot", robot, (*robots(), "a path to a .toml or .urdf file"))
    text = resources.files("lwr_dyn.papers").joinpath(f"{robot}.toml").read_text(encoding="utf-8")
    return parse_paper(text, f"{robot}.toml", reading)


def readings(robot: str) -> tuple[str, ...]:
    """Names of the readings of a robot, its default first.

    >>> readings("lwr4plus")
    ('computed', 'printed', 'physical')
    """
    paper = open_paper(robot)
    return (paper.reading.name, *(r for r in paper.readings if r != paper.reading.name))
