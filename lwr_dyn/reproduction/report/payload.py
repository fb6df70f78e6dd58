"""What the scripts of a report read: the runs, packed once for the 3D view and for the figures, and the figures."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.report.content import Page, Replay, Still
from lwr_dyn.viewer import scene
from lwr_dyn.viewer.figures import Curve, Figure, Panel, Quantity, Series
from lwr_dyn.viewer.page_parts import generator_line, pack_int32, subsample
from lwr_dyn.viewer.replay_page import run_record
from lwr_dyn.viewer.replayed_runs import ReplayedRun, replayed_runs

SERIES_BUDGET = 2_600_000
"""Bytes the series of all runs may take before compression; beyond, samples are left out, and the page says so."""
LARGEST_CURVE = 4000
"""Points of a curve given as numbers; of longer ones points are left out."""
_AS_TEXT = 48
"""Shorter curves are written as decimal numbers."""
_FROM_PLAYER: tuple[Quantity, ...] = ("q", "q_ref", "position error", "tip error")
"""Quantities that the player's own series hold."""
_AXES = "xyz"


def payload(page: Page) -> dict[str, Any]:
    """Runs, stills, arms and figures of a page; raises `OptionError` for a series of no run or joint of the page."""
    figures = all_figures(page)
    pool: dict[bytes, Array] = {}
    drawn = [_figure(figure, pool) for figure in figures]
    data: dict[str, Any] = {"figures": drawn, "numbers": [_numbers(values) for values in pool.values()]}
    replay = page.replay
    _check_series(figures, () if replay is None else replay.arms)
    if replay is not None:
        data |= _replay(replay, _quantities(figures))
    return data


def all_figures(page: Page) -> tuple[Figure, ...]:
    """The figures of a page in their order on it: beside the replay, then section by section."""
    return (*page.figures, *(figure for section in page.sections for figure in section.figures))


def _replay(replay: Replay, wanted: Mapping[int, list[Quantity]]) -> dict[str, Any]:
    runs = replayed_runs(replay.runs, replay.arms, replay.labels) if replay.runs else ()
    stills = [_still(still) for still in replay.stills]
    width = [2 * one.arm.n + 2 + sum(_series(one, name)[0].size for name in wanted[i]) for i, one in enumerate(runs)]
    samples = sum(one.run.t.size * w for one, w in zip(runs, width, strict=True))
    stride = max(1, -(-samples * 16 // 3 // SERIES_BUDGET))  # four bytes a number, a third more as base64
    records = [_run(one, stride, wanted[i]) for i, one in enumerate(runs)]
    commands = [command for i, one in enumerate([*runs, *stills]) for command in scene.arm_commands(one, i)]
    return {
        "runs": records,
        "stills": [run_record(one) | {"note": still.note} for one, still in zip(stills, replay.stills, strict=True)],
        "scene": commands,
        "made_by": generator_line(),
        "start": {"trace": True, "frames": False, "beside": False},
    }


def _run(shown: ReplayedRun, stride: int, wanted: Iterable[Quantity]) -> dict[str, Any]:
    keep = subsample(shown.run.t.size, stride)
    series = {name: pack_int32(_series(shown, name)[keep]) for name in wanted}
    return run_record(shown, stride) | {"series": series}


def _series(shown: ReplayedRun, name: Quantity) -> Array:
    """A quantity that the player does not hold, over all samples; joints last where it has joints."""
    run = shown.run
    if name.startswith(("flange ", "reference ")):
        pose = shown.pose if name.startswith("flange") else shown.pose_ref
        return np.asarray(pose[:, _AXES.index(name[-1]), 3])
    if name == "velocity error":
        return np.asarray(run.dq_ref - run.dq)
    field = {"torque": "tau_applied", "friction": "tau_friction"}.get(name, name)
    return np.asarray(getattr(run, field))


def _still(still: Still) -> ReplayedRun:
    """A pose as a run of one sample."""
    q = np.asarray(still.q, dtype=np.float64)[None, :]
    nothing, zero = np.zeros_like(q), np.zeros(1)
    run = Run(zero, q, nothing, q, nothing, nothing, nothing, nothing, zero, {})
    return replayed_runs([run], still.arm, [still.label])[0]


def _check_series(figures: Iterable[Figure], arms: tuple[Arm, ...]) -> None:
    for series in _all_series(figures):
        if not 0 <= series.run < len(arms):
            raise OptionError("run of a series", series.run, f"0 to {len(arms) - 1}" if arms else "no run on this page")
        if series.joint is not None and not 0 <= series.joint < arms[series.run].n:
            raise OptionError("joint of a series", series.joint, f"0 to {arms[series.run].n - 1}")


def _quantities(figures: Iterable[Figure]) -> defaultdict[int, list[Quantity]]:
    """What has to be packed beside the player's series, run by run."""
    found = defaultdict[int, list[Quantity]](list)
    for series in _all_series(figures):
        if series.quantity not in (*_FROM_PLAYER, *found[series.run]):
            found[series.run].append(series.quantity)
    return found


def _all_series(figures: Iterable[Figure]) -> Iterator[Series]:
    for figure in figures:
        for panel in figure.panels:
            for curve in panel.curves:
                yield from (one for one in (curve.x, curve.y) if isinstance(one, Series))


def _figure(figure: Figure, pool: dict[bytes, Array]) -> dict[str, Any]:
    return {
        "id": figure.id,
        "title": figure.title,
        "x_label": figure.x_label,
        "x_unit": figure.x_unit,
        "over_time": figure.over_time,
        "equal": figure.equal_aspect,
        "columns": figure.columns,
        "panels": [_panel(panel, pool) for panel in figure.panels],
    }


def _panel(panel: Panel, pool: dict[bytes, Array]) -> dict[str, Any]:
    return {
        "title": panel.title,
        "y_label": panel.y_label,
        "y_unit": panel.y_unit,
        "curves": [_curve(curve, pool) for curve in panel.curves],
        "levels": [[level.label, level.value, level.axis] for level in panel.levels],
    }


def _curve(curve: Curve, pool: dict[bytes, Array]) -> dict[str, Any]:
    size = 1 if isinstance(curve.y, Series) else curve.y.size
    keep = subsample(size, -(-size // LARGEST_CURVE))
    kept = [value if value is None or isinstance(value, Series) else value[keep] for value in (curve.x, curve.y)]
    return {
        "label": curve.label,
        "x": _source(kept[0], pool),
        "y": _source(kept[1], pool),
        "style": curve.style,
        "dashed": curve.dashed,
        "colour": curve.colour,
        "text": [curve.text[i] for i in keep] if curve.text else [],
    }


def _source(values: Array | Series | None, pool: dict[bytes, Array]) -> Any:
    """A series as its name, numbers as their place in the pool, where the same numbers are kept once."""
    if values is None:
        return None
    if isinstance(values, Series):
        return {"run": values.run, "of": values.quantity, "joint": values.joint, "scale": values.scale}
    pool.setdefault(values.tobytes(), values)
    return list(pool).index(values.tobytes())


def _numbers(values: Array) -> Any:
    """Numbers as a list with null for a gap, or packed with the places of its gaps."""
    gaps = np.flatnonzero(~np.isfinite(values))
    if values.size <= _AS_TEXT:
        return [float(x) if np.isfinite(x) else None for x in values]
    return pack_int32(np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)) | {"gaps": gaps.tolist()}
