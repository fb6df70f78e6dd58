"""`lwr-dyn show`: an arm or a run in the browser."""

from pathlib import Path

import click

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.cli.options import Loading, robot_options, say_caveats, stands_on
from lwr_dyn.cli.replay import arm_of_file, wait_for_interrupt
from lwr_dyn.cli.vocabulary import given_positions, with_shared
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run, run_used
from lwr_dyn.pages.explorer.page import explorer_html
from lwr_dyn.pages.explorer.page_data import start_pose
from lwr_dyn.pages.explorer.shown import has_display, show
from lwr_dyn.pages.replay import live
from lwr_dyn.pages.replay.replayed_runs import pose_as_run, replayed_runs

_OF_AN_ARM = ("reading", "tip", "locks", "mount", "tool", "xacro_args", "trust_xacro", "q_si", "q_deg")
"""Options that a run file answers by itself."""


@click.command("show")
@robot_options
@with_shared("--q q_si", ", at the start")
@with_shared("--q-deg", ", at the start; zero if not given")
@with_shared("--html", "; in lwr_dyn_pages/ if not given")
@click.option("--beside", metavar="ROBOT[:READING]", help="A second robot beside it, also one with other joints.")
@click.option("--serve", is_flag=True, help="Serve a live meshcat on 127.0.0.1 until Ctrl-C; no file is written.")
@click.option("--port", metavar="N", type=int, help="Port of --serve; 0 takes any free one.  [default: 7000]")
@click.option("--browser/--no-browser", default=None, help="Open the page; if not given, on a terminal with a display.")
def command(
    robot: str,
    loading: Loading,
    q_si: tuple[float, ...] | None,
    q_deg: tuple[float, ...] | None,
    html: str | None,
    beside: str | None,
    serve: bool,
    port: int | None,
    browser: bool | None,
) -> None:
    """Show an arm in the browser: sliders, frames, inertia, limits, and the source of each number.

    ROBOT may also be a RUN.npz of `lwr-dyn simulate`: its replay is shown.
    """
    if serve and html is not None:
        raise OptionError("show", "both --html and --serve", "one of them")
    if port is not None and not serve:
        raise OptionError("--port", "given without --serve", "only with --serve")
    if beside is not None and (serve or ends_in(robot, ".npz")):
        given = "with --serve" if serve else f"for {robot}"
        raise OptionError("--beside", f"given {given}", "only with a robot's page")
    run = _run(robot) if ends_in(robot, ".npz") else None
    other = None if beside is None else stands_on(_beside(beside))
    arm = loading.arm(robot) if run is None else stands_on(arm_of_file(run, robot), run_used(run))
    q = given_positions(arm, q_si, q_deg)
    say_caveats()
    if serve:
        _serve(arm, run, q, port, browser)
        return
    page = show(arm if run is None else run, html, q=q, beside=other, browser=browser)
    click.echo(repr(page))


def _beside(text: str) -> Arm:
    """The robot of ROBOT[:READING], a name or a file; raises as `lwr_dyn.load`."""
    name, mark, reading = text.rpartition(":")
    if mark and not reading:
        raise OptionError("--beside", repr(text), "ROBOT or ROBOT:READING, such as wam7:printed")
    is_whole = not mark or "/" in reading or "\\" in reading
    arm, _ = load_with_paper(text if is_whole else name, None if is_whole else reading)
    return arm


def _run(path: str) -> Run:
    """The run of a file; raises `OptionError` for options that would do nothing."""
    context = click.get_current_context()
    for name in _OF_AN_ARM:
        if context.get_parameter_source(name) == click.core.ParameterSource.COMMANDLINE:
            flag = {"locks": "lock", "xacro_args": "xacro-arg", "q_si": "q"}.get(name, name.replace("_", "-"))
            raise OptionError(f"--{flag}", f"given for {path}", "only with a robot: a run knows its own")
    return Run.load(Path(path))


def _serve(arm: Arm, run: Run | None, q: Array | None, port: int | None, browser: bool | None) -> None:
    number = live.DEFAULT_PORT if port is None else port
    with serve_arm(arm, q, port=number) if run is None else live.serve([run], arm, port=number) as server:
        wait_for_interrupt(server, has_display() if browser is None else browser, required=bool(browser))


def serve_arm(arm: Arm, q: Array | None = None, *, port: int = 0) -> live.LiveReplay:
    """An arm's page, live on 127.0.0.1: `show(q)` of the server moves the arm and the sliders of every open page.

    q (n,) [rad or m] is the pose at the start; raises as `explorer_html`, and `OptionError` for a port that is taken.
    """
    page = explorer_html(arm, q, live=True)
    shown = replayed_runs([pose_as_run(arm, start_pose(arm, q))], arm, [arm.name])
    return live.LiveReplay(page, shown, live.bound_sockets(port))
