"""`lwr-dyn new`: a commented data file for a user's own arm."""

from __future__ import annotations

import re
from pathlib import Path

import click

from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import write_file
from lwr_dyn.papers.template import template


@click.command("new")
@click.argument("file")
@click.option(
    "--joints", default="RRRRRR", show_default=True, help="R (turning) or P (sliding) per joint, base outward."
)
@click.option("--convention", default="standard", show_default=True, help="DH convention: standard or modified.")
def command(file: str, joints: str, convention: str) -> None:
    """Write a commented data file for your own arm; every command takes it instead of a name."""
    path = Path(file)
    if path.suffix != ".toml":
        raise FileAccessError(file, f"ends in {path.suffix or 'nothing'!r}", "a path that ends in .toml")
    if not re.fullmatch(r"[\w.-]+", path.stem):
        raise FileAccessError(file, "a name with other characters", "letters, digits, '.', '_' and '-'")
    if path.exists():
        raise FileAccessError(file, "exists already", "a new file")
    write_file(path, template(file, path.stem, joints.upper(), convention))
    click.echo(f"wrote {file}; next: fill it in, then  lwr-dyn check {file}")
