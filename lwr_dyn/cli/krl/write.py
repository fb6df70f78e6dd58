"""`lwr-dyn krl write`: a program from a task file of points, a run, or a table of poses or axes."""

import sys
from pathlib import Path
from typing import Any

import click
import numpy as np
from click.core import ParameterSource

from lwr_dyn.cli.help_text import ROBOT_OPTIONS
from lwr_dyn.cli.krl.options import ROBOT, arm_at_flange
from lwr_dyn.cli.options import NUMBERS, Loading, loading_options
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import check_writable, ends_in, write_files
from lwr_dyn.foundation.progress import progress
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.robot.kuka_pose import frame_matrix
from lwr_dyn.krl.robot.machine_data import raise_times
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.writing.motion_program import rounded
from lwr_dyn.krl.writing.path_fit import BLOCKS, USUAL, Tolerance
from lwr_dyn.krl.writing.path_program import WritingOptions, WrittenPath, write_path
from lwr_dyn.krl.writing.point_program import config_entries, generate_program, read_point_program
from lwr_dyn.krl.writing.sampled_path import read_sampled_path
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run

FRAME = "X,Y,Z,A,B,C"


@click.command("write")
@click.argument("source")
@click.option("--robot", help=f"With KUKA's axes.  [default: that of the run, {ROBOT}]")
@click.option(
    "--tolerance-mm",
    "tolerance",
    type=float,
    default=0.1,
    show_default=True,
    help="Largest distance from the path, mm.",
)
@click.option(
    "--angle-tolerance-deg",
    "angle_tolerance",
    type=float,
    default=0.1,
    show_default=True,
    help="Largest angle from the orientation, deg.",
)
@click.option("--motions", default=",".join(USUAL), show_default=True, help="Kinds it may use; SPL too, or SPTP alone.")
@click.option("--stop", is_flag=True, help="Stop at each point: no C_DIS, no C_PTP.")
@with_shared("--speed", " ($VEL.CP); that of the run if not given, 0.25 without times")
@click.option(
    "--percent", type=click.IntRange(1, 100), help="Percent of the axes' speeds, for PTP; that of the run if not given."
)
@click.option("--tool-data", "tool_data", type=NUMBERS, metavar=FRAME, help="The tool in the flange, mm and deg.")
@click.option("--tool-number", type=click.IntRange(1, 128), help="Use TOOL_DATA; its lines are printed.")
@click.option(
    "--base-data",
    "base_data",
    type=NUMBERS,
    metavar=FRAME,
    help="The base of written points and of poses that are read, mm and deg.",
)
@click.option("--base-number", type=click.IntRange(1, 128), help="Use BASE_DATA; its lines are printed.")
@loading_options
@with_shared("--out", " the .src, with the .dat beside it; the name of SOURCE if not given")
def write(source: str, robot: str | None, out: str | None, loading: Loading, **given: Any) -> None:
    """Write a .src and .dat from SOURCE; Status and Turn are the model's.

    SOURCE is a .toml of points; a run (.npz) of six axes; or a table (.csv) with a line of names: X, Y, Z, A, B, C in
    mm and deg, or A1 to A6 in deg, or q1 to q6 in rad, also time in s. A run or table is followed by LIN, CIRC and PTP
    within the tolerance, or SPL, SPTP; the program is run on the model and its path compared with SOURCE, exit 1 where
    it is farther off.
    """
    arm = _arm(source, robot, loading)
    if ends_in(source, ".toml"):
        _refuse_path_options()
        points = read_point_program(source, arm)
        target = _target(out, points.name)
        _save(generate_program(points, arm), target)
        click.echo(f"wrote {target} and {target.with_suffix('.dat')}; check it:  lwr-dyn krl check {target}")
        return
    target = _target(out, Path(out or source).stem)
    numbers = (given["tool_number"], given["base_number"])
    with progress(f"writing {target}"):
        written = _written(source, arm, target.stem, given)
    _save(written.written.program(*numbers), target)
    click.echo(_text(written, target, numbers))
    sys.exit(0 if written.holds else 1)


