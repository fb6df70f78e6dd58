"""A summary for people and programs: numbers with their intervals, tables."""

from math import floor, isinf, log10

import numpy as np

from lwr_dyn.foundation.number_text import short
from lwr_dyn.foundation.tables import Table
from lwr_dyn.studies.sweep.intervals import IntervalEstimate, QuantileEstimate, ShareEstimate
from lwr_dyn.studies.sweep.summary import CUT, TORNADO, ControllerFigures, SweepSummary
from lwr_dyn.studies.sweep.vocabulary import MetricWords

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


def quantile_text(words: MetricWords, found: QuantileEstimate, with_interval: bool = True) -> str:
    """A quantile with its interval in brackets, the lower end first; an end that is not bounded is "?"."""
    value = value_text(words, found.value)
    if not with_interval:
        return value
    ends = [OPEN if isinf(end) and not found.is_bounded else value_text(words, end) for end in (found.low, found.high)]
    return f"{value} [{' to '.join(ends[:: words.worse])}]"


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
    whole = f"{study.runs} runs a controller" if least == study.runs else f"{made} of {study.runs} runs a controller"
    drawn = f"{PLANS[study.method]}, seed {study.seed}" if summary.is_sample else PLANS[study.method]
    lacking = []
    for text, count in summary.missing.items():
        failed = sorted(summary.failures.get(text, {}).items())[:1]
        lacking.append(f"{count} of {text}" + "".join(f" (chunk {number}: {why})" for number, why in failed))
    missing = f" Missing runs, which may be the worst: {', '.join(lacking)}." if lacking else ""
    extra = f"; {summary.extra_runs} more to see what breaks a limit first" if summary.extra_runs else ""
    return f"{whole} on the same plants ({drawn}){extra}.{missing}"


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


MOST_ROWS = 5
"""Parameters of one controller in a table of the terminal; the page has all."""


def summary_tables(summary: SweepSummary) -> list[Table]:
    """Quantiles of each metric, what runs met, what each parameter does, which breaks a limit first."""
    tables = [quantile_table(summary, words) for words in summary.focus]
    tables += [event_table(summary), influence_table(summary)]
    tables += [index_table(summary)] if summary.study.method == "saltelli" else []
    return tables + ([outward_table(summary)] if any(one.outwards for one in summary.controllers.values()) else [])


def quantile_table(summary: SweepSummary, words: MetricWords) -> Table:
    """Share of the runs inside the limit, and quantiles over the runs, each with its interval."""
    figures = {name: one.metrics[words.name] for name, one in summary.controllers.items()}
    first = next(iter(figures.values()))
    side, sign = ("at most", "<=") if words.worse > 0 else ("at least", ">=")
    heads = [f"{100 * x.share:g} % {side}" if x.share != 0.5 else "median" for x in first.quantiles]
    limit = f"{sign} {value_text(words, words.worse * (first.bound or 0.0))} kept" if first.within is not None else ""
    rows = [
        (name, str(one.sample.size), *([share_text(one.within, summary.is_sample)] if one.within is not None else []),
         *(quantile_text(words, found, summary.is_sample) for found in one.quantiles))
        for name, one in figures.items()
    ]  # fmt: skip
    headings = ("controller", "runs", *filter(None, [limit]), *heads)
    return Table(f"{words.title} [{words.unit}]", headings, rows)


def event_table(summary: SweepSummary) -> Table:
    """Shares of the runs that keep all limits, that went to `simulate`, and why; whose torque was cut."""
    names = list(dict.fromkeys(event for one in summary.controllers.values() for event in one.events))
    limited = any(one.within is not None for one in summary.controllers.values())
    rows = [
        (name, *([share_text(one.within, summary.is_sample)] if one.within is not None else []),
         *(share_text(one.events[event], summary.is_sample) if event in one.events else OPEN for event in names))
        for name, one in summary.controllers.items()
    ]  # fmt: skip
    return Table("Of the runs", ("controller", *(["all limits kept"] if limited else []), *names), rows)


def influence_table(summary: SweepSummary) -> Table:
    """The parameters with the largest effect on a quantile of the first metric: its least and its largest part."""
    words, rows = summary.focus[0], []
    for name, figures in summary.controllers.items():
        for one in figures.metrics[words.name].influence[:MOST_ROWS]:
            ends = [
                text
                for part in (one.best, one.worst)
                for text in (part_words(part.low, part.high, one.extent), value_text(words, part.estimate.value))
            ]
            clear = f"or {', '.join(one.along)}" if one.along else "yes" if one.is_clear else "no"
            rho = "" if one.correlation is None else hundredths(words.worse * one.correlation.value, "+")
            rows.append((name, one.path, *ends, clear, rho))
    heads = ("controller", "parameter", "best part", "there", "worst part", "there", "clear", "rank correlation")
    title = f"{100 * TORNADO:g} % quantile of {words.title} [{words.unit}], runs cut by each parameter"
    return Table(title, heads, rows)


def part_words(low: float | str, high: float | str, whole: float = 0.0) -> str:
    """The values of a part, rounded to a thousandth of the `whole` range of the parameter.

    >>> part_words(0.0001, 1.4, 7.0), part_words(2.0, 2.0), part_words("printed", "printed")
    ('0 to 1.4', '2', 'printed')
    """
    digits = 2 - floor(log10(whole)) if whole > 0.0 else 12
    ends = [end if isinstance(end, str) else f"{round(end, digits) + 0.0:.4g}" for end in (low, high)]
    return ends[0] if low == high else " to ".join(ends)


def index_table(summary: SweepSummary) -> Table:
    """Sobol indices of the first metric, each with its interval."""
    words, rows = summary.focus[0], []
    for name, figures in summary.controllers.items():
        found = figures.metrics[words.name].indices
        if found is not None:
            rows += [
                (name, path, index_text(found.first[path]), index_text(found.total[path]), str(found.groups))
                for path in found.total
            ]
    title = f"Sobol indices of {words.title}: shares of its variance [95 % intervals by bootstrap]"
    return Table(title, ("controller", "parameter", "alone", "with interactions", "groups"), rows)


def index_text(one: IntervalEstimate) -> str:
    """An index with its interval in brackets."""
    return f"{hundredths(one.value)} [{hundredths(one.low)} to {hundredths(one.high)}]"


def outward_table(summary: SweepSummary) -> Table:
    """Where each parameter alone, from its nominal value outwards, breaks a limit; the first one in front."""
    rows: list[tuple[str, ...]] = []
    for name, figures in summary.controllers.items():
        search = figures.outwards
        if search is None:
            continue
        if search.at_nominal:
            rows.append((name, "none", "", "broken as modelled", ", ".join(search.at_nominal)))
        elif not search.broken:
            rows.append((name, "none", "their ends", "", ""))
        for line in search.broken[:MOST_ROWS]:
            at = f"{line.broken:.4g} ({100 * (line.share or 0.0):.0f} % of the way)"
            rows.append((name, line.path, f"{line.kept:.4g}", at, line.metric or ""))
    heads = ("controller", "parameter", "kept up to", "broken at", "limit")
    return Table("Each parameter alone, from its nominal value outwards", heads, rows)
