"""The options that `krl check` and `krl run` share; `lwr-dyn new cell`, a commented cell file to start from."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, fields, replace
from functools import cached_property, wraps
from pathlib import Path
from typing import Any

import click

from lwr_dyn.cli.new import new_file
from lwr_dyn.cli.options import Loading, loading_options
from lwr_dyn.foundation.files import write_file
from lwr_dyn.krl.names.known_names import known_names
from lwr_dyn.krl.project.program import Program, load_program
from lwr_dyn.krl.robot.machine_data import raise_times
from lwr_dyn.krl.running.cell import RobotCell, input_values, new_cell_text, read_cell, with_cell
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.values import Value
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.caveats import DYNAMICS

ROBOT = "kr30ha"

SHARED_OPTIONS = (
    click.option("--robot", help=f"With KUKA's axes.  [default: the cell's, $machine.dat of the files, {ROBOT}]"),
    click.option("--cell", "cell_file", help="A cell file: inputs, states, tools, stubs; lwr-dyn new cell writes one."),
    click.option("--names", multiple=True, help="A file of names that options bring, like krl/names/options.toml."),
    click.option("--with", "included", multiple=True, help="A file to include: $config.dat, another .src."),
    click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="An input or variable: $IN[3]=TRUE."),
    click.option("--ramp", type=float, help="Seconds to rated speed.  [default: those of $machine.dat, 0.4 assumed]"),
    click.option("--steps", default=200_000, show_default=True, help="Statements executed at most."),
    click.option("--seconds", default=3600.0, show_default=True, help="Simulated time at most."),
)


def arm_at_flange(loading: Loading, robot: str, used: Collection[str] | None = DYNAMICS) -> Arm:
    """A robot from its base to its flange, on which the frames of a program stand ($WORLD, $TOOL).

    Of --tool the mass counts, and of --mount the direction of gravity. Raises as `lwr_dyn.load`.
    """
    arm = loading.arm(robot, used)
    place, there = arm.uninstalled(), arm.installation
    if there is None or there.mount is None:
        return place
    return replace(place, chain=replace(place.chain, gravity=there.mount.rotation.T @ arm.chain.gravity))


@dataclass(frozen=True)
class SharedOptions:
    """The options as given; a property for what they stand for, which raises where one is wrong."""

    loading: Loading
    robot: str | None
    cell_file: str | None
    names: tuple[str, ...]
    included: tuple[str, ...]
    settings: tuple[str, ...]
    ramp: float | None
    steps: int
    seconds: float

    @cached_property
    def cell(self) -> RobotCell:
        """That of `--cell`, else an empty one."""
        return RobotCell() if self.cell_file is None else read_cell(self.cell_file)

    def arm(self, program: Program, used: Collection[str] | None = DYNAMICS) -> Arm:
        """The robot of `--robot`, else of the cell, else of the machine data of the program's files, else the usual.

        As `arm_at_flange`.
        """
        data = program.project.nearest(program.module, "$machine.dat")
        return arm_at_flange(self.loading, str(self.robot or self.cell.robot or data or ROBOT), used)

    @property
    def names_robot(self) -> bool:
        """Whether `--robot` or the cell names the robot; else it is that of the program's files."""
        return bool(self.robot or self.cell.robot)

    def machine(self, arm: Arm) -> MachineData:
        """Assumed machine data and bounds; without `--ramp` the seconds to rated speed of the arm's machine data."""
        data = MachineData(steps=self.steps, seconds=self.seconds)
        return replace(data, ramps=raise_times(arm)) if self.ramp is None else replace(data, ramp=self.ramp)

    @property
    def inputs(self) -> dict[str, Value]:
        """Of `--set`."""
        return input_values(self.settings)

    def program(self, file: str | Path) -> Program:
        """The program with the files of `--with` and the names of the cell."""
        program = load_program(file, self.included)
        if self.names:
            program = replace(program, project=program.project.with_known(known_names(self.names)))
        return with_cell(program, self.cell)


def shared_options(command: Callable[..., None]) -> Any:
    """Add them to a subcommand, which takes them as one `shared`."""

    @wraps(command)
    def with_shared(**given: Any) -> None:
        taken = {f.name: given.pop(f.name) for f in fields(SharedOptions)}
        command(shared=SharedOptions(**taken), **given)

    out: Any = loading_options(with_shared)
    for option in reversed(SHARED_OPTIONS):
        out = option(out)
    return out


@click.command("cell")
@click.argument("file")
def new_cell(file: str) -> None:
    """Write a cell file: the robot, inputs, states, tools, stubs; `krl check` and `krl run` take it with --cell."""
    path = new_file(file, ".toml")
    write_file(path, new_cell_text(file))
    click.echo(f"wrote {file}; next: edit it, then  lwr-dyn krl run PROGRAM.src --cell {file}")
