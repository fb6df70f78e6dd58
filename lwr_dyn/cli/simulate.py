"""`lwr-dyn simulate`: a robot, a task and a controller become a run file with its metrics and energy audit."""

from __future__ import annotations

import sys
from typing import Any

import click
import numpy as np

from lwr_dyn.cli.friction import chosen_friction_of
from lwr_dyn.cli.idle_options import Needs, refuse_idle
from lwr_dyn.cli.options import NUMBERS, load_robot, print_json, robot_options
from lwr_dyn.cli.run_report import run_record, run_text
from lwr_dyn.control.by_name import CONTROLLERS, Tuning, controller_by_name
from lwr_dyn.control.pd_gravity import PDGravity
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import ENGINES, dynamics_of
from lwr_dyn.errors import DivergenceError, FileAccessError, MissingDataError, OptionError
from lwr_dyn.files import check_writable
from lwr_dyn.front import load
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.simulation.friction_choice import FORMS
from lwr_dyn.simulation.plant import loaded, scaled
from lwr_dyn.simulation.sensors import Encoder
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.ist import DURATION, TIMINGS, ist_reference
from lwr_dyn.trajectory.references.lspb_move import lspb_move
from lwr_dyn.trajectory.references.point_to_point import hold, point_to_point

TASKS = ("ist", "point-to-point", "lspb", "hold")


def _controllers(*names: str) -> Any:
    return lambda given: given["controller"] in names


def _tasks(*names: str) -> Any:
    return lambda given: given["task"] in names


NEEDS = (
    Needs("timing", _tasks("ist"), "with --task ist"),
    Needs("arm_angle_deg", _tasks("ist"), "with --task ist"),
    Needs("from_deg", _tasks(*TASKS[1:]), f"with --task {', '.join(TASKS[1:])}"),
    Needs("to_deg", _tasks("point-to-point", "lspb"), "with --task point-to-point, lspb"),
    Needs("blend", _tasks("lspb"), "with --task lspb"),
    Needs("ki", _controllers("pid"), "with --controller pid"),
    Needs("velocity_error", _controllers("pd-gravity", "pid"), "with --controller pd-gravity, pid"),
    Needs("no_feedforward", _controllers("inverse-dynamics"), "with --controller inverse-dynamics"),
    Needs("no_gravity", _controllers("inverse-dynamics", "pid"), "with --controller inverse-dynamics, pid"),
    Needs("omega_n", lambda given: not given["own_gains"], "without --own-gains"),
    Needs("xi", lambda given: not given["own_gains"], "without --own-gains"),
    Needs("payload_known", lambda given: given["payload"] != 0.0, "with --payload"),
    Needs("substeps", lambda given: given["method"] == "rk4", "with --method rk4"),
    Needs("velocity_cutoff", lambda given: _measured(given), "with --encoder-bits or --encoder-noise"),
)
"""Options that only some others give a meaning."""


def _measured(given: Any) -> bool:
    return given["encoder_bits"] is not None or given["encoder_noise"] != 0.0


def _options(command: Any) -> Any:
    """The options of the command, grouped by what they are about."""
    flag: dict[str, Any] = {"is_flag": True}
    for option in reversed(
        (
            click.option("--task", type=click.Choice(TASKS), default="ist", show_default=True),
            click.option("--timing", type=click.Choice(TIMINGS), default="smooth", show_default=True, help="Of IST."),
            click.option("--duration", type=float, help="Seconds; 14 for IST, 7 for LSPB, else 2."),
            click.option("--arm-angle-deg", type=float, help="One arm angle for IST instead of the safest curve."),
            click.option("--from-deg", type=NUMBERS, help="Start of a move, place of hold (m for sliding)."),
            click.option("--to-deg", type=NUMBERS, help="End of point-to-point and of LSPB."),
            click.option("--blend", type=float, default=1.0, show_default=True, help="Of LSPB, s."),
            click.option("--controller", type=click.Choice(CONTROLLERS), default="pd-gravity", show_default=True),
            click.option("--omega-n", type=float, default=50.0, show_default=True, help="Natural frequency, rad/s."),
            click.option("--xi", type=float, default=1.0, show_default=True, help="Damping ratio."),
            click.option("--ki", type=float, help="Integral gain of the PID; omega_n^3 b/10 if not given."),
            click.option("--own-gains", **flag, help="PD with the gains of the arm's file."),
            click.option("--velocity-error", **flag, help="PD, PID: Kd on dq_ref - dq, not the paper's -dq."),
            click.option("--no-feedforward", **flag, help="Inverse dynamics as the paper has it, ddq_d = 0."),
            click.option("--no-gravity", **flag, help="Inverse dynamics without g in n; PID without g."),
            click.option("--plant-reading", help="Simulate another reading than the controller believes in."),
            click.option("--plant-scale", type=float, default=1.0, help="Factor on all masses of the plant."),
            click.option("--payload", type=float, default=0.0, help="Point mass at the flange, kg."),
            click.option("--payload-known", **flag, help="The controller knows of the payload."),
            click.option(
                "--friction", type=click.Choice(FORMS), default=FORMS[0], show_default=True, help="Of the plant."
            ),
            click.option("--passive-refit", **flag, help="The nearest friction that feeds no energy in."),
            click.option("--rate", type=float, default=1000.0, show_default=True, help="Samples a second."),
            click.option("--method", type=click.Choice(["rk4", "dop853"]), default="rk4", show_default=True),
            click.option("--substeps", type=int, default=1, show_default=True, help="RK4 steps a sample."),
            click.option("--continuous", **flag, help="The controller is asked all the time, not at samples."),
            click.option("--encoder-bits", type=int, help="Counts a turn as a power of two; exact if not given."),
            click.option("--encoder-noise", type=float, default=0.0, help="Standard deviation, rad."),
            click.option("--velocity-cutoff", type=float, default=100.0, help="Of the velocity filter, Hz."),
            click.option("--no-saturation", **flag, help="Do not cut torques at the limits."),
            click.option("--allow-unphysical", **flag, help="Simulate inertias no body can have."),
            click.option("--engine", type=click.Choice(ENGINES.names), default="pinocchio"),
            click.option("--seed", type=int, default=0, show_default=True, help="Of the encoder's noise."),
            click.option("--out", help="The run file, .npz."),
            click.option("--json", "as_json", **flag, help="One JSON object."),
        )
    ):
        command = option(command)
    return command


