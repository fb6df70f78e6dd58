"""`lwr-dyn identify table`: a table against logs, cell by cell, and its slips traced."""

import click

from lwr_dyn.cli.identify.log_options import (
    LIKELIEST,
    behind_the_gears,
    check_option,
    check_robot,
    end,
    link_side_option,
    log_options,
    readable_logs,
)
from lwr_dyn.cli.options import Loading, robot_options, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.progress import progress
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.motion.motion_fit import identify_motion, motion_information
from lwr_dyn.identification.motion.motion_result import MotionRule
from lwr_dyn.identification.payload.identify_load import CUTOFFS
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, SampleRule
from lwr_dyn.identification.report.motion_report import check_report_path, motion_page
from lwr_dyn.identification.slips.printed_cells import printed_cells
from lwr_dyn.identification.slips.slip_tables import best_table, slip_document, slips_card, table_against_log
from lwr_dyn.identification.slips.trace import DEVIATION, checked_deviation, trace_slips
from lwr_dyn.pages.document import page_html


@click.command("table")
@robot_options
@check_option
@log_options
@with_shared("--html", ": the report of identify motion, with the table's cells and repairs")
@with_shared("--deviation", ", were this right: as 5% or 0.05", DEVIATION, show_default=f"{DEVIATION:.0%}")
@with_shared("--cutoff", LIKELIEST + ", also with the speeds of the log")
@click.option("--slowest", type=float, default=DEFAULT_SAMPLES.slowest, show_default=True,
              help="Speed up to which a joint's torques are left out, rad/s or m/s.")  # fmt: skip
@link_side_option
def command(
    robot: str, loading: Loading, logs: tuple[str, ...], units: str | None, columns: tuple[str, ...], deviation: float,
    cutoff: float | None, slowest: float, link_side: bool, html: str | None, as_json: bool, as_logged: bool,
) -> None:  # fmt: skip
    """Masses, centres, tensors and rotors of the table of ROBOT against logs; which cells are wrong, and how.

    Friction is left free. Signs, powers of ten, copies of a neighbour, exchanged cells, axes and rows, units and
    conventions are tried, and any other value of one cell. Exit 1 when the table does not meet the logs.
    """
    share, declared = checked_deviation(deviation), declared_units(units)
    check_robot(robot)
    arm, paper = loading.arm_and_paper(robot)
    behind = behind_the_gears(arm, {"link_side": link_side})
    samples = SampleRule(DEFAULT_SAMPLES.cutoff if cutoff is None else cutoff, slowest=slowest, link_side=behind)
    rule = MotionRule(samples, cutoffs=CUTOFFS if cutoff is None else ())
    if paper is not None:
        loading.refuse_changes("the arm as its table has it, or a .urdf", mount=True)
    source = arm if paper is None else paper
    if html is not None:
        check_report_path(html)
    printed_cells(source)  # it may have no masses: said before a long log is read
    with progress("reading the logs, then trying repairs"):
        usable, faults = readable_logs(logs, declared, arm, columns, as_logged)
        if not usable:
            end(faults)
        information, samples = motion_information(usable, arm, rule)
        report = trace_slips(information, source, deviation=share)
        cells = table_against_log(information, source, deviation=share, at=best_table(report))
    show(slip_document(report, cells, paper, robot=robot, reading=arm.reading), as_json)
    if html is not None:
        result = identify_motion(usable, arm, MotionRule(samples, coupled=False))
        card = slips_card(result.information, source, report)
        write_file(html, page_html(motion_page(result, more=[card], command="lwr-dyn identify table")))
        click.echo(f"wrote {html}", err=as_json)
    if not faults and not report.fits:
        raise SystemExit(1)
    end(faults)
