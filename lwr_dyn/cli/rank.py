"""`lwr-dyn rank`: published sets of one robot on a log of the real one."""

from typing import Any

import click

from lwr_dyn.cli.identify.log_options import columns_option
from lwr_dyn.cli.options import Loading, Separated, robot_options, show, with_caveats
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.progress import progress
from lwr_dyn.identification.logs.log_columns import column_map, declared_units
from lwr_dyn.identification.ranking.rank import rank
from lwr_dyn.identification.ranking.ranking_page import ranking_page
from lwr_dyn.identification.report.motion_report import check_report_path
from lwr_dyn.pages.document import page_html

NAMES = Separated("names", lambda text: tuple(part.strip() for part in text.split(",")), "names separated by commas")


@click.command("rank")
@robot_options
@click.option("--log", required=True, metavar="LOG", help="A published log by name, a fetched file of one, or yours.")
@click.option("--sets", type=NAMES, default=(), metavar="SET,...",
              help="Readings of ROBOT, ROBOT:READING of another, files, or identified (our own, of the rows that "
              "train); all readings if not given.")  # fmt: skip
@click.option("--free", type=NAMES, default=(), metavar="WHAT,...",
              help="Fit load, gain, rotor or coupling beside the friction, one after the other.")  # fmt: skip
@click.option("--test", metavar="LOG", help="The log that tests; the last 40 % of --log if not given.")
@click.option("--logs-in", metavar="FOLDER", help="Where fetched logs lie, recognised by their digests.")
@with_shared("--cutoff", " and torques; that of a published log, or 10, if not given")
@columns_option
@click.option("--units", help="Units of columns that declare none, such as time=ms,q=deg,tau=mN m.")
@with_shared("--html", ": tables, and the torques of each set against measurement")
@with_shared("--json as_json")
def command(robot: str, loading: Loading, log: str, as_json: bool, **given: Any) -> None:
    """Rank published sets of ROBOT on a log of the real one, by held-out torques.

    Every set gets the same filter, rows and friction. A log of computed torques is refused: it would rank first the
    table that it was computed from. Look at the column of a free load before a set is called wrong.

    ROBOT and all sets are loaded with the same options: --mount as the robot of the log stood, --tool as it carried;
    --reading is one set alone.
    """
    if given["html"] is not None:
        check_report_path(given["html"])
    units = dict(declared_units(given["units"]))
    with progress("ranking"):
        found = rank(
            robot, log, given["sets"], free=given["free"], test=given["test"], cutoff=given["cutoff"],
            folder=given["logs_in"], columns=column_map(*given["columns"]), units=units,
            loading=loading.options,
        )  # fmt: skip
    show(found.document, as_json)
    if given["html"] is not None:
        write_file(given["html"], page_html(with_caveats(ranking_page(found))))
        click.echo(f"wrote {given['html']}", err=as_json)
