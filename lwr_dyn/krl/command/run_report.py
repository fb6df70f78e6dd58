"""What `lwr-dyn krl run` tells: as text and as one JSON object."""

from typing import Any

import numpy as np

from lwr_dyn.krl.running.run import ProgramRun
from lwr_dyn.tables import aligned


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
        "assumptions": [x.to_json() for x in run.assumptions],
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
        *(f"assumed: {x}" for x in run.assumptions),
        *map(str, run.diagnostics),
    ])  # fmt: skip
