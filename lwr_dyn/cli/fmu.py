"""`lwr-dyn fmu`: an arm as a plant, or a control law at samples, as an FMU for other tools."""

from pathlib import Path

import click

from lwr_dyn.cli.options import Loading, OneOf, robot_options, say_caveats
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.codegen.kernels.kernel import require_packages
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file


@click.command("fmu")
@robot_options
@with_shared("--out", " FILE.fmu", required=True)
@with_shared("--law", " at samples; the arm as a plant if not given", form="NAME")
@with_shared("--rate", " of --law.")
@click.option("--fmi", type=OneOf(("2", "3")), default="3", show_default=True, help="Version of the standard.")
@click.option("--binary", is_flag=True, help="With a binary for this machine, by its C compiler; else sources alone.")
def command(
    robot: str, loading: Loading, out: str, law: str | None, rate: float | None, fmi: str, binary: bool
) -> None:
    """ROBOT as an FMU: the plant with torques as inputs, or with --law a controller. Needs no lwr_dyn to run."""
    if not ends_in(out, ".fmu"):
        raise OptionError("--out", repr(out), "a path that ends in .fmu")
    if rate is not None and law is None:
        raise OptionError("--rate", rate, "only with --law")
    check_writable(out)
    require_packages()
    from lwr_dyn.codegen.emit.fmu import RATE, controller_fmu, plant_fmu

    arm = loading.arm(robot)
    made = plant_fmu(arm, fmi) if law is None else controller_fmu(arm, law, fmi, RATE if rate is None else rate)
    write_file(Path(out), made.archive(binary))
    say_caveats()
    click.echo(f"wrote {out}: {made.name}, FMI {fmi}.0, {'with a binary' if binary else 'sources only'}")
