"""`lwr-dyn krl run`: cycle time, motions, speeds and torques of a program, as text and as one JSON object."""

import sys
from typing import Any

import click
import numpy as np

from lwr_dyn.cli.krl.options import SharedOptions, shared_options
from lwr_dyn.cli.options import print_json
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable
from lwr_dyn.foundation.progress import progress
from lwr_dyn.foundation.tables import aligned
from lwr_dyn.krl.diagnostics import has_no_error
from lwr_dyn.krl.running.program_run import ProgramRun, run_program


def run_record(run: ProgramRun) -> dict[str, Any]:
    """A run as one JSON object."""
    rows = [
        {"line": x.position.line, "file": x.position.file, "motion": x.kind, "begin": x.begin, "end": x.end,
         "blend": x.overlap, "q_deg": np.degrees(x.q), "flange": [p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg],
         "s": p.s, "t": p.t}
        for x, p in zip(run.executed, run.poses(), strict=True)
    ]  # fmt: skip
    return {
        "program": run.program, "robot": run.arm.name, "duration": run.duration, "cycle_time": run.cycle_time,
        "cycle_times": run.times().to_json(), "motions": rows,
        "peak_speed_deg": np.degrees(run.peak_speeds), "peak_static_torque": _peaks(run, run.static_torque),
        "peak_torque": _peaks(run, run.torque), "assumed": run.machine.to_json(),
        "assumptions": [x.to_json() for x in run.assumptions],
        "events": [x.to_json() for x in run.events],
        "passes": _passes(run),
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
    arm, peaks = run.arm, [_peaks(run, x) for x in (run.static_torque, run.torque)]
    axes = [
        (name, f"{np.degrees(v):.1f}", f"{v / most:.0%}", *("-" if np.isnan(x) else f"{x:.1f}" for x in of_axis))
        for name, v, most, *of_axis in zip(arm.joint_names, run.peak_speeds, arm.velocity, *peaks, strict=True)
    ]
    ramps = ", ".join(f"{x:g}" for x in run.machine.ramps or (run.machine.ramp,))
    source = "$RAISE_TIME of its machine data" if run.machine.ramps else "assumed"
    masses = (
        "masses unknown, so no torques" if run.torque is None else f"masses of {arm.name} as its data file has them"
    )
    assumed = f"{source}: {ramps} s to rated speed; {masses}"
    return "\n".join([
        f"{run.program} on {arm.name}: {_headline(run)}",
        aligned(rows, head),
        *([] if run.passes is None else [str(run.passes)]),
        aligned(axes, ("axis", "peak deg/s", "of rated", "static N m", "dynamic N m")),
        assumed,
        *run.times().lines(),
        *([] if (times := run.pass_times()) is None else times.lines(" of a pass")),
        *(f"assumed: {x}" for x in run.assumptions),
        *map(str, run.diagnostics),
    ])  # fmt: skip


def _passes(run: ProgramRun) -> dict[str, Any] | None:
    times = run.pass_times()
    return None if run.passes is None or times is None else {**run.passes.to_json(), "cycle_times": times.to_json()}


def _headline(run: ProgramRun) -> str:
    if run.cut is not None:
        return f"cut after {run.duration:.3f} s, so no cycle time; rows that end later are planned only"
    return f"{run.duration:.3f} s" + (" simulated" if run.passes else "")


def _peaks(run: ProgramRun, torque: Array | None) -> Array:
    """The largest of each axis (n,) [N m]; NaN where it is unknown."""
    return np.full(run.arm.n, np.nan) if torque is None else np.asarray(np.abs(torque).max(axis=0))


@click.command("run")
@click.argument("file")
@shared_options
@click.option("--out", help="The run file, .npz.")
@click.option("--html", help="A page that replays the run beside the program.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def run(file: str, shared: SharedOptions, out: str | None, html: str | None, as_json: bool) -> None:
    """Run FILE.src on the model: cycle time, a line for each motion, peak speeds, static and dynamic torque."""
    for path, ending in ((out, ".npz"), (html, ".html")):
        if path is not None:
            if not path.endswith(ending):
                raise FileAccessError(path, f"does not end in {ending}", f"a path that ends in {ending}")
            check_writable(path)
    program = shared.program(file)
    arm = shared.arm(program)
    with progress(f"running {file}"):
        result = run_program(program, arm, shared.machine(arm), shared.inputs, shared.cell)
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
