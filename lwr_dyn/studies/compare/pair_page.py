"""Any two runs of a comparison replayed side by side: two lists to choose from, in one file that needs no network.

The page is that of a replay with two arms; what all runs share (the arm, the reference, the times) stands in it once.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replay_page import RATE, generator_line, pack_int32, player_page, run_record
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.studies.compare.compared_run import ComparedRun, thinned
from lwr_dyn.studies.compare.comparison import RunComparison

BUDGET = 12_000_000
"""Largest size of all series in the page [bytes]; above it fewer samples a second are kept."""
LEAST = 10.0
"""[Hz] Fewer samples a second would not show a motion."""
SHARED = ("joints", "flange", "base", "native", "floor", "foot", "tip_model", "t", "q_ref", "reference", "samples")
"""Of a run's record: what runs of one reference have in common, as a rule."""


def pair_html(compared: RunComparison) -> str:
    """The page; the same comparison gives the same text.

    Raises
    ------
    OptionError
        Fewer than two runs.
    """
    if len(compared.runs) < 2:
        raise OptionError("replay of two runs", "one run", "two runs or more")
    own = ("pair.css", "pair.js")
    return player_page(compared.title, pair_data(compared), own=own, of="lwr_dyn.studies.compare")


def pair_data(compared: RunComparison) -> dict[str, Any]:
    """The player's data: two runs on the stage, and what is needed to put any other there."""
    rate, start = rate_within(compared.runs), _at_start(compared)
    records = [_record(one, rate) for one in compared.runs]
    shared = {key: records[0][key] for key in SHARED}
    own = [{key: x for key, x in record.items() if shared.get(key) != x} for record in records]
    first = [replace(compared.runs[i].shown, place=place) for place, i in enumerate(start)]
    commands = [command for place, one in enumerate(first) for command in replay_page.arm_commands(one, place)]
    return {
        "runs": [_on_stage(records[i], place) for place, i in enumerate(start)],
        "scene": commands,
        "made_by": generator_line(),
        "title": compared.title,
        "live": False,
        "start": {"trace": True, "frames": False, "beside": True},
        "pair": {"shared": shared, "runs": own, "chosen": list(start)},
    }


def rate_within(runs: Sequence[ComparedRun], budget: int = BUDGET) -> float:
    """Samples a second that the page keeps [Hz], at most `RATE`, so that its series stay within `budget` bytes."""
    numbers = sum((one.shown.arm.n + 5) * float(one.shown.run.t[-1]) for one in runs)  # a second
    return max(LEAST, min(RATE, budget / (numbers * 16 / 3)))


def _record(one: ComparedRun, rate: float) -> dict[str, Any]:
    """A run's record for the player, with its figures among its facts."""
    (shown,) = replayed_runs([thinned(one.shown.run, rate)], [one.shown.arm], [f"{one.controller}, {one.plant}"])
    record = run_record(shown)
    figures = [["tip RMS", f"{one.figures.tip_rms_mm:.3g} mm"],
               ["largest", f"{one.figures.tip_max_mm:.3g} mm"], ["limits", one.figures.limits]]  # fmt: skip
    figures += [["unstable,", str(one.cuts)]] if one.shakes else []
    about = [fact for fact in record["facts"] if fact[0] in ("reading", "audit")]
    samples = [int(shown.run.t.size), int(one.shown.run.t.size)]
    more = {"facts": figures + about, "controller": one.controller, "plant": one.plant, "samples": samples}
    return {**record, **more, "trace": {"points": pack_int32(shown.pose[:, :3, 3])}}


def _on_stage(record: dict[str, Any], place: int) -> dict[str, Any]:
    return {**record, "place": place, "trace": {"t": record["t"], **record["trace"]}}


def _at_start(compared: RunComparison) -> tuple[int, int]:
    """The runs that the page shows first: the best and the worst of the last plant with two of them that are stable."""
    at = {id(one): i for i, one in enumerate(compared.runs)}
    chosen = (0, 1)
    for runs in compared.plants.values():
        still = sorted((one for one in runs if not one.shakes), key=lambda one: one.figures.tip_rms_mm)
        if len(still) > 1:
            chosen = (at[id(still[0])], at[id(still[-1])])
    return chosen
