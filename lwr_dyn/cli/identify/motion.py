"""`lwr-dyn identify motion`: friction, base parameters and bodies from any motion."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import click

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.cli.identify import log_options as of_logs
from lwr_dyn.cli.options import Loading, OneOf, OptionRule, refuse_unused, robot_options, show
from lwr_dyn.cli.vocabulary import SHARE, with_shared
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError
from lwr_dyn.foundation.files import ends_in, write_file
from lwr_dyn.foundation.progress import progress
from lwr_dyn.identification.bodies.possible_bodies import body_lines
from lwr_dyn.identification.fitted_files import check_fitted_path, write_fitted
from lwr_dyn.identification.logs.joint_log import JointLog, apart_from, read_log
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.motion import motion_result
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import DEFAULT_MOTION, MotionIdentification
from lwr_dyn.identification.motion.validation import Validation
from lwr_dyn.identification.payload.identify_load import CUTOFFS
from lwr_dyn.identification.regression.joints_alone import motor_words
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, sample_notes
from lwr_dyn.identification.regression.torque_columns import FORMS
from lwr_dyn.identification.report.motion_report import check_report_path, motion_page
from lwr_dyn.identification.slips.slip_tables import table_card
from lwr_dyn.model.arm import Arm
from lwr_dyn.pages.document import page_html

SLOWEST_STRIBECK = 0.01
"""[rad/s or m/s] Samples below three Stribeck speeds are what the search needs."""
INSTRUMENT_RULES = tuple(
    OptionRule(option, lambda given: not given["instruments"], "without --instruments, which takes unfiltered rows")
    for option in ("stribeck", "motor-side", "cutoff", "folds", "gains", "html", "load-friction", "coupled")
)
"""Options that instrumental variables have no use for."""
COUPLED_RULE = OptionRule(
    "coupled", lambda given: not given["motor_side"], "without --motor-side, which has the motors"
)
ACCEPT_RULE = OptionRule("accept", lambda given: given["out"], "with --out")


@click.command("motion")
@robot_options
@of_logs.check_option
@of_logs.log_options
@with_shared("--html", ": the motion in 3D, links before and after, torques, friction, checks")
@with_shared("--out", " the fitted arm: a .toml (robot from a data file) or a .urdf with its sidecars")
@click.option("--accept", is_flag=True, help="Write --out though the log contradicts the bodies.")
@with_shared("--cutoff", of_logs.LIKELIEST + ", also with the speeds of the log")
@click.option("--slowest", type=float, help="Speed up to which a joint's torques are left out, rad/s or m/s.  "
              f"[default: {DEFAULT_SAMPLES.slowest}, with --stribeck {SLOWEST_STRIBECK}]")  # fmt: skip
@with_shared(
    "--fit-friction friction",
    ": Coulomb and viscous of each direction, or the same in both with an offset",
    DEFAULT_MOTION.friction,
    kind=OneOf(FORMS),
)
@click.option("--stribeck", is_flag=True, help="Search the Stribeck speeds of joints whose torques ask for one.")
@click.option(
    "--load-friction", is_flag=True, help="Friction that grows with the torque carried: fits a share a joint."
)
@with_shared("--deviation", ", as 20% or 0.2; found from the logs if not given")
@click.option("--coupled/--uncoupled", default=None, help="Rotors and friction of motors that turn several joints, "
              "or of the joints; what the logs say if not given.")  # fmt: skip
@click.option("--known", multiple=True, metavar="EQUATION",
              help="Known for certain of the bodies: 'total mass = 15.8', 'm_7 = 0.24' [SI]. Repeatable.")  # fmt: skip
@click.option("--gains", type=SHARE, metavar="SHARE",
              help="Torques are currents times gains known to this share, as 10%: fits a factor a joint.")  # fmt: skip
@click.option("--folds", type=int, default=DEFAULT_MOTION.folds, show_default=True,
              help="Parts of the motion, each kept from a fit in turn.")  # fmt: skip
@click.option("--instruments", multiple=True, metavar="FILE",
              help="The motion that was commanded (.csv of `excite`, or a run), one for each LOG: instrumental "
              "variables on unfiltered rows, for logs that no filter suits.")  # fmt: skip
@click.option("--validate", multiple=True, metavar="LOG", help="A log to predict and not to fit. Repeatable.")
@of_logs.link_side_option
@of_logs.motor_options
def command(
    robot: str, loading: Loading, logs: tuple[str, ...], units: str | None, as_json: bool, **given: Any
) -> None:
    """Friction, inertial base parameters and bodies of ROBOT from any motion, validated on motions kept from the fit.

    Says of each parameter whether it is identified, and what no bodies can have; that is a warning, not an error (exit
    0), with --json on the error stream too. Beside them it fits bodies that are as near to the robot's table as the
    logs allow. Columns of wrong sign, order or unit are looked for first, and named.
    """
    usual = SLOWEST_STRIBECK if given["stribeck"] else DEFAULT_SAMPLES.slowest
    slowest = usual if given["slowest"] is None else given["slowest"]
    refuse_unused((*INSTRUMENT_RULES, COUPLED_RULE, ACCEPT_RULE), given)
    of_logs.check_robot(robot)
    (arm, paper), declared = loading.arm_and_paper(robot), declared_units(units)
    motors = of_logs.chosen_motors(arm, given)
    cutoff = DEFAULT_SAMPLES.cutoff if given["cutoff"] is None else given["cutoff"]
    samples = of_logs.sample_rule(cutoff, float(slowest), motors, of_logs.behind_the_gears(arm, given))
    asked = ("friction", "stribeck", "folds", "deviation", "known", "gains", "load_friction", "coupled")
    fit = {name: given[name] for name in asked}
    rule = motion_result.MotionRule(samples, cutoffs=CUTOFFS if given["cutoff"] is None else (), **fit)
    _check_paths(given, arm, paper, loading)
    read = (given["columns"], given["as_logged"])
    with progress("reading and fitting the logs"):
        usable, faults = of_logs.joint_logs(logs, declared, arm, motors, *read)
        unseen, more = of_logs.joint_logs(given["validate"], declared, arm, motors, *read)
        unseen, seen = apart_from(unseen, usable, "which is fitted", "logs that the fit does not see")
        commands, unread = _commands(given["instruments"], declared, arm)
        result = identify_motion(usable, arm, rule, commands) if usable and not unread else None
    of_logs.warn(sample_notes([*usable, *unseen], samples))
    if result is not None:
        checked = result.validated_on(unseen) if unseen else ()
        files = ", ".join(log.source for log in unseen)
        document = motion_result.motion_document(result, robot=robot, unseen=checked, files=files)
        show(document, as_json, own_caveats=True)  # what the arm's model leaves out the fit may have
        if as_json:
            of_logs.warn(body_lines(result.bodies))
        for line in _written(given, result, checked, paper):
            click.echo(line, err=as_json)
        if given["out"] is not None and _is_refused(given, result):
            allowed = "bodies that meet the log: look at columns and table (identify table); --accept writes these"
            unread.append(FileAccessError(given["out"], f"not written: {result.contradiction}", allowed))
    of_logs.end([*faults, *more, *seen, *unread])


def _is_refused(given: Mapping[str, Any], result: MotionIdentification) -> bool:
    return bool(result.contradiction) and not given["accept"]


def _commands(paths: Sequence[str], units: Mapping[str, str], arm: Arm) -> tuple[list[JointLog], list[LwrDynError]]:
    """The motions of --instruments: times and positions."""
    commands, faults = [], []
    for path in paths:
        try:
            commands.append(read_log(path, units, arm, needs=("q",), also=()))
        except LwrDynError as fault:
            faults.append(fault)
    return commands, faults


def _check_paths(given: dict[str, Any], arm: Arm, paper: Paper | None, loading: Loading) -> None:
    if given["html"] is not None:
        check_report_path(given["html"])
    if given["out"] is not None:
        check_fitted_path(given["out"], paper)
        if ends_in(given["out"], ".toml"):
            loading.refuse_changes("a .urdf with --out: a .toml has the rows of the robot's table")
        arm.require_dynamics()


def _written(
    given: dict[str, Any], result: MotionIdentification, checked: tuple[Validation, ...], paper: Paper | None
) -> Iterator[str]:
    """Writes report and fitted arm, and says so."""
    if given["html"] is not None:
        card = table_card(result.information, result.arm if paper is None else paper)
        write_file(given["html"], page_html(motion_page(result, unseen=checked, more=card)))
        yield f"wrote {given['html']}"
    if given["out"] is not None and not _is_refused(given, result):
        files = ", ".join(map(str, write_fitted(given["out"], result, paper)))
        yield f"wrote {files}; next: lwr-dyn check {given['out']}"
        if turned := motor_words(result.columns.transmission):
            yield f"{given['out']} has what each joint shows alone; {turned}: what it adds between them is in no model"
