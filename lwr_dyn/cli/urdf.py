"""`lwr-dyn urdf`: the URDF on stdout, or into a file with its sidecars beside it."""

from pathlib import Path

import click

from lwr_dyn.cli.options import load_robot, robot_options
from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import check_writable, ends_in, write_folder
from lwr_dyn.front import urdf_text


@click.command("urdf")
@robot_options
@click.option("--out", help="A .urdf file; .srdf, .xml (MJCF) and .provenance.json are written beside it.")
def command(robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...], out: str | None) -> None:
    """Write ROBOT as URDF: on stdout, or with its sidecars to --out."""
    arm = load_robot(robot, reading, tip, locks)
    if out is None:
        click.echo(urdf_text(arm), nl=False)
        return
    from lwr_dyn.urdf.mjcf import weightless_links
    from lwr_dyn.urdf.model_files import model_files

    target = Path(out)
    if not ends_in(target, ".urdf"):
        raise FileAccessError(out, f"ends in {target.suffix or 'nothing'!r}", "a path that ends in .urdf")
    check_writable(target)
    files = model_files(arm, target.stem)
    write_folder(target.parent, files)
    for name in files:
        click.echo(f"wrote {target.parent / name}")
    bare = weightless_links(arm)
    if bare:
        click.echo(f"no {target.stem}.xml: MuJoCo refuses a moving link of mass 0, as {', '.join(bare)}")