@click.command("simulate")
@robot_options
@_options
def command(robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...], **given: Any) -> None:
    """Simulate ROBOT under a controller on a task; print errors, torques against limits, and the energy audit."""
    refuse_idle(NEEDS, given)
    out = given["out"]
    if out is not None:
        if not out.endswith(".npz"):
            raise FileAccessError(out, "does not end in .npz", "a path that ends in .npz")
        check_writable(out)
    arm = load_robot(robot, reading, tip, locks)
    try:
        run = _simulated(arm, robot, given)
    except DivergenceError as fault:
        if out is not None and isinstance(fault.run, Run):
            fault.run.save(out)
            click.echo(f"kept what was computed in {out}")
        raise
    if out is not None:
        run.save(out)
    if given["as_json"]:
        print_json(run_record(run, arm))
        return
    click.echo(run_text(run, arm))
    if out is not None:
        click.echo(f"wrote {out}; see it:  lwr-dyn replay {out} --html {out.removesuffix('.npz')}.html")


def _simulated(arm: Arm, robot: str, given: dict[str, Any]) -> Run:
    payload = given["payload"]
    believed = loaded(arm, payload) if given["payload_known"] and payload else arm
    tuning = Tuning(
        omega_n=given["omega_n"], xi=given["xi"], ki=given["ki"], velocity_error=given["velocity_error"],
        feedforward=not given["no_feedforward"], gravity=not given["no_gravity"],
    )  # fmt: skip
    controller: Controller
    if given["own_gains"]:
        controller = _own_pd(believed, given)
    else:
        controller = controller_by_name(given["controller"], believed, tuning, engine=given["engine"])
    plant = arm if given["plant_reading"] is None else load(robot, given["plant_reading"], **arm.loaded_with)
    if given["plant_scale"] != 1.0:
        plant = scaled(plant, given["plant_scale"])
    friction, note = chosen_friction_of(plant, given["friction"], given["passive_refit"])
    encoder = _encoder(given["encoder_bits"], given["encoder_noise"], given["velocity_cutoff"])
    reference = _reference(arm, given)
    with click.progressbar(length=100, label="simulating", file=sys.stderr, hidden=not sys.stderr.isatty()) as bar:

        def progress(share: float) -> None:
            bar.update(max(0, int(100 * share) - bar.pos))

        return simulate(
            arm, controller, reference, plant=plant, payload=payload, encoder=encoder, progress=progress,
            rate=given["rate"], method=given["method"], substeps=given["substeps"], continuous=given["continuous"],
            engine=given["engine"], saturate=not given["no_saturation"], seed=given["seed"],
            allow_unphysical=given["allow_unphysical"], friction=friction, meta={"task": given["task"], **note},
        )  # fmt: skip


def _own_pd(believed: Arm, given: dict[str, Any]) -> PDGravity:
    if given["controller"] != "pd-gravity":
        raise OptionError("--own-gains", f"with --controller {given['controller']}", "with pd-gravity")
    if believed.gains is None:
        raise MissingDataError(believed.name, "controller gains", "--own-gains")
    gains, dynamics = believed.gains, dynamics_of(believed, given["engine"])
    return PDGravity(dynamics, gains.Kp, gains.Kd, given["velocity_error"])


def _encoder(bits: int | None, noise: float, cutoff: float) -> Encoder | None:
    if bits is not None and not 1 <= bits <= 40:
        raise OptionError("--encoder-bits", bits, "a whole number from 1 to 40")
    if bits is None:
        return Encoder(0.0, noise, cutoff) if noise else None
    return Encoder.of_bits(bits, noise, cutoff)


def _reference(arm: Arm, given: dict[str, Any]) -> Reference:
    duration = given["duration"]
    if given["task"] == "ist":
        angle = given["arm_angle_deg"]
        fixed = None if angle is None else float(np.radians(angle))
        return ist_reference(arm, given["timing"], DURATION if duration is None else duration, arm_angle=fixed)
    start = _joints(arm, given["from_deg"], "--from-deg")
    seconds = 2.0 if duration is None else duration
    if given["task"] == "hold":
        return hold(arm, start, seconds)
    end = _joints(arm, given["to_deg"], "--to-deg")
    if given["task"] == "lspb":
        return lspb_move(arm, start, end, duration=7.0 if duration is None else duration, blend=given["blend"])
    return point_to_point(arm, np.array([start, end]), [seconds])


def _joints(arm: Arm, values: tuple[float, ...] | None, name: str) -> Any:
    from lwr_dyn.cli.fk import from_degrees

    if values is None:
        raise OptionError(name, "not given", f"{arm.n} joint positions, deg (m for sliding joints)")
    return from_degrees(arm, values, name)
