"""Data files: the robots that come with the package, by name, and the template of a user's own arm."""

import json
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from string import Template

from lwr_dyn.arms.papers.reader import parse_paper, parse_readings
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.foundation.files import ends_in, read_text


def robots() -> tuple[str, ...]:
    """Names of the robots that come with the package.

    >>> "lwr4plus" in robots()
    True
    """
    return tuple(sorted((*studied(), *published())))


def studied() -> tuple[str, ...]:
    """Names of the robots of papers whose printed results are recomputed.

    >>> studied()
    ('kr30ha', 'lwr4', 'lwr4plus', 'wam7')
    """
    return _names()


def published() -> tuple[str, ...]:
    """Names of the robots that come with the sets of numbers that others publish of them.

    >>> "panda" in published()
    True
    """
    return _names(PUBLISHED)


PUBLISHED = "published"
"""The folder of the data files of `published`."""


def _names(*folder: str) -> tuple[str, ...]:
    files = resources.files("lwr_dyn.arms.papers").joinpath(*folder).iterdir()
    return tuple(sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml")))


def open_paper(robot: str, reading: str | None = None) -> Paper:
    """The paper of a robot by name, or of a user's own `.toml` file.

    Raises `UnknownNameError`, with the known names, for a robot or a reading, `FileAccessError` for a file that cannot
    be read, `PaperError` for one that breaks the schema.
    """
    return parse_paper(*_text_and_file(robot), reading)


def open_readings(robot: str) -> tuple[Paper, ...]:
    """The paper of a robot under each of its readings, the default first, parsed once; raises as `open_paper`."""
    return parse_readings(*_text_and_file(robot))


def readings(robot: str) -> tuple[str, ...]:
    """Names of the readings of a robot, its default first; raises as `open_paper`.

    >>> readings("lwr4plus")
    ('physical', 'printed', 'computed')
    """
    return open_paper(robot).reading_names


def _text_and_file(robot: str) -> tuple[str, str]:
    if ends_in(robot, ".toml"):
        return read_text(robot, "a readable .toml file"), Path(robot).name
    if robot not in robots():
        raise UnknownNameError(
            "robot", robot, (*robots(), "a path to a .toml, .urdf, .xml (MJCF), .kuka.toml or $machine.dat")
        )
    return _data_file(robot).read_text(encoding="utf-8"), f"{robot}.toml"


def _data_file(robot: str) -> Traversable:
    folder = (PUBLISHED,) if robot in published() else ()
    return resources.files("lwr_dyn.arms.papers").joinpath(*folder, f"{robot}.toml")


def template(file: str, name: str, joints: str = "RRRRRR", convention: str = "standard") -> str:
    """The commented data file of a new arm; it is valid as it is.

    `file` is its path, for the comment, `joints` R or P per joint from the base outward, `convention` "standard" or
    "modified". Raises `OptionError` for other letters or another convention.

    >>> 'kinds = ["revolute", "prismatic"]' in template("x.toml", "x", "RP")
    True
    """
    if not joints or set(joints) - set("RP"):
        raise OptionError("joints", repr(joints), "R or P per joint, such as RRRRRR or RRP")
    if convention not in ("standard", "modified"):
        raise OptionError("convention", repr(convention), "standard, modified")
    n = len(joints)

    def column(revolute: object, prismatic: object | None = None) -> str:
        values = {"R": revolute, "P": revolute if prismatic is None else prismatic}
        return json.dumps([values[letter] for letter in joints])

    def unit(revolute: str, prismatic: str) -> str:
        return column(revolute, prismatic) if "P" in joints else json.dumps(revolute)

    return Template(_packaged_text("templates/arm.toml")).substitute(
        file=file, name=name, convention=convention, kinds=column("revolute", "prismatic"),
        alpha=json.dumps([(90, -90)[i % 2] if i < n - 1 else 0 for i in range(n)]),
        d=json.dumps([(0.3, 0)[i % 2] for i in range(n)]), zeros=column(0), ones=column(1),
        lower=column(-170, 0), upper=column(170, 0.5), velocity=column(120, 0.5), effort=column(100),
        angle=unit("deg", "m"), speed=unit("deg/s", "m/s"), force=unit("N m", "N"),
        mass=column(2.0), com=column([0, 0, -0.05]), inertia="    [[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.004]],\n" * n,
    )  # fmt: skip


def _packaged_text(file: str) -> str:
    return resources.files("lwr_dyn.arms.papers").joinpath(file).read_text(encoding="utf-8")


def data_files(robot: str) -> dict[str, str]:
    """Name -> text of the TOML files about a robot in this package: its data file, then those in folders of its name.

    Raises `UnknownNameError` for a robot that does not come with the package.

    >>> list(data_files("lwr4"))
    ['lwr4.toml', 'lwr4/results.toml']
    """
    if robot not in robots():
        raise UnknownNameError("robot", robot, robots())
    package = resources.files("lwr_dyn")
    folders = [place for place in (part.joinpath(robot) for part in package.iterdir()) if place.is_dir()]
    beside = {f"{robot}/{f.name}": f for place in folders for f in place.iterdir() if f.name.endswith(".toml")}
    files = {f"{robot}.toml": _data_file(robot), **dict(sorted(beside.items()))}
    return {name: file.read_text(encoding="utf-8") for name, file in files.items()}
