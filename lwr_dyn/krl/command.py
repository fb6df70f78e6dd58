"""`lwr-dyn krl`: KUKA programs written from a task file, checked, and run on a robot's model."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click
import numpy as np

from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import check_writable
from lwr_dyn.front import load
from lwr_dyn.krl.check import check_program
from lwr_dyn.krl.diagnosis import holds, summary
from lwr_dyn.krl.given import given_values
from lwr_dyn.krl.job import job_program, read_job
from lwr_dyn.krl.program import load_program
from lwr_dyn.krl.run import ProgramRun, run_program
from lwr_dyn.krl.settings import Settings
from lwr_dyn.tables import aligned

_WORLD = (
    click.option("--robot", default="kr30ha", show_default=True, help="A robot with KUKA's axes."),
    click.option("--with", "lent", multiple=True, help="A file that lends names: $config.dat, another .src."),
    click.option("--set", "given", multiple=True, metavar="NAME=VALUE", help="An input or variable: $IN[3]=TRUE."),
    click.option("--ramp", default=0.4, show_default=True, help="Assumed: seconds to rated speed."),
    click.option("--steps", default=200_000, show_default=True, help="Statements carried out at most."),
    click.option("--seconds", default=3600.0, show_default=True, help="Simulated time at most."),
)


def _world(command: Any) -> Any:
    for option in reversed(_WORLD):
        command = option(command)
    return command


@click.group("krl")
def command() -> None:
    """KUKA Robot Language: write a program, check it, run it on a robot's model."""


@command.command("write")
@click.argument("task")
@click.option("--robot", default="kr30ha", show_default=True)
@click.option("--out", help="The .src; the .dat goes beside it. NAME.src of the task if not given.")
def write(task: str, robot: str, out: str | None) -> None:
    """Write a .src and .dat from TASK, a TOML file of points; Status and Turn are the model's."""
    arm = load(robot)
    job = read_job(task, arm)
    target = Path(out or f"{job.name}.src")
    if target.suffix != ".src" or target.stem != job.name:
        raise FileAccessError(str(target), "another name than the task's", f"a path that ends in {job.name}.src")
    program = job_program(job, arm)
    check_writable(target)
    program.source.save(target)
    if program.data is not None:
        program.data.save(target.with_suffix(".dat"))
    click.echo(f"wrote {target} and {target.with_suffix('.dat')}; check it:  lwr-dyn krl check {target}")


@command.command("check")
@click.argument("file")
@_world
@click.option("--no-motion", is_flag=True, help="Language and types only.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def check(file: str, robot: str, lent: tuple[str, ...], given: tuple[str, ...], ramp: float, steps: int,
          seconds: float, no_motion: bool, as_json: bool) -> None:  # fmt: skip
    """Diagnose FILE.src with the .dat beside it; exit 1 when there is an error."""
    program = load_program(file, lent)
    settings = Settings(ramp=ramp, steps=steps, seconds=seconds)
    found = check_program(program, None if no_motion else load(robot), settings, given_values(given))
    if as_json:
        print_json({"file": file, "holds": holds(found), "diagnoses": [d.to_json() for d in found]})
    else:
        folder = Path(file).parent
        for diagnosis in found:  # a place that editors and terminals can open
            click.echo(f"{folder}/{diagnosis}" if folder != Path() else str(diagnosis))
        click.echo(f"{file}: {summary(found)}")
    sys.exit(0 if holds(found) else 1)


@command.command("run")
@click.argument("file")
@_world
@click.option("--out", help="The run file, .npz.")
@click.option("--html", help="A page that replays the run.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def run(file: str, robot: str, lent: tuple[str, ...], given: tuple[str, ...], ramp: float, steps: int,
        seconds: float, out: str | None, html: str | None, as_json: bool) -> None:  # fmt: skip
    """Run FILE.src on the model: cycle time, a line for each motion, peak speeds, static and dynamic torque."""
    for path, ending in ((out, ".npz"), (html, ".html")):
        if path is not None:
            if not path.endswith(ending):
                raise FileAccessError(path, f"does not end in {ending}", f"a path that ends in {ending}")
            check_writable(path)
    arm = load(robot)
    done = run_program(
        load_program(file, lent), arm, Settings(ramp=ramp, steps=steps, seconds=seconds), given_values(given)
    )
    if out is not None:
        done.to_run().save(out)
    if html is not None:
        from lwr_dyn.viewer.replay_page import write_replay

        write_replay(html, [done.to_run()], arm)
    if as_json:
        print_json(run_record(done))
    else:
        click.echo(run_text(done))
        for path in filter(None, (out, html)):
            click.echo(f"wrote {path}")
    sys.exit(0 if holds(done.found) else 1)


def run_record(done: ProgramRun) -> dict[str, Any]:
    """A program's run for programs."""
    rows = [
        {"line": d.place.line, "file": d.place.file, "motion": d.kind, "begin": d.begin, "end": d.end,
         "blend": d.overlap, "q_deg": np.degrees(d.q), "flange": [p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg],
         "s": p.s, "t": p.t}
        for d, p in zip(done.done, done.poses(), strict=True)
    ]  # fmt: skip
    return {
        "program": done.program, "robot": done.arm.name, "cycle_time": done.cycle_time, "motions": rows,
        "peak_speed_deg": np.degrees(done.peak_speeds), "peak_static_torque": np.abs(done.static_torque).max(axis=0),
        "peak_torque": np.abs(done.torque).max(axis=0), "assumed": done.settings.to_json(),
        "diagnoses": [d.to_json() for d in done.found],
    }  # fmt: skip


def run_text(done: ProgramRun) -> str:
    """A program's run for people."""
    rows = []
    for d, p in zip(done.done, done.poses(), strict=True):
        place = [f"{x:.3f}" for x in (p.x_mm, p.y_mm, p.z_mm)] + [f"{x + 0.0:.2f}" for x in (p.a_deg, p.b_deg, p.c_deg)]
        place = ["0.00" if x == "-0.00" else x for x in place]
        rows.append((str(d.place.line), d.kind, f"{d.begin:.3f}", f"{d.end:.3f}", *place, f"S {p.s} T {p.t}"))
    head = ("line", "motion", "from s", "to s", "X mm", "Y mm", "Z mm", "A deg", "B deg", "C deg", "branch")
    arm, static, dynamic = done.arm, np.abs(done.static_torque).max(axis=0), np.abs(done.torque).max(axis=0)
    axes = [
        (name, f"{np.degrees(v):.1f}", f"{v / most:.0%}", f"{g:.1f}", f"{tau:.1f}")
        for name, v, most, g, tau in zip(arm.joint_names, done.peak_speeds, arm.velocity, static, dynamic, strict=True)
    ]
    assumed = f"assumed: {done.settings.ramp:g} s to rated speed; masses of {arm.name} as its data file has them"
    return "\n".join([
        f"{done.program} on {arm.name}: {done.cycle_time:.3f} s",
        aligned(rows, head),
        aligned(axes, ("axis", "peak deg/s", "of rated", "static N m", "dynamic N m")),
        assumed,
        *map(str, done.found),
    ])  # fmt: skip
