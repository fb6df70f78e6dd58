"""Data for the scripts of a report: the runs at 100 samples a second, packed once for 3D view and figures; figures."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, cast

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay import scene
from lwr_dyn.pages.replay.figures import Curve, Figure, Series, SeriesName, run_series
from lwr_dyn.pages.replay.page_parts import generator_line, pack_int32, subsample
from lwr_dyn.pages.replay.replay_page import RATE, run_record
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs
from lwr_dyn.reproduction.report.content import Page, Replay, Still

LARGEST_CURVE = 1500
"""Points of a curve given as numbers; of longer ones points are left out."""
_AS_TEXT = 48
"""Shorter curves are written as decimal numbers."""
_FROM_PLAYER: tuple[SeriesName, ...] = ("q", "q_ref", "position error", "tip error")
"""Quantities that the player's own series hold."""


def script_data(page: Page) -> dict[str, Any]:
    """Runs, stills, arms and figures of a page; raises `OptionError` for a series of no run or joint of the page."""
    figures, replay = all_figures(page), page.replay
    series = [one for figure in figures for curve in figure.curves for one in curve.series]
    for one in series:
        one.values(replay.runs if replay else ())  # raises for a run or joint that is not there
    pool: dict[bytes, Array] = {}
    data: dict[str, Any] = {"figures": [_figure(figure, pool) for figure in figures]}
    data |= {"numbers": [_numbers(values) for values in pool.values()]}
    return data if replay is None else data | _replay(replay, series)


def all_figures(page: Page) -> tuple[Figure, ...]:
    """The figures of a page in their order on it: beside the replay, then section by section."""
    return (*page.figures, *(figure for section in page.sections for figure in section.figures))


def _replay(replay: Replay, series: Sequence[Series]) -> dict[str, Any]:
    """The runs with the series that the player does not hold, the stills, and the arms."""
    packed = [
        {
            name: run_series(one, name)
            for name in dict.fromkeys(name for s in series if s.run == i for name in _needed(s))
            if name not in _FROM_PLAYER
        }
        for i, one in enumerate(replay.runs)
    ]
    stills = [_still(still) for still in replay.stills]
    records = [_run(one, page_stride(one.run), more) for one, more in zip(replay.runs, packed, strict=True)]
    shapes = [command for i, one in enumerate([*replay.runs, *stills]) for command in scene.arm_commands(one, i)]
    return {
        "runs": records,
        "stills": [run_record(one) | {"note": still.note} for one, still in zip(stills, replay.stills, strict=True)],
        "scene": shapes,
        "made_by": generator_line(),
        "start": {"trace": True, "frames": False, "beside": False},
    }


def _needed(series: Series) -> tuple[SeriesName, ...]:
    """The quantities behind a series: a path with its errors magnified takes its reference too."""
    quantity = series.quantity
    reference = quantity.replace("flange", "reference") if quantity.startswith("flange ") else quantity
    return quantity, cast(SeriesName, reference)


def page_stride(run: Run) -> int:
    """Which samples of a run a page has: every so many, for at least `RATE` a second."""
    lasts = float(run.t[-1] - run.t[0])
    return 1 if lasts == 0.0 else max(1, int((run.t.size - 1) / lasts / RATE + 1e-6))


def _run(one: ReplayedRun, stride: int, more: Mapping[SeriesName, Array]) -> dict[str, Any]:
    keep = subsample(one.run.t.size, stride)
    return run_record(one, stride) | {"series": {name: pack_int32(values[keep]) for name, values in more.items()}}


def _still(still: Still) -> ReplayedRun:
    """A pose as a run of one sample."""
    q = np.asarray(still.q, dtype=np.float64)[None, :]
    nothing, zero = np.zeros_like(q), np.zeros(1)
    run = Run(zero, q, nothing, q, nothing, nothing, nothing, nothing, zero, {})
    return replayed_runs([run], still.arm, [still.label])[0]


def _figure(figure: Figure, pool: dict[bytes, Array]) -> dict[str, Any]:
    panels = []
    for panel in figure.panels:
        curves = [_curve(figure, curve, pool) for curve in panel.curves]
        panels.append(_fields(panel) | {"curves": curves, "levels": [_fields(level) for level in panel.levels]})
    return _fields(figure) | {"panels": panels}


def _curve(figure: Figure, curve: Curve, pool: dict[bytes, Array]) -> dict[str, Any]:
    size = 1 if isinstance(curve.y, Series) else curve.y.size
    keep = subsample(size, -(-size // LARGEST_CURVE))
    x, y = (_source(value, keep, pool) for value in (curve.x, curve.y))
    text = [curve.text[i] for i in keep] if curve.text else []
    return _fields(curve) | {"x": x, "y": y, "text": text}


def _fields(record: Any) -> dict[str, Any]:
    """The fields of a record of `viewer.figures`, as they are."""
    return {field.name: getattr(record, field.name) for field in fields(record)}


def _source(values: Array | Series | None, keep: Any, pool: dict[bytes, Array]) -> Any:
    """A series by its name, numbers by their place in the pool, which keeps the same numbers once."""
    if isinstance(values, Series):
        return _fields(values)
    if values is None:
        return None
    kept = values[keep]
    pool.setdefault(kept.tobytes(), kept)
    return list(pool).index(kept.tobytes())


def _numbers(values: Array) -> Any:
    """Numbers as a list with null for a gap, or packed with the places of its gaps."""
    gaps = np.flatnonzero(~np.isfinite(values))
    if values.size <= _AS_TEXT:
        return [float(x) if np.isfinite(x) else None for x in values]
    return pack_int32(np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)) | {"gaps": gaps.tolist()}