def _arm(source: str, robot: str | None, loading: Loading) -> Arm:
    """The robot that is given, else that of a run, else the usual; as `arm_at_flange`."""
    if robot is not None or not ends_in(source, ".npz"):
        return arm_at_flange(loading, robot or ROBOT, None)
    about = Run.load(source).meta
    return arm_at_flange(loading, str(about.get("file") or about.get("robot") or ROBOT), None)


def _written(source: str, arm: Arm, name: str, given: dict[str, Any]) -> WrittenPath:
    options = WritingOptions(
        name=name, tolerance=Tolerance(given["tolerance"] / 1e3, float(np.radians(given["angle_tolerance"]))),
        kinds=tuple(word.strip().upper() for word in given["motions"].split(",")), speed=given["speed"],
        percent=given["percent"], approximate=not given["stop"],
    )  # fmt: skip
    tool, base = (_frame(given[f"{name}_data"], f"--{name}-data") for name in ("tool", "base"))
    machine = MachineData(ramps=raise_times(arm))
    return write_path(read_sampled_path(source, arm, tool, base), options, base, machine)


def _frame(values: tuple[float, ...] | None, option: str) -> Array:
    if values is None:
        return np.eye(4)
    if len(values) != 6 or not np.isfinite(values).all():
        raise OptionError(option, ",".join(f"{x:g}" for x in values), "six numbers: X, Y, Z [mm], A, B, C [deg]")
    return frame_matrix(values)


def _refuse_path_options() -> None:
    context = click.get_current_context()
    for option in context.command.params:
        given = context.get_parameter_source(option.name or "") is ParameterSource.COMMANDLINE
        if given and option.name not in ("source", "out") and option.opts[0] not in ROBOT_OPTIONS:
            raise OptionError(option.opts[0], "given for a .toml of points", "none: the file has its own")


def _target(out: str | None, name: str) -> Path:
    target = Path(out or f"{name}.src")
    if target.suffix != ".src":
        raise FileAccessError(str(target), "not the name of a program", "a path that ends in .src")
    if target.stem != name:
        raise FileAccessError(str(target), "another name than the task's", f"a path that ends in {name}.src")
    check_writable(target)
    return target


def _save(program: Program, target: Path) -> None:
    files = {target: program.source.to_bytes()}
    if program.data is not None:
        files[target.with_suffix(".dat")] = program.data.to_bytes()
    write_files(files)


def _text(result: WrittenPath, target: Path, numbers: tuple[int | None, int | None]) -> str:
    written, samples, run = result.written, result.written.samples, result.run
    took = "" if samples.duration is None else f" in {samples.duration:.3f} s"
    counts = written.counts()
    away, allowed = (
        f"{1e3 * x.position:.3g} mm and {np.degrees(x.orientation):.3g} deg"
        for x in (result.deviation, result.tolerance)
    )
    lines = [
        f"{samples.source}: {len(samples.q)} points of the path{took}",
        f"{', '.join(f'{n} {kind}' for kind, n in counts.items())}; "
        f"{written.passed} of {sum(counts.values()) - 1} points are passed without a stop",
        f"run on {samples.arm.name}: {run.duration:.3f} s, its path within {away} of the samples "
        f"({'as allowed' if result.holds else 'NOT as allowed'}: {allowed})",
    ]
    for kind in set(counts) & set(BLOCKS):
        lines.append(f"between the points of {kind} a controller's path may be another: KUKA's curve is not published")
    for name, number, frame in zip(("TOOL", "BASE"), numbers, (samples.tool, written.base), strict=True):
        if number is not None:
            lines.append(f"in $config.dat:\n{config_entries(name, number, rounded(frame), target.stem)}")
    return "\n".join([*lines, f"wrote {target} and {target.with_suffix('.dat')}"])
