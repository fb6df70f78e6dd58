"""What a search for gains has found, as text and as a record."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.studies.sweep.statistics.intervals import QuantileEstimate
from lwr_dyn.studies.sweep.tuning.gain_box import values_of
from lwr_dyn.studies.sweep.tuning.tune import TunedGains

FRONT_ROWS = 8
"""Rows of the front that the text shows; the record has all."""


def tuned_text(found: TunedGains, title: str) -> str:
    """The search, its judgement on other runs, and the front."""
    n, size = found.candidates, found.size
    limit = (
        f"; the same quantile of the torque use at most {100 * found.bound:.3g} %" if np.isfinite(found.bound) else ""
    )
    lines = [
        f"{title}, {found.controller}: {', '.join(f'{g.name} {g.low:g} to {g.high:g}' for g in found.gains)}",
        f"aim: least {found.aim.words}{limit}",
        f"search: differential evolution, {n} candidates, each on the same {size.runs} runs, seed {size.seed}",
    ]
    if size.runs * (1.0 - found.aim.share) < 1.0:
        lines.append(f"of {size.runs} runs, the {100 * found.aim.share:g} % quantile is the worst")
    if not found.keeps_bound:
        lines.append("no candidate keeps the bound: the one that misses it by the least is shown")
    check = found.check
    return "\n".join(
        [
            *lines,
            "",
            _judged(found).text(),
            f"found / given: {check.ratio.value:.3g} ({check.ratio.low:.3g} to {check.ratio.high:.3g}); "
            f"less error in {100 * check.better.value:.3g} % of the runs: {check.words}",
            *([] if found.holds else ["on these runs the bound is NOT kept: more --runs find gains that keep it"]),
            "",
            _front(found).text(),
        ]
    )


def tuned_record(found: TunedGains) -> dict[str, Any]:
    """As JSON values, in SI units."""
    paths = [gain.path for gain in found.gains]
    front = found.trace.front
    table = values_of(found.gains, found.trace.points[front])
    check = found.check
    return {
        "controller": found.controller,
        "gains": {g.path: {"low": g.low, "high": g.high} for g in found.gains},
        "aim": {"metric": found.aim.metric.name, "share": found.aim.share},
        "torque_share": found.bound,
        "search": {
            "candidates": found.candidates,
            "runs": found.size.runs,
            "seed": found.size.seed,
            "aim": float(found.trace.aim[found.best]),
            "torque_use": float(found.trace.use[found.best]),
            "keeps_bound": found.keeps_bound,
        },
        "given": dict(zip(paths, found.given.tolist(), strict=True)),
        "found": dict(zip(paths, found.values.tolist(), strict=True)),
        "check": {
            "runs": check.given.runs,
            "level": check.given.level,
            "given": _estimates(check.given, check.given_use),
            "found": _estimates(check.found, check.found_use),
            "ratio": {"value": check.ratio.value, "low": check.ratio.low, "high": check.ratio.high},
            "better": {"value": check.better.value, "low": check.better.low, "high": check.better.high},
            "keeps_bound": found.holds,
            "verdict": check.words,
        },
        "front": [
            {"gains": dict(zip(paths, row.tolist(), strict=True)), "aim": aim, "torque_use": use}
            for row, aim, use in zip(
                table, found.trace.aim[front].tolist(), found.trace.use[front].tolist(), strict=True
            )
        ],
    }


def _estimates(aim: QuantileEstimate, use: QuantileEstimate) -> Mapping[str, Any]:
    pairs = {"aim": aim, "torque_use": use}
    return {name: {"value": x.value, "low": x.low, "high": x.high} for name, x in pairs.items()}


def _judged(found: TunedGains) -> Table:
    """The two sets of gains on the runs that the search has not seen."""
    metric, check = found.aim.metric, found.check
    rows = [
        (name, *(None if np.isnan(x) else x for x in gains), _interval(aim, metric.factor), _interval(use, 100.0))
        for name, gains, aim, use in (
            ("given", found.given, check.given, check.given_use),
            ("found", found.values, check.found, check.found_use),
        )
    ]
    headings = [
        Heading("gains"), *(Heading(gain.name, format=".4g") for gain in found.gains),
        Heading(f"{metric.title}, {100 * found.aim.share:g} %", metric.unit), Heading("torque use", "%"),
    ]  # fmt: skip
    level = f"{100 * check.given.level:g} %"
    return Table(f"on {check.given.runs} runs that the search has not seen, intervals of {level}", headings, rows)


def _interval(one: QuantileEstimate, factor: float) -> str:
    value, low, high = (factor * x for x in (one.value, one.low, one.high))
    return f"{value:.4g} ({'-' if np.isinf(low) else f'{low:.4g}'} to {'-' if np.isinf(high) else f'{high:.4g}'})"


def _front(found: TunedGains) -> Table:
    """Some candidates of the front, evenly along it; the found one is marked."""
    front, metric = found.trace.front, found.aim.metric
    chosen = front[np.unique(np.linspace(0, len(front) - 1, FRONT_ROWS).round().astype(int))] if front.size else front
    shown = np.unique(np.append(chosen, found.best) if found.best in front else chosen)
    shown = shown[np.argsort(found.trace.use[shown], kind="stable")]
    rows = [
        (
            *values_of(found.gains, found.trace.points[[i]])[0].tolist(), metric.factor * found.trace.aim[i],
            100.0 * found.trace.use[i], "found" if i == found.best else "",
        )
        for i in shown
    ]  # fmt: skip
    headings = [
        *(Heading(gain.name, format=".4g") for gain in found.gains),
        Heading(f"{metric.title}, {100 * found.aim.share:g} %", metric.unit, ".4g"),
        Heading("torque use", "%", ".4g"), Heading(""),
    ]  # fmt: skip
    title = f"Pareto front of the candidates, on the runs of the search: {len(rows)} of {len(front)}"
    return Table(title, headings, rows)
