"""`lwr-dyn krl run`: cycle time, motions, speeds and torques of a program."""

import sys
from typing import Any

import click
import numpy as np

from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import check_writable
from lwr_dyn.front import load
from lwr_dyn.krl.command.options import shared_options
from lwr_dyn.krl.diagnostics import has_no_error
from lwr_dyn.krl.project.program import load_program
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.evaluate import input_values
from lwr_dyn.krl.running.run import ProgramRun, run_program
from lwr_dyn.progress import progress
from lwr_dyn.tables import aligned


@click.command("run")
@click.argument("file")
@shared_options
@click.option("--out", help="The run file, .npz.")
@click.option("--html", help="A page that replays the run beside the program.")
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
        program = load_program(file, included)
        result = run_program(program, arm, machine, input_values(settings))
    if out is not None:
        result.to_run().save(out)
    if html is not None:
        from lwr_dyn.krl.page.program_page import write_program_page

        write_program_page(html, result, program)
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
        "program": run.program, "robot": run.arm.name, "cycle_time": run.cycle_time,
        "cycle_times": run.times().to_json(), "motions": rows,
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
        *run.times().lines(),
        *map(str, run.diagnostics),
    ])  # fmt: skip
