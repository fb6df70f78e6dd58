"""`lwr-dyn new`: commented files to start from, each kind a row of `KINDS`."""

import os
import re
from importlib.resources import files
from pathlib import Path

import click

from lwr_dyn.arms.loading import load
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.cli.main import RegistryGroup
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import ends_in, write_file
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.studies.sweep.study_template import study_template

KINDS: Registry[click.Command] = Registry(
    "new",
    {
        "arm": Row("lwr_dyn.cli.new:arm", "A data file for your own arm."),
        "controller": Row("lwr_dyn.cli.new:controller", "A Python file for your own controller."),
        "cell": Row("lwr_dyn.cli.krl.options:new_cell", "What stands around a KRL program.", extra="krl"),
        "study": Row("lwr_dyn.cli.new:study", "A study of many closed loops."),
    },
)
"""What `lwr-dyn new` can write."""


@click.group("new", cls=RegistryGroup, registry=KINDS)
def command() -> None:
    """Write a commented file to start from; it runs as it stands."""


@click.command("arm")
@click.argument("file")
@click.option(
    "--joints", default="RRRRRR", show_default=True, help="R (turning) or P (sliding) per joint, base outward."
)
@click.option("--convention", default="standard", show_default=True, help="DH convention: standard or modified.")
def arm(file: str, joints: str, convention: str) -> None:
    """Write a data file for your own arm; every command takes it instead of a name."""
    path = new_file(file, ".toml")
    write_file(path, template(file, path.stem, joints.upper(), convention))
    click.echo(f"wrote {file}; next: fill it in, then  lwr-dyn check {file}")


@click.command("controller")
@click.argument("file")
def controller(file: str) -> None:
    """Write a Python file with a controller of your own; `simulate --controller` takes it instead of a name."""
    path = new_file(file, ".py")
    text = (files("lwr_dyn.cli") / "new_controller.txt").read_text(encoding="utf-8")
    write_file(path, text.replace("@@file@@", file))
    click.echo(f"wrote {file}; next: edit it, then  lwr-dyn simulate lwr4plus --controller {file}")


def new_file(file: str, ending: str) -> Path:
    """The path of a file to write; raises `FileAccessError` for another ending, an odd name, or a file that exists."""
    path = Path(file)
    if path.suffix != ending:
        raise FileAccessError(file, f"ends in {path.suffix or 'nothing'!r}", f"a path that ends in {ending}")
    if not re.fullmatch(r"[\w.-]+", path.stem):
        raise FileAccessError(file, "a name with other characters", "letters, digits, '.', '_' and '-'")
    if path.exists():
        raise FileAccessError(file, "exists already", "a new file")
    return path


@click.command("study")
@click.argument("file")
@click.argument("robot", required=False)
@click.option("--reading", help="How to read the tables of ROBOT; the paper's default if not given.")
def study(file: str, robot: str | None, reading: str | None) -> None:
    """Write a study: which loops, what varies, how many runs; `lwr-dyn sweep` runs it.

    For ROBOT: its task, its laws, its load and the steps of its friction fit it. For the LWR 4+ if none is given.
    """
    path = new_file(file, ".toml")
    if robot is None and reading is not None:
        raise OptionError("--reading", "would do nothing here", "with a robot behind FILE")
    arm = None if robot is None else load(robot, reading)
    write_file(path, study_template(file, path.stem, _named(robot, path), arm))
    click.echo(f"wrote {file}; next: edit it, then  lwr-dyn sweep {file} --out {path.stem}")


def _named(robot: str | None, study: Path) -> str | None:
    """How a study names its robot: a file by its path from the study's folder."""
    if robot is None or not Path(robot).is_file():
        return robot
    if not ends_in(robot, ".toml", ".urdf", ".xacro"):
        raise FileAccessError(robot, "no file that a study reads", "a .toml, .urdf or .xacro, or a robot's name")
    return os.path.relpath(robot, study.parent).replace(os.sep, "/")
