"""`lwr-dyn replay`: run files -> one HTML page, or a live meshcat on this machine."""

import webbrowser
from pathlib import Path
from typing import Any

import click

from lwr_dyn.arms import loading
from lwr_dyn.cli.options import say_caveats, stands_on
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run, run_used


@click.command("replay")
@click.argument(
    "run_files", metavar="RUN.npz [OTHER.npz ...]", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@with_shared("--html")
@click.option("--serve", is_flag=True, help="Serve a live meshcat on 127.0.0.1 until Ctrl-C.")
@click.option("--port", metavar="N", type=int, help="Port of --serve; 0 takes any free one.  [default: 7000]")
@click.option("--browser", is_flag=True, help="Open the page of --serve in the browser.")
@click.option("--label", "labels", multiple=True, metavar="TEXT", help="Name of a run on the page; once per run.")
@click.option("--side-by-side", "beside", is_flag=True, help="Start with the arms side by side instead of overlaid.")
@click.option("--frames", is_flag=True, help="Start with the frames of the paper shown.")
@click.option("--title", metavar="TEXT", help="Headline of the page.")
def command(
    run_files: tuple[Path, ...],
    html: str | None,
    serve: bool,
    port: int | None,
    browser: bool,
    labels: tuple[str, ...],
    beside: bool,
    frames: bool,
    title: str | None,
) -> None:
    """Replay runs in 3D: the arms, their traces against the reference, the errors."""
    allowed = f"--html FILE or --serve; to look at once: lwr-dyn show {run_files[0]}"
    if (html is None) == (not serve):
        raise OptionError("replay", "both --html and --serve" if serve else "nothing to do", allowed)
    if not serve and (port is not None or browser):
        raise OptionError("--port, --browser", "given without --serve", "only with --serve")
    if beside and len(run_files) < 2:
        raise OptionError("--side-by-side", "would do nothing here", "with two runs or more")
    runs = [Run.load(path) for path in run_files]
    arms = [stands_on(arm_of_file(run, path), run_used(run)) for run, path in zip(runs, run_files, strict=True)]
    say_caveats()
    layout = "beside" if beside else "overlaid"
    options: dict[str, Any] = {"labels": labels or None, "title": title, "frames": frames, "layout": layout}
    if html is not None:
        from lwr_dyn.pages.replay import replay_page  # here, not above: `replay --help` needs neither page nor meshcat

        replay_page.write_replay(html, runs, arms, **options)
        click.echo(
            f"wrote {html} ({Path(html).stat().st_size / 1e6:.1f} MB, needs no network); open it: xdg-open {html}"
        )
        return
    from lwr_dyn.pages.replay import live

    with live.serve(runs, arms, port=live.DEFAULT_PORT if port is None else port, **options) as server:
        wait_for_interrupt(server, browser)


def wait_for_interrupt(server: Any, browser: bool, *, required: bool = True) -> None:
    """Say where a `live.LiveReplay` serves its page, open that with `browser`, and wait for Ctrl-C.

    Raises `OptionError` when no browser is found and one is required.
    """
    click.echo(f"{server.url} (Ctrl-C ends it)")
    if browser and not webbrowser.open(server.url) and required:
        raise OptionError("--browser", "no browser found", f"a browser; or without --browser open {server.url}")
    try:
        server.wait()
    except KeyboardInterrupt:
        click.echo("closed", err=True)


def arm_of_file(run: Run, path: str | Path) -> Arm:
    """The arm of a run; `FileAccessError` names the run's file where it does not say of which robot it is."""
    try:
        return loading.arm_of(run)
    except OptionError:
        fault, allowed = "does not say of which robot it is", "a run file of lwr-dyn simulate"
        raise FileAccessError(str(path), fault, allowed) from None
