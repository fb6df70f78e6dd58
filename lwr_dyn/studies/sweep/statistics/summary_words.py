"""Numbers of a summary as texts: each with its interval, and an open end where the runs do not bound it."""

from collections.abc import Mapping
from math import inf, isinf

import numpy as np

from lwr_dyn.pages.plotting.axes import short
from lwr_dyn.studies.sweep.statistics.intervals import QuantileEstimate, ShareEstimate
from lwr_dyn.studies.sweep.statistics.metric_words import MetricWords
from lwr_dyn.studies.sweep.statistics.summary import CUT, ControllerFigures, SweepSummary

OPEN = "?"
"""The end of an interval that the runs do not bound."""
PLANS = {
    "grid": "a grid", "sobol": "Sobol points", "latin-hypercube": "a Latin hypercube", "random": "independent points",
    "saltelli": "a Saltelli design",
}  # fmt: skip
"""The methods of a study in words."""
LOST = "unbounded"
"""In place of a value that is not finite."""


def value_text(words: MetricWords, badness: float) -> str:
    """A value in the unit for people: three digits."""
    value = words.shown(badness)
    if isinf(badness):
        return LOST if badness > 0.0 else "never" if value > 0.0 else OPEN
    return short(value)


def interval_text(words: MetricWords, found: QuantileEstimate) -> str:
    """The interval of a quantile, its lower end first; an end that is not bounded is "?"."""
    ends = [OPEN if isinf(end) and not found.is_bounded else value_text(words, end) for end in (found.low, found.high)]
    return " to ".join(ends if words.worse > 0 else ends[::-1])


def quantile_text(words: MetricWords, found: QuantileEstimate, with_interval: bool = True) -> str:
    """A quantile with its interval in brackets."""
    value = value_text(words, found.value)
    return f"{value} [{interval_text(words, found)}]" if with_interval else value


def percent(share: float) -> str:
    """A share in percent, with as many digits as tell it from 0 and from 100 %.

    >>> percent(0.5), percent(0.99991), percent(0.00001234), percent(1.0)
    ('50', '99.991', '0.0012', '100')
    """
    rest = min(share, 1.0 - share)
    if rest <= 0.0:
        return f"{100 * share:.0f}"
    decimals = 1 if rest >= 0.01 else 2
    while decimals < 8 and round(100 * rest, decimals - 1) == 0.0:
        decimals += 1
    return f"{100 * share:.{decimals}f}".rstrip("0").rstrip(".")


def share_text(found: ShareEstimate, with_interval: bool = True) -> str:
    """A share in percent with its interval in brackets."""
    if not found.runs:
        return OPEN
    value = f"{percent(found.value)} %"
    return f"{value} [{percent(found.low)} to {percent(found.high)}]" if with_interval else value


def about_text(summary: SweepSummary) -> str:
    """How many runs were made of which plan, in a sentence."""
    study = summary.study
    counts = [one.runs.count for one in summary.controllers.values()]
    least, most = min(counts, default=0), max(counts, default=0)
    made = f"{most}" if least == most else f"{least} to {most}"
    whole = f"{study.count} runs a controller" if least == study.count else f"{made} of {study.count} runs a controller"
    drawn = f"{PLANS[study.method]}, seed {study.seed}" if summary.is_sample else PLANS[study.method]
    lacking = [f"{count} of {text}{_why(summary.failures.get(text, {}))}" for text, count in summary.missing.items()]
    missing = f" Missing runs, which may be the worst: {', '.join(lacking)}." if lacking else ""
    extra = f"; {summary.extra_runs} more to see what breaks a limit first" if summary.extra_runs else ""
    return f"{whole} on the same plants ({drawn}){extra}.{missing}"


def _why(failures: Mapping[int, str]) -> str:
    """Why the first chunk that failed did so, in brackets."""
    return f" (chunk {min(failures)}: {failures[min(failures)]})" if failures else ""


def notes(summary: SweepSummary) -> list[str]:
    """All that is said below the tables: of intervals, of what runs lack, of what was not looked for."""
    figures = summary.controllers.values()
    cut = [(name, one.events.get(CUT), one.events["simulated"].runs) for name, one in summary.controllers.items()]
    known = [f"{one.runs} of {runs} of {name}" for name, one, runs in cut if one is not None and one.runs < runs]
    of_known = f"{CUT.capitalize()}: of the runs of which it is known, {', '.join(known)}." if known else ""
    said = [f"Each parameter alone: {text} was not looked at, {why}." for text, why in summary.not_searched.items()]
    found = [interval_note(summary), caveat(summary), of_known, *said, *map(needed_note, figures)]
    return list(dict.fromkeys(filter(None, found)))


def interval_note(summary: SweepSummary) -> str:
    """What stands in brackets, and what it holds for."""
    if not summary.is_sample:
        return "A grid is no sample: shares and quantiles are those of its points, and have no interval."
    said = "In brackets: 95 % intervals, of quantiles by order statistics, of shares by Clopper and Pearson"
    if summary.study.method == "random":
        return f"{said}."
    if summary.study.method == "saltelli":
        return f"{said}; from the rows A and B of the design, two in {len(summary.study.varied) + 2} runs."
    return f"{said}, as for independent runs; runs that fill their box evenly vary less as a rule."


def caveat(summary: SweepSummary) -> str:
    """What the runs lack, and what became of those that met a stop or diverged."""
    loop, runs = summary.study.loop, [one.runs for one in summary.controllers.values()]
    left = sum(int(((one.flags != "") & ~one.simulated).sum()) for one in runs)
    lost = max(
        int(np.isposinf(one.badness).sum()) for each in summary.controllers.values() for one in each.metrics.values()
    )
    has_stops, slow = loop.get("position_limits", True), [one.label for one in runs if one.simulated.all()]
    plant = "without friction" if loop.get("friction") == "none" else "with smooth friction, without stick"
    again = "those that reach a stop are computed again by simulate, and show its figures."
    if left:
        met = "met a stop or diverged" if has_stops else "diverged"
        again = f"{left} that {met} were not computed again, and have no figures."
    elif not loop.get("hand_over", True):
        again = "none of them reached one."
    whole = [f"{', '.join(slow)}: all runs by simulate{', with stops' if has_stops else ''}."] if slow else []
    if len(slow) == len(runs):
        ending = "."
    elif has_stops:
        ending = f" and without stops; {again}"
    else:
        ending = f"; positions have no limits{f'; {again}' if left else '.'}"
    why = "diverged" if not left else "have no figures"
    more = f" {LOST.capitalize()}: runs that {why}; they keep no limit." if lost else ""
    return " ".join([f"Runs are computed {plant}{ending}", *whole]) + more


def needed_note(figures: ControllerFigures) -> str:
    """Which quantiles the runs do not bound, and how many runs would; empty if none."""
    first = next(iter(figures.metrics.values()))
    open_ones = [one for one in first.quantiles if not one.is_bounded]
    said = [f"{100 * one.share:g} % needs {one.needed} runs, and {one.runs} were drawn" for one in open_ones]
    return f"{OPEN}: not bounded by the runs: {'; '.join(said)}." if said else ""


def hundredths(value: float, sign: str = "") -> str:
    """A share or correlation in two decimals, never "-0.00"; with `sign` "+" a plus, too.

    >>> hundredths(-0.001), hundredths(-0.001, "+"), hundredths(-0.25)
    ('0.00', '+0.00', '-0.25')
    """
    return f"{round(value, 2) + 0.0:{sign}.2f}"


def finite(value: float) -> float | None:
    """A number for JSON; None for one that is not finite."""
    return value if -inf < value < inf else None
