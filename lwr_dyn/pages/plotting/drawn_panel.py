"""A panel of a figure, ready to draw: its curves as numbers with their colours, and axes that follow the data."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import short
from lwr_dyn.pages.figures import figure as axes
from lwr_dyn.pages.figures.figure import GREY, Axis, Curve, Figure, Level, Panel, Series
from lwr_dyn.pages.plotting.line_plane import extremes, grid_path, places, plane_html, tick_marks
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

NEAR_LEVEL = 1.5
"""A level is drawn when it is at most so many times as far from zero as the data; otherwise it is said in words."""

LIMIT = "limit"
"""The label of levels that a gauge can stand for."""

FAR_APART = 30.0
"""Tip errors of runs that differ by more than this factor get a logarithmic axis."""

FREQUENCY = "Hz"
"""The unit of x that has a logarithmic axis."""

ROUNDING = 1e-9
"""Of a level, such as a limit: curves that stay below this share of it are drawn as the zero that they are,"""

_AROUND_ZERO = 1e-3
"""on an axis over this share of it."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnCurve:
    """A curve as numbers; `ink` is the name of its colour on a page: "r1" to "r5" of a run, "ref", "ink" or "soft"."""

    curve: Curve
    x: Array
    y: Array
    ink: str
    swing: float
    """Its largest magnitude; of a path its largest error."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnPanel:
    """A panel with its curves and axes; `levels` are those within the axes, `far` those that words must say."""

    panel: Panel
    curves: tuple[DrawnCurve, ...]
    x: Axis
    y: Axis
    levels: tuple[Level, ...]
    far: tuple[Level, ...]
    magnified: int = 1
    """How many times as large as they are the errors of a path are drawn."""

    @property
    def peak(self) -> float:
        """The largest magnitude of the curves."""
        sizes = [np.nanmax(np.abs(one.y)) for one in self.curves if one.ink != "ref" and np.isfinite(one.y).any()]
        return float(max(sizes, default=0.0))

    @property
    def limit(self) -> float | None:
        """The limit of what is drawn, if a level states it."""
        return max((abs(level.value) for level in self.panel.levels if level.label == LIMIT), default=None)


def run_ink(run: ReplayedRun) -> str:
    """The name of a run's colour on a page: "r1" to "r4", "r5" for the grey of all others."""
    return f"r{min(run.place, 4) + 1}"


def drawn_panels(figure: Figure, runs: Sequence[ReplayedRun]) -> tuple[DrawnPanel, ...]:
    """The panels of a figure; panels over time share their time axis. Raises `OptionError` as `Curve.points`."""
    factor = magnification(figure, runs)
    drawn = [[_drawn(figure, panel, k, runs, factor) for k in range(len(panel.curves))] for panel in figure.panels]
    over = np.concatenate([one.x for curves in drawn for one in curves])
    most = 3 if len(figure.panels) > 3 else 8
    time = axes.axis_of(over, most, padding=0.0)
    return tuple(
        _panel(figure, panel, curves, time if figure.over_time else None, factor)
        for panel, curves in zip(figure.panels, map(tuple, drawn), strict=True)
    )


def magnification(figure: Figure, runs: Sequence[ReplayedRun]) -> int:
    """How much larger a path figure draws its errors: by 10, 100, 1000, up to 15 % of the path's extent."""
    paths = [curve for curve in figure.curves if _is_path(curve)]
    if not (figure.equal_aspect and paths):
        return 1
    wanted = [np.column_stack([_reference(axis, runs) for axis in curve.series]) for curve in paths]
    errors = [np.column_stack(c.points(runs)) - ref for c, ref in zip(paths, wanted, strict=True)]
    largest = max(float(np.hypot(*error.T).max()) for error in errors)
    extent = max(float(np.ptp(ref, axis=0).max()) for ref in wanted)
    return next((m for m in (1000, 100, 10) if m * largest <= 0.15 * extent), 1)


