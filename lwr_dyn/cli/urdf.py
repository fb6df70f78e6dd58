"""`lwr-dyn urdf`: the URDF on stdout, or into a file with its sidecars beside it."""

from pathlib import Path

import click

from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.cli.options import Loading, robot_options, say_caveats
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, write_file, write_folder


@click.command("urdf")
@robot_options
@with_shared("--out", " a .urdf, with .srdf, .xml (MJCF), .provenance.json beside it; or one .srdf, .xml or .toml")
def command(robot: str, loading: Loading, out: str | None) -> None:
    """Write ROBOT as URDF: on stdout, or with its sidecars to --out, whose ending decides on the format."""
    arm = loading.arm(robot)
    if out is None:
        click.echo(urdf_text(arm), nl=False)
        return
    from lwr_dyn.arms.urdf.model_files import FORMATS, model_files, weightless_links

    target = Path(out)
    ending = target.suffix.lower()
    if ending not in (".urdf", *FORMATS.names):
        allowed = f"a path that ends in .urdf, {', '.join(FORMATS.names)}"
        raise FileAccessError(out, f"ends in {target.suffix or 'nothing'!r}", allowed)
    check_writable(target)
    if ending != ".urdf":
        write_file(target, FORMATS.load(ending)(arm))
        say_caveats()
        click.echo(f"wrote {target}")
        return
    files = model_files(arm, target.stem)
    say_caveats()
    write_folder(target.parent, files)
    for name in files:
        click.echo(f"wrote {target.parent / name}")
    bare = weightless_links(arm)
    if bare and f"{target.stem}.xml" not in files:
        click.echo(f"no {target.stem}.xml: MuJoCo refuses a moving link without mass, as {', '.join(bare)}")
