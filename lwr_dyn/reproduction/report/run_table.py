"""The runs that a page shows: how far the tip is from its path, and the share of the torque limits that they take."""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.pages.plotting.axes import short
from lwr_dyn.pages.plotting.drawn_panel import run_ink
from lwr_dyn.pages.replay.replay_page import RATE
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.reproduction.report.markup import Html, element


def run_table_html(runs: Sequence[ReplayedRun]) -> Html:
    """A line a run, and how many samples a second the page has of them."""
    heads = (("run", None, None), ("tip RMS", "mm", "num"), ("max", "mm", "num"), ("torque", "of limit", "num"))
    top = [
        element("th", name, " ", element("small", unit) if unit else None, scope="col", class_=kind)
        for name, unit, kind in heads
    ]
    return element(
        "table",
        element("caption", _title(runs)),
        element("thead", element("tr", top)),
        element("tbody", map(_row, runs)),
        class_="runs",
    )


def _title(runs: Sequence[ReplayedRun]) -> str:
    last = max(float(one.run.t[-1]) for one in runs)
    return f"{len(runs)} run{'s' if len(runs) > 1 else ''}, {short(last)} s"


def rate_note(runs: Sequence[ReplayedRun]) -> str:
    """What the page has of the runs, in a sentence."""
    rates = [(one.run.t.size - 1) / float(one.run.t[-1] - one.run.t[0]) for one in runs if one.run.t.size > 1]
    fastest = max(rates, default=0.0)
    if fastest <= 1.01 * RATE:
        return "All samples of the runs are on this page."
    return (
        f"Replay and cursors have {RATE:g} samples a second; the run files have {short(fastest)}. "
        "Curves, peaks and this table are drawn from all of them."
    )


def _row(one: ReplayedRun) -> Html:
    error = 1e3 * one.tip_error
    swatch = element("i", class_=f"sw {run_ink(one)}")
    numbers = [short(float(np.sqrt(np.mean(error**2)))), short(float(error.max())), torque_share(one)]
    return element(
        "tr",
        element("th", swatch, one.caption, scope="row"),
        [element("td", number, class_="num mono") for number in numbers],
    )


def torque_share(one: ReplayedRun) -> str:
    """The largest share of a known torque limit that a run takes, over time and joints."""
    efforts = [joint.limits.effort for joint in one.arm.joints()]
    peaks = np.abs(one.run.tau_applied).max(axis=0)
    shares = [float(peak) / limit for peak, limit in zip(peaks, efforts, strict=True) if limit]
    return f"{100 * max(shares):.2g} %" if shares else "unknown"