def _is_path(curve: Curve) -> bool:
    return len(curve.series) == 2 and all(one.quantity.startswith("flange ") for one in curve.series)


def _reference(series: Series, runs: Sequence[ReplayedRun]) -> Array:
    """Where the run should be, for a series of where it is."""
    pose = runs[series.run].pose_ref
    return series.scale * np.asarray(pose[:, "xyz".index(series.quantity[-1]), 3])


def _drawn(figure: Figure, panel: Panel, k: int, runs: Sequence[ReplayedRun], factor: int) -> DrawnCurve:
    curve = panel.curves[k]
    x, y = curve.points(runs)
    swing = float(np.nanmax(np.abs(y), initial=0.0))
    if _is_path(curve):
        wanted = [_reference(one, runs) for one in curve.series]
        swing = float(np.hypot(x - wanted[0], y - wanted[1]).max())
        x, y = (ref + factor * (is_at - ref) for ref, is_at in zip(wanted, (x, y), strict=True))
    return DrawnCurve(curve, x, y, _ink(figure, panel, k, runs), swing)


def _ink(figure: Figure, panel: Panel, k: int, runs: Sequence[ReplayedRun]) -> str:
    curve = panel.curves[k]
    if curve.is_reference or curve.colour == GREY:
        return "ref"
    if isinstance(curve.y, Series):
        before = (c for c in panel.curves[:k] if not c.is_reference)
        again = any(isinstance(c.y, Series) and c.y.run == curve.y.run for c in before)
        return "soft" if again else run_ink(runs[curve.y.run])
    if curve.colour is not None and not curve.is_filled:
        return f"r{min(curve.colour, 4) + 1}"
    return "ink" if figure.labels.index(curve.label) == 0 else "soft"


def _panel(figure: Figure, panel: Panel, curves: tuple[DrawnCurve, ...], time: Axis | None, factor: int) -> DrawnPanel:
    across, up = (np.concatenate([getattr(one, axis) for one in curves]) for axis in "xy")
    near = tuple(level for level in panel.levels if is_near(level, across if level.axis == "x" else up))
    far = tuple(level for level in panel.levels if level not in near)
    up = np.append(up, [level.value for level in near if level.axis == "y"])
    across = np.append(across, [level.value for level in near if level.axis == "x"])
    largest = max((abs(level.value) for level in far if level.axis == "y"), default=0.0)
    if np.nanmax(np.abs(up), initial=0.0) < ROUNDING * largest:
        up = np.append(up, [-_AROUND_ZERO * largest, _AROUND_ZERO * largest])
    x = time or (axes.frequency_axis(across) if figure.x_unit == FREQUENCY else axes.axis_of(across))
    y = _vertical(figure, curves, up)
    if figure.equal_aspect:
        x, y = _same_scale(across, up)
    return DrawnPanel(panel, curves, x, y, near, far, factor)


def _vertical(figure: Figure, curves: Sequence[DrawnCurve], values: Array) -> Axis:
    drawn = [one.curve.y for one in curves]
    are_distances = all(isinstance(y, Series) and y.quantity == "tip error" for y in drawn)
    if len(figure.panels) == 1 and len(curves) > 1 and are_distances:
        peaks = [float(one.y.max()) for one in curves]
        if min(peaks) > 0.0 and max(peaks) > FAR_APART * min(peaks):
            return axes.logarithmic_axis(values)
    return axes.axis_of(values)


def _same_scale(across: Array, up: Array) -> tuple[Axis, Axis]:
    """Both axes as long as the longer one."""
    spans = [(float(np.nanmin(v)), float(np.nanmax(v))) for v in (across, up)]
    side = max(high - low for low, high in spans)
    middle = [0.5 * (low + high) for low, high in spans]
    x, y = (axes.axis_of(np.array([m - 0.5 * side, m + 0.5 * side])) for m in middle)
    return x, y


