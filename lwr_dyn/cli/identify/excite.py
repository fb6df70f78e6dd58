"""`lwr-dyn excite`: a motion whose torques say most of an arm's parameters."""

import shlex
import sys
from typing import Any

import click
import numpy as np

from lwr_dyn.cli.main import print_error
from lwr_dyn.cli.options import NUMBERS, Loading, OneOf, robot_options, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.progress import progress, stop_asked
from lwr_dyn.identification.excitation import design, motion_file, motion_limits
from lwr_dyn.identification.excitation.motion_limits import KEPT, MARGIN, SPEED_SHARE, TORQUE_SHARE
from lwr_dyn.identification.excitation.objectives import OBJECTIVES
from lwr_dyn.identification.excitation.room import check_column
from lwr_dyn.model.arm import arm_with_payload

SECONDS = 30.0
"""[s] Of the search, where it is not given."""
STOPPED = 130
"""Exit code after Ctrl-C."""


@click.command("excite")
@robot_options
@click.option("--duration", default=design.DURATION, show_default=True, help="Duration of the motion, s.")
@click.option("--objective", type=OneOf(OBJECTIVES), default=OBJECTIVES[0], show_default=True,
              help="Least sigma of the parameters (d), or least condition number (cond).")  # fmt: skip
@click.option("--starts", default=design.STARTS, show_default=True, help="Random motions from which the search begins.")
@click.option("--search-seconds", "seconds", default=SECONDS, show_default=True,
              help="Longest time of the search, s; inf for no limit.")  # fmt: skip
@click.option("--seed", default=0, show_default=True, help="Seed of the random motions.")
@click.option("--harmonics", default=design.HARMONICS, show_default=True, help="Sines and cosines of each joint.")
@click.option("--noise", type=NUMBERS, default=(design.NOISE,), show_default=True,
              help="Standard deviation of the joint torques, N m: one, or one each.")  # fmt: skip
@with_shared("--payload", default=0.0)
@click.option("--joint-speed", "speed", type=float, help="Speed limit of joints whose own is unknown, rad/s or m/s.")
@with_shared("--speed-share", " that it may use", SPEED_SHARE)
@with_shared("--torque-share", ", by the arm's table", TORQUE_SHARE)
@click.option("--margin-deg", default=float(np.degrees(MARGIN)), show_default=False,
              help=f"Distance kept from the position limits, deg; {np.degrees(MARGIN):.3g} if not given.")  # fmt: skip
@click.option("--floor", type=float, help="Height of the floor in the first frame, m; where the arm is drawn to stand.")
@click.option("--column", type=float, help="Radius of the column up to the first joint, m; as drawn; 0 for none.")
@click.option("--keep", type=float, help="Distance from floor, column and own links, m; if not given "
              f"{KEPT:g}, and less between links that are never far apart.")  # fmt: skip
@click.option("--out", metavar="FILE", help="Write the motion there: .csv, .parquet, or .npz as a run.")
@click.option("--rate", default=100.0, show_default=True, help="Samples a second of --out.")
@with_shared("--json as_json")
def command(robot: str, loading: Loading, **given: Any) -> None:
    """Design a motion of ROBOT that shows its inertial and friction parameters best, to be run and logged.

    A Fourier series that begins and ends at rest, inside the limits of position, speed and torque, clear of the floor,
    the column under the base and the arm's own links (capsules with the radii that are drawn). Torques are those of the
    arm's table, with friction only where its file gives it.

    Ctrl-C ends the search as --search-seconds does: the best motion so far is printed and written to --out (exit 130).
    Where no start ends in a motion that may be run, the nearest to one is printed, with what is wrong with it (exit 1).
    Where no pose keeps what is asked, nothing is searched (exit 2).
    """
    out, noise = given["out"], given["noise"]
    design.check_choices(given["objective"], given["starts"], given["seed"], given["duration"])
    design.check_rate(given["rate"], given["duration"])
    design.check_seconds(given["seconds"])
    if not given["margin_deg"] >= 0.0:
        raise OptionError("--margin-deg", given["margin_deg"], "0 or more, in deg")
    if out is not None:
        motion_file.check_target(out)
    arm = loading.arm(robot)
    if given["payload"] != 0.0:
        arm = arm_with_payload(arm, given["payload"])
    weights = design.noise_of_joints(noise[0] if len(noise) == 1 else noise, arm.n)
    margin = float(np.radians(given["margin_deg"]))
    limits = motion_limits.MotionLimits.of(arm, margin, given["speed_share"], given["torque_share"], given["speed"])
    clearance = motion_limits.clearance_of(arm, given["keep"], given["floor"], given["column"])
    check_column(clearance, given["column"])
    found = _searched(
        given, arm, duration=given["duration"], objective=given["objective"], starts=given["starts"],
        harmonics=given["harmonics"], seed=given["seed"], noise=weights, limits=limits, clearance=clearance,
        seconds=given["seconds"],
    )  # fmt: skip
    if out is not None:
        motion_file.write_excitation(out, found, given["rate"])
    show(found.document, given["as_json"])
    if out is not None and not given["as_json"]:
        then = "" if found.faults else _next(out, robot, loading, given["payload"])
        click.echo(f"wrote {out}{then}")
    if found.ended == "stopped":
        sys.exit(print_error("stopped: this is the best motion so far", STOPPED))
    sys.exit(1 if found.faults else 0)


def _searched(given: dict[str, Any], *arguments: Any, **options: Any) -> design.Excitation:
    """The motion that the search ends in, may it be run or not; what may be run is written as soon as it is found."""

    def keep(found: design.Excitation) -> None:
        if given["out"] is not None:
            motion_file.write_excitation(given["out"], found, given["rate"])

    with progress("searching an exciting motion") as report, stop_asked(lambda: report("stopping")) as stop:
        try:
            return design.design_excitation(*arguments, **options, stop=stop, better=keep, report=report)
        except design.NoMotionError as none:
            return none.best


def _next(out: str, robot: str, loading: Loading, payload: float) -> str:
    """The command that simulates a log of it, of the same arm."""
    if not out.endswith(".csv"):
        return ""
    words = ["lwr-dyn", "simulate", robot]
    chosen = {"reading": loading.reading, "tip": loading.tip, "lock": loading.locks, "payload": payload}
    for name, values in [*chosen.items(), *((x, y) for x, y in loading.further.items() if x != "trust_xacro")]:
        for value in values if isinstance(values, tuple) else (values,) if values else ():
            words += [
                f"--{name.replace('xacro_args', 'xacro-arg')}",
                repr(value) if isinstance(value, float) else value,
            ]
    words += ["--trust-xacro"] if loading.further["trust_xacro"] else []
    words += ["--task", "csv", "--file", out, "--controller", "inverse-dynamics"]
    return f"; simulate a log:  {shlex.join([*words, '--out', out.removesuffix('.csv') + '_run.npz'])}"
