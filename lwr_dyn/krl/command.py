"""`lwr-dyn krl`: write KUKA programs from a task file, check them, and run them on a robot's model."""

import sys
from pathlib import Path
from typing import Any

import click
import numpy as np

from lwr_dyn.cli.help_text import NamedGroup
from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import check_writable
from lwr_dyn.front import load
from lwr_dyn.krl.controller import MachineData
from lwr_dyn.krl.diagnostics import has_no_error, summary
from lwr_dyn.krl.evaluate import input_values
from lwr_dyn.krl.point_program import generate_program, read_point_program
from lwr_dyn.krl.program import load_program
from lwr_dyn.krl.run import ProgramRun, check_program, run_program
from lwr_dyn.progress import progress
from lwr_dyn.tables import aligned

_SHARED_OPTIONS = (
    click.option("--robot", default="kr30ha", show_default=True, help="A robot with KUKA's axes."),
    click.option("--with", "included", multiple=True, help="A file to include: $config.dat, another .src."),
    click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="An input or variable: $IN[3]=TRUE."),
    click.option("--ramp", default=0.4, show_default=True, help="Assumed: seconds to rated speed."),
    click.option("--steps", default=200_000, show_default=True, help="Statements executed at most."),
    click.option("--seconds", default=3600.0, show_default=True, help="Simulated time at most."),
)


def _shared_options(command: Any) -> Any:
    for option in reversed(_SHARED_OPTIONS):
        command = option(command)
    return command


@click.group("krl", cls=NamedGroup)
def command() -> None:
    """KUKA Robot Language: write a program, check it, run it on a robot's model."""


@command.command("write")
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


@command.command("check")
@click.argument("file")
@_shared_options
@click.option("--no-motion", is_flag=True, help="Language and types only.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def check(file: str, robot: str, included: tuple[str, ...], settings: tuple[str, ...], ramp: float, steps: int,
          seconds: float, no_motion: bool, as_json: bool) -> None:  # fmt: skip
    """Diagnose FILE.src with the .dat beside it; exit 1 when there is an error."""
    program = load_program(file, included)
    machine = MachineData(ramp=ramp, steps=steps, seconds=seconds)
    with progress(f"checking {file}"):
        diagnostics = check_program(program, None if no_motion else load(robot), machine, input_values(settings))
    if as_json:
        print_json({"file": file, "holds": has_no_error(diagnostics), "diagnoses": [d.to_json() for d in diagnostics]})
    else:
        folder = Path(file).parent
        for diagnostic in diagnostics:  # a position that editors and terminals can open
            click.echo(f"{folder}/{diagnostic}" if folder != Path() else str(diagnostic))
        click.echo(f"{file}: {summary(diagnostics)}")
    sys.exit(0 if has_no_error(diagnostics) else 1)


@command.command("run")
@click.argument("file")
@_shared_options
@click.option("--out", help="The run file, .npz.")
@click.option("--html", help="A page that replays the run.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def run(file: str, robot: str, included: tuple[str, ...], settings: tuple[str, ...], ramp: float, steps: int,
        seconds: float, out: str | None, html: str | None, as_json: bool) -> None:  # fmt: skip
    """Run FILE.src on the model: cycle time, a line for each motion, peak speeds, static and dynamic torque."""
    for path, ending in ((out, ".npz"), (html, ".html")):
        if path is not None:
            if not path.endswith(ending):
                raise FileAccessError(path, f"does not end in {ending}", f"a path that ends in {ending}")
            check_writable(path)
    arm = load(robot)
    machine = MachineData(ramp=ramp, steps=steps, seconds=seconds)
    with progress(f"running {file}"):
        result = run_program(load_program(file, included), arm, machine, input_values(settings))
    if out is not None:
        result.to_run().save(out)
    if html is not None:
        from lwr_dyn.viewer.replay_page import write_replay

        write_replay(html, [result.to_run()], arm)
    if as_json:
        print_json(run_record(result))
    else:
        click.echo(run_text(result))
        for path in filter(None, (out, html)):
            click.echo(f"wrote {path}")
    sys.exit(0 if has_no_error(result.diagnostics) else 1)


def run_record(run: ProgramRun) -> dict[str, Any]:
    """A run as one JSON object."""
    rows = [
        {"line": x.position.line, "file": x.position.file, "motion": x.kind, "begin": x.begin, "end": x.end,
         "blend": x.overlap, "q_deg": np.degrees(x.q), "flange": [p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg],
         "s": p.s, "t": p.t}
        for x, p in zip(run.executed, run.poses(), strict=True)
    ]  # fmt: skip
    return {
        "program": run.program, "robot": run.arm.name, "cycle_time": run.cycle_time, "motions": rows,
        "peak_speed_deg": np.degrees(run.peak_speeds), "peak_static_torque": np.abs(run.static_torque).max(axis=0),
        "peak_torque": np.abs(run.torque).max(axis=0), "assumed": run.machine.to_json(),
        "diagnoses": [d.to_json() for d in run.diagnostics],
    }  # fmt: skip


def run_text(run: ProgramRun) -> str:
    """A run as text: its motions, axes and diagnostics."""
    rows = []
    for x, p in zip(run.executed, run.poses(), strict=True):
        pose = [f"{v:.3f}" for v in (p.x_mm, p.y_mm, p.z_mm)] + [f"{v + 0.0:.2f}" for v in (p.a_deg, p.b_deg, p.c_deg)]
        pose = ["0.00" if v == "-0.00" else v for v in pose]
        rows.append((str(x.position.line), x.kind, f"{x.begin:.3f}", f"{x.end:.3f}", *pose, f"S {p.s} T {p.t}"))
    head = ("line", "motion", "from s", "to s", "X mm", "Y mm", "Z mm", "A deg", "B deg", "C deg", "branch")
    arm, static, dynamic = run.arm, np.abs(run.static_torque).max(axis=0), np.abs(run.torque).max(axis=0)
    axes = [
        (name, f"{np.degrees(v):.1f}", f"{v / most:.0%}", f"{g:.1f}", f"{tau:.1f}")
        for name, v, most, g, tau in zip(arm.joint_names, run.peak_speeds, arm.velocity, static, dynamic, strict=True)
    ]
    assumed = f"assumed: {run.machine.ramp:g} s to rated speed; masses of {arm.name} as its data file has them"
    return "\n".join([
        f"{run.program} on {arm.name}: {run.cycle_time:.3f} s",
        aligned(rows, head),
        aligned(axes, ("axis", "peak deg/s", "of rated", "static N m", "dynamic N m")),
        assumed,
        *map(str, run.diagnostics),
    ])  # fmt: skip