def is_near(level: Level, data: Array) -> bool:
    """Whether a level is at most `NEAR_LEVEL` times as far from zero as the data on its side."""
    finite = data[np.isfinite(data)]
    low, high = float(finite.min()), float(finite.max())
    if low <= level.value <= high:
        return True
    return NEAR_LEVEL * low <= level.value < 0.0 if level.value < 0.0 else 0.0 <= level.value <= NEAR_LEVEL * high


def widest_first(panel: DrawnPanel) -> list[DrawnCurve]:
    """References first, then what swings most, so that nothing is hidden under a wider line."""
    return sorted(panel.curves, key=lambda one: (one.ink != "ref", -one.swing))


POINTS = 400
"""Stretches of a line; of each its lowest and highest point are drawn."""

_APART = 0.09
"""Least distance of names at the ends of lines, of the plane's height."""


def chart_html(figure: Figure, runs: Sequence[ReplayedRun]) -> str:
    """A figure with its heading, axes, lines and the names of the lines."""
    (panel,) = drawn_panels(figure, runs)
    about = [panel.panel.y_unit] if figure.over_time else [_errors(panel)]
    about += ["logarithmic"] if panel.y.is_logarithmic else []
    head = f"<figcaption><h3>{escape(figure.title)} <small>{escape(', '.join(about))}</small></h3></figcaption>"
    lines = [grid_path(None, panel.y) if figure.over_time else ""]
    for one in widest_first(panel):
        keep = extremes(one.y, POINTS) | extremes(one.x, POINTS)
        points = " ".join(f"{a},{b}" for a, b in places(one.x[keep], one.y[keep], panel.x, panel.y))
        lines.append(f'<path class="{one.ink}" d="M{points}"/>')
    plane = plane_html(_description(figure, panel), lines)
    if not figure.over_time:
        return f'<figure class="path">{head}{plane}{_scale(panel)}</figure>'
    up, across = tick_marks(panel.y, "yt", "top"), tick_marks(panel.x, "xt", "left", "s")
    names = "".join(f'<li><i class="sw {one.ink}"></i>{escape(one.curve.label)}</li>' for one in panel.curves)
    area = f'<div class="area">{up}{plane}{_ends(panel)}{across}</div>'
    return f'<figure>{head}{area}<ul class="names">{names}</ul></figure>'


def _errors(panel: DrawnPanel) -> str:
    return f"errors \u00d7 {panel.magnified}" if panel.magnified > 1 else "true to scale"


def _ends(panel: DrawnPanel) -> str:
    """The names of lines at their ends, moved apart where they would overlap."""
    ends = sorted((1.0 - float(panel.y.share(float(one.y[-1]))), one.ink, one.curve.label) for one in panel.curves)
    names = "".join(
        f'<span style="top:{100 * at:.1f}%"><i class="sw {ink}"></i>{escape(label)}</span>'
        for at, (_, ink, label) in zip(axes.apart([end[0] for end in ends], _APART), ends, strict=True)
    )
    return f'<div class="ends">{names}</div>'


def _scale(panel: DrawnPanel) -> str:
    """A length on the path, and a length of its errors."""
    whole = panel.x.high - panel.x.low
    items = []
    for what, factor in [("path", 1), *([("error", panel.magnified)] if panel.magnified > 1 else [])]:
        length = axes.round_length(0.25 * whole / factor)
        bar = f'<i style="width:{100 * factor * length / whole:.2f}%"></i>'
        items.append(f"<li>{bar}{what} {short(1e3 * length)} mm</li>")
    return f'<ul class="scale">{"".join(items)}</ul>'


def _description(figure: Figure, panel: DrawnPanel) -> str:
    if not figure.over_time:
        return f"{figure.title}, {_errors(panel)}: {', '.join(one.curve.label for one in panel.curves)}"
    said = [f"{one.curve.label} at most {short(float(one.y.max()) + 0.0)} {panel.panel.y_unit}" for one in panel.curves]
    return f"{figure.title}: {'; '.join(said)}"
