"""`lwr-dyn krl run`: cycle time, motions, speeds and torques of a program, as text and as one JSON object."""

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from typing import Annotated, NotRequired, TypedDict

import click
import numpy as np

from lwr_dyn.cli.krl.options import SharedOptions, shared_options
from lwr_dyn.cli.options import show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Fact, Note, Part, Section
from lwr_dyn.foundation.files import check_writable
from lwr_dyn.foundation.progress import progress
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.krl.diagnostics import DiagnosticRecord, has_no_error
from lwr_dyn.krl.motion.cycle_times import CycleTimes
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramError, ProgramRun, run_program


class MachineDataRecord(TypedDict):
    """`MachineData.to_json`."""

    ramp: Annotated[float, "[s] From rest to rated speed of each axis at 100 % of $ACC_AXIS."]
    ramps: NotRequired[Annotated[list[float], "[s] The same axis by axis, of the robot's machine data ($RAISE_TIME)."]]
    vel_cp: Annotated[float, "[m/s] $VEL.CP after BAS(#INITMOV, 0)."]
    acc_cp: Annotated[float, "[m/s^2] $ACC.CP."]
    vel_ori: Annotated[float, "[deg/s] $VEL.ORI1 and ORI2."]
    acc_ori: Annotated[float, "[deg/s^2] $ACC.ORI1 and ORI2."]
    steps: Annotated[int, "Most statements that are executed."]
    seconds: Annotated[float, "Longest simulated time."]
    motions: Annotated[int, "Most motions."]
    passes: Annotated[int, "Most passes of a LOOP without a way out."]


class PassesRecord(TypedDict):
    """`LoopPasses` with the times of a pass."""

    file: str
    line: Annotated[int, "In which the loop ends."]
    cycle_time: Annotated[float, "[s] Of one pass, the mean of those that are counted."]
    seconds: Annotated[list[float], "Of each pass after the first."]
    period: Annotated[int, "How many passes repeat for ever; 0 where the state did not come back."]
    cycle_times: Annotated[CycleTimes, "[s] Of one pass by three laws of look-ahead."]


class RampRecord(TypedDict):
    """What another time to rated speed makes of the run."""

    ramp: Annotated[float, "[s] From rest to rated speed."]
    duration: Annotated[float | None, "[s] Of the run with it; null where it cannot be run."]


def run_document(run: ProgramRun, flange: bool = False, others: Sequence[RampRecord] = ()) -> Document:
    """A run: its motions, axes, what it assumes and diagnoses; poses of the tool in the base, or of the flange."""
    times, pass_times = run.times(), run.pass_times()
    passes = None
    if run.passes is not None and pass_times is not None:
        x = run.passes
        passes = {
            "file": x.position.file, "line": x.position.line, "cycle_time": x.cycle_time, "seconds": list(x.seconds),
            "period": x.period, "cycle_times": asdict(pass_times),
        }  # fmt: skip
    parts: list[Part] = [
        Fact("program", run.program, "Its name."),
        Fact("robot", run.arm.name, "Its name."),
        Fact("duration", run.duration, "[s] Of all that was simulated."),
        Fact("cycle_time", run.cycle_time, "[s] Of a pass of the endless loop at which the run ended, else of the "
             "whole program; null where the run is cut.", kind=float),
        Fact("cycle_times", asdict(times), "Of the whole run, by three laws of look-ahead; `duration` is by the "
             "first.", kind=CycleTimes),
        _motions(run, flange),
        Note(POSES[flange]),
        Note([] if run.passes is None else str(run.passes)),
        _axes(run),
        Note(_assumed(run, others)),
        Fact("other_ramps", list(others), "The run with other times to rated speed, where that time is assumed.",
             kind=list[RampRecord]),
        Note(times.lines()),
        Note([] if pass_times is None else pass_times.lines(" of a pass")),
        Fact("assumed", run.machine.to_json(), "Machine data that are not published, and bounds of the run.",
             kind=MachineDataRecord),
        Note([str(x) for x in run.assumptions], before="assumed: "),
        Table("", [Heading(key="name", says="Of the variable or the rule."),
                   Heading(key="value", says="Empty for a rule."), Heading(key="why", says="Where it comes from.")],
              [(x.name, x.value, x.why) for x in run.assumptions], key="assumptions",
              says="Values and rules that neither the program nor its files give."),
        Table("", [Heading(key="time", says="[s]"), Heading(key="file"), Heading(key="line"),
                   Heading(key="kind", says="output, trigger, interrupt, reply or halt."), Heading(key="text")],
              [(x.time, x.position.file, x.position.line, x.kind, x.text) for x in run.events], key="events",
              says="Outputs, triggers, interrupts and answers of the cell, in order of time."),
        Fact("passes", passes, "Of the endless loop at which the run ended; null without one.",
             kind=PassesRecord | None),
        Note([str(x) for x in run.diagnostics]),
        Fact("diagnoses", [d.to_json() for d in run.diagnostics], "Warnings and notes of the run, errors that it "
             "did not come to, axes over their speed.", kind=list[DiagnosticRecord]),
    ]  # fmt: skip
    took = f"{run.duration:.3f} s" + (" simulated" if run.passes else "")
    if run.cut is not None:
        took = f"cut after {run.duration:.3f} s, so no cycle time; rows that end later are planned only"
    return Document("", f"{run.program} on {run.arm.name}: {took}", [Section("", parts)], "lwr-dyn krl run")


