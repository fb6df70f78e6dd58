"""`lwr-dyn urdf`: the URDF on stdout, or into a file with its sidecars beside it."""

from collections.abc import Callable
from pathlib import Path

import click

from lwr_dyn.cli.options import load_robot, robot_options
from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import check_writable, write_file, write_folder
from lwr_dyn.front import urdf_text
from lwr_dyn.model.arm import Arm
from lwr_dyn.registry import Registry, Row

FORMATS: Registry[Callable[[Arm], str]] = Registry(
    "format",
    {
        ".srdf": Row("lwr_dyn.urdf.model_files:srdf_text", "rotors, for Pinocchio"),
        ".xml": Row("lwr_dyn.urdf.mjcf:mjcf_text", "MJCF, for MuJoCo and Drake"),
        ".toml": Row("lwr_dyn.export.data_file:data_file_text", "a data file with a DH table"),
    },
)
"""Ending of a file -> the arm's text in that format."""


@click.command("urdf")
@robot_options
@click.option(
    "--out", help="A .urdf, with .srdf, .xml (MJCF), .provenance.json beside it; or one .srdf, .xml or .toml."
)
def command(robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...], out: str | None) -> None:
    """Write ROBOT as URDF: on stdout, or with its sidecars to --out, whose ending decides on the format."""
    arm = load_robot(robot, reading, tip, locks)
    if out is None:
        click.echo(urdf_text(arm), nl=False)
        return
    from lwr_dyn.urdf.mjcf import weightless_links
    from lwr_dyn.urdf.model_files import model_files

    target = Path(out)
    ending = target.suffix.lower()
    if ending not in (".urdf", *FORMATS.names):
        allowed = f"a path that ends in .urdf, {', '.join(FORMATS.names)}"
        raise FileAccessError(out, f"ends in {target.suffix or 'nothing'!r}", allowed)
    check_writable(target)
    if ending != ".urdf":
        write_file(target, FORMATS.load(ending)(arm))
        click.echo(f"wrote {target}")
        return
    files = model_files(arm, target.stem)
    write_folder(target.parent, files)
    for name in files:
        click.echo(f"wrote {target.parent / name}")
    bare = weightless_links(arm)
    if bare:
        click.echo(f"no {target.stem}.xml: MuJoCo refuses a moving link of mass 0, as {', '.join(bare)}")
