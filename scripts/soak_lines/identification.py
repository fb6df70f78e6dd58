"""What logs of simulated arms give back, and what a long log costs."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import lwr_dyn
from soak_lines.command import command


def coverage() -> tuple[str, bool]:
    """3-sigma intervals of the WAM's friction over 200 noise draws on one simulated set of logs."""
    from lwr_dyn.control.paper_laws import PDGravity
    from lwr_dyn.identification.logs.simulated_logs import LogSensors, cruise_logs
    from tests.identification.simulated import interval_coverage

    arm = lwr_dyn.load("wam7")
    Kd = np.array(arm.gains.Kd)
    Kd[3] = 8.0  # with the maker's 2 joint 4 has no net damping and no cruise
    controller = PDGravity(lwr_dyn.dynamics_of(arm), arm.gains.Kp, Kd, velocity_error=True)
    start, speeds = np.array([0.0, -1.5, 0.0, 1.6, 0.0, 0.0, 0.0]), (0.06, 0.1, 0.14, 0.19, 0.25)
    logs = list(cruise_logs(arm, controller, start, np.full(7, 0.5), speeds))
    inside = interval_coverage(logs, arm, LogSensors(torque_noise=0.05, resolution=2e-5), range(200))
    return f"{inside.mean():.2%} of {inside.size} cover the truth", bool(inside.mean() >= 0.993)


def long_log() -> tuple[str, bool]:
    """A log of 1 000 000 rows and 15 columns identified, in a process of its own (10 s, 1 GB)."""

    from tests.identification.simulated import ideal_cruise

    arm, rows = lwr_dyn.load("wam7"), 1_000_000
    once = [ideal_cruise(arm.friction, np.full(7, v), arm) for v in (0.1, -0.1, 0.2, -0.2)]
    turn = np.vstack([np.hstack([log.q, log.tau]) for log in once])
    table = np.tile(turn, (-(-rows // len(turn)), 1))[:rows]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.csv"
        head = ",".join(["time", *(f"{x}{j}" for x in ("q", "tau") for j in range(1, 8))])
        np.savetxt(path, np.column_stack([np.arange(rows) / 100, table]), "%.9g", ",", header=head, comments="")
        code, seconds, gigabytes, _ = command("identify", "friction", "wam7", str(path))
    return f"{seconds:.1f} s, {gigabytes:.2f} GB", code == 0 and seconds < 10.0 and gigabytes < 1.0