POSES = (
    "X to C: the tool centre point in the active base at the end of the motion (--flange: the flange in the world)",
    "X to C: the flange in the world at the end of the motion",
)
"""What the poses of the table are, without and with `--flange`."""


def _motions(run: ProgramRun, flange: bool) -> Table:
    """A row for each motion, with the pose at its end."""
    headings = [
        Heading("line", key="line"), Heading(key="file"), Heading("motion", key="motion", says="Its keyword."),
        Heading("from s", format=".3f", key="begin", says="[s]"), Heading("to s", format=".3f", key="end", says="[s]"),
        Heading(key="blend", says="[s] Of it that overlaps with the motion before."),
        Heading(key="q_deg", says="[deg] The joints at its end."),
        Heading(key="tcp", says="X, Y, Z [mm], A, B, C [deg] of the tool centre point at its end, in the active base."),
        Heading(key="flange", says="X, Y, Z [mm], A, B, C [deg] of the flange at its end, in the world."),
        *(Heading(f"{x} mm", format="z.3f", key=None) for x in "XYZ"),
        *(Heading(f"{x} deg", format="z.2f", key=None) for x in "ABC"),
        Heading("branch", key=None), Heading(key="s", says="Status."), Heading(key="t", says="Turn."),
    ]  # fmt: skip
    rows = []
    for x, *poses in zip(run.executed, run.tcp_poses(), run.poses(), strict=True):
        both = [[p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg] for p in poses]
        place, (s, t) = (x.position.line, x.position.file), (poses[0].s, poses[0].t)
        rows.append((
            *place, x.kind, x.begin, x.end, x.overlap, np.degrees(x.q), *both, *both[flange], f"S {s} T {t}", s, t,
        ))  # fmt: skip
    return Table("", headings, rows, key="motions", says="In the order in which they are executed.")


def _axes(run: ProgramRun) -> Table:
    """Peak speeds and torques of the axes."""
    arm, torque = run.arm, Heading(format=lambda x: "-" if np.isnan(x) else f"{x:.1f}", kind=list[float])
    headings = [
        Heading("axis", key=None),
        Heading("peak deg/s", format=".1f", key="peak_speed_deg", says="[deg/s] The largest speed of each axis."),
        Heading("of rated", format=".0%", key=None),
        replace(torque, head="static N m", key="peak_static_torque", says="[N m] The largest that holds the arm."),
        replace(torque, head="dynamic N m", key="peak_torque", says="[N m] The largest of the motion."),
    ]
    known = (run.static_torque, run.torque)
    torques = [np.full(arm.n, np.nan) if x is None else np.abs(x).max(axis=0) for x in known]
    speeds = run.peak_speeds
    rows = zip(arm.joint_names, np.degrees(speeds), speeds / arm.velocity, *torques, strict=True)
    return Table("", headings, [*rows], columnwise=True)


RAMPS = (0.1, 0.2)
"""[s] To rated speed of small and of middle robots, for which a run is timed beside the assumed one."""


def _other_ramps(run: ProgramRun, timed: Callable[[MachineData], ProgramRun]) -> Iterator[RampRecord]:
    """The durations with other assumptions; `timed` runs the program again."""
    for ramp in RAMPS:
        try:
            yield {"ramp": ramp, "duration": timed(replace(run.machine, ramp=ramp)).duration}
        except ProgramError:  # a faster axis may not be able to follow a path
            yield {"ramp": ramp, "duration": None}


def _assumed(run: ProgramRun, others: Sequence[RampRecord]) -> str:
    ramps = ", ".join(f"{x:g}" for x in run.machine.ramps or (run.machine.ramp,))
    source = "$RAISE_TIME of its machine data" if run.machine.ramps else "assumed"
    timed = ", ".join("-" if (x := each["duration"]) is None else f"{x:.3f} s with {each['ramp']:g}" for each in others)
    ramps += f" s to rated speed ({timed})" if others else " s to rated speed"
    masses = "; masses unknown, so no torques" if run.torque is None else ""
    return f"{source}: {ramps}{masses}"


@click.command("run")
@click.argument("file")
@shared_options
@click.option("--flange", is_flag=True, help="Show the flange in the world, not the tool in the active base.")
@with_shared("--out", " the run file, .npz")
@with_shared("--html", ": the replay of the run beside the program")
@with_shared("--json as_json")
def run(file: str, shared: SharedOptions, flange: bool, out: str | None, html: str | None, as_json: bool) -> None:
    """Run FILE.src on the model: cycle time, a line for each motion, peak speeds, static and dynamic torque."""
    for path, ending in ((out, ".npz"), (html, ".html")):
        if path is not None:
            check_writable(path, ending)
    program = shared.program(file)
    arm = shared.arm(program)
    with progress(f"running {file}"):
        result = run_program(program, arm, shared.machine(arm), shared.inputs, shared.cell)
        others: list[RampRecord] = []
        if shared.ramp is None and not result.machine.ramps:
            others += _other_ramps(result, lambda data: run_program(program, arm, data, shared.inputs, shared.cell))
    if out is not None:
        result.to_run().save(out)
    if html is not None:
        from lwr_dyn.krl.page import write_program_page

        write_program_page(html, result, program)
    show(run_document(result, flange, others), as_json, filter(None, (out, html)))
    sys.exit(0 if has_no_error(result.diagnostics) else 1)
