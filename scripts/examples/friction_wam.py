"""The WAM paper's friction identification on the simulated arm: cruises, noisy logs, friction map, Table 1 again."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.control.paper_laws import PDGravity
from lwr_dyn.identification.friction.identify_friction import friction_map_figure, identify_friction_files
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.logs.simulated_logs import LogSensors, cruise_logs
from lwr_dyn.pages.plotting.plots import save_figure


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/friction_wam"))
    parser.add_argument("--speeds", type=float, nargs="+", default=[0.06, 0.09, 0.13, 0.18, 0.25], help="rad/s")
    parser.add_argument("--torque-noise", type=float, default=0.05, help="standard deviation, N m")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)

    arm = lwr_dyn.load("wam7")
    Kd = np.array(arm.gains.Kd)
    Kd[3] = 8.0  # with the manufacturer's 2 joint 4 has no net damping upward: it sticks and slips, and never cruises
    controller = PDGravity(lwr_dyn.dynamics_of(arm), arm.gains.Kp, Kd, velocity_error=True)
    start = [0.0, -1.2, 0.0, 1.6, 0.0, 0.2, 0.0]
    sensors = LogSensors(options.torque_noise, resolution=2 * np.pi / 4096 / 42)  # 4096 counts a turn of the motor

    files = []
    for i, log in enumerate(cruise_logs(arm, controller, start, np.full(7, 0.5), options.speeds)):
        files.append(options.out / f"cruise_{i}.csv")
        write_log(files[-1], sensors.through(log, options.seed + i))

    result = identify_friction_files(files, arm=arm, subtract="all")
    print("joint     Table 1  identified   99.73 % interval (Student's t)")
    for fit in result.fits:
        friction = arm.friction[fit.joint - 1]
        direction = friction.positive if fit.sign > 0 else friction.negative
        truth = [getattr(direction, name) for name in fit.names]
        rows = zip(fit.names, truth, fit.estimate.values, fit.estimate.half_widths, strict=True)
        for name, true, value, half in rows:
            print(f"{fit.joint}{'+' if fit.sign > 0 else '-'} {name:8s} {true:8.4f} {value:9.4f} +- {half:.4f}")
    for fault in result.faults:
        print(fault)
    png, _ = save_figure(friction_map_figure(result), options.out / "friction_maps")
    print(f"wrote {len(files)} logs and {png}")


if __name__ == "__main__":
    main()
