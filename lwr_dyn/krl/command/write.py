"""`lwr-dyn krl write`: a program from a task file of points."""

from pathlib import Path

import click

from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import check_writable
from lwr_dyn.front import load
from lwr_dyn.krl.writing.point_program import generate_program, read_point_program


@click.command("write")
@click.argument("task")
@click.option("--robot", default="kr30ha", show_default=True)
@click.option("--out", help="The .src; the .dat goes beside it. NAME.src of the task if not given.")
def write(task: str, robot: str, out: str | None) -> None:
    """Write a .src and .dat from TASK, a TOML file of points; Status and Turn are the model's."""
    arm = load(robot)
    points = read_point_program(task, arm)
    target = Path(out or f"{points.name}.src")
    if target.suffix != ".src" or target.stem != points.name:
        raise FileAccessError(str(target), "another name than the task's", f"a path that ends in {points.name}.src")
    program = generate_program(points, arm)
    check_writable(target)
    program.source.save(target)
    if program.data is not None:
        program.data.save(target.with_suffix(".dat"))
    click.echo(f"wrote {target} and {target.with_suffix('.dat')}; check it:  lwr-dyn krl check {target}")
