"""Runs -> figures: joint error, velocity error, torque against limits, the path against what was asked.

Figures are made without pyplot, so nothing global changes; the same runs give the same bytes.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lwr_dyn.arrays import Array
from lwr_dyn.errors import OptionError
from lwr_dyn.files import write_file
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.viewer.replayed_runs import ReplayedRun, replayed_runs

_HOUSE_STYLE = {
    "svg.hashsalt": "lwr_dyn",
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
}
_JOINT_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#7f7f7f")
"""Okabe and Ito's palette, which people with a colour deficiency tell apart."""
in_house_style = style.context(["default", _HOUSE_STYLE])
"""Decorator: while a figure is made or written, matplotlib's defaults and ours hold instead of the user's settings."""
_DPI = 150
_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


@in_house_style
def position_error_figure(
    runs: Sequence[Run], arms: Arm | Sequence[Arm], labels: Sequence[str] | None = None
) -> Figure:
    """Joint position errors q_ref - q [mrad, mm] over time, one panel per run; raises as `replayed_runs`."""
    shown = replayed_runs(runs, arms, labels)
    errors = [1e3 * (one.run.q_ref - one.run.q) for one in shown]
    return _joint_panels(shown, errors, "position error", "")


@in_house_style
def velocity_error_figure(
    runs: Sequence[Run], arms: Arm | Sequence[Arm], labels: Sequence[str] | None = None
) -> Figure:
    """Joint velocity errors dq_ref - dq [mrad/s, mm/s] over time, one panel per run; raises as `replayed_runs`."""
    shown = replayed_runs(runs, arms, labels)
    errors = [1e3 * (one.run.dq_ref - one.run.dq) for one in shown]
    return _joint_panels(shown, errors, "velocity error", "/s")


@in_house_style
def torque_figure(runs: Sequence[Run], arms: Arm | Sequence[Arm], labels: Sequence[str] | None = None) -> Figure:
    """Applied torques [N m, N] of all runs, one panel per joint, limits as broken lines; raises as `replayed_runs`."""
    shown = replayed_runs(runs, arms, labels)
    arm = max((one.arm for one in shown), key=lambda a: a.n)
    rows = -(-arm.n // 2)
    figure = Figure(figsize=(9.0, 1.0 + 1.55 * rows), layout="constrained")
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False).ravel()
    for j, joint in enumerate(arm.joints()):
        panel = grid[j]
        for one in (one for one in shown if one.arm.n > j):
            panel.plot(one.run.t, one.run.tau_applied[:, j], color=one.colour, linewidth=1.0, label=one.label)
        if joint.limits.effort is not None:
            for sign in (-1.0, 1.0):
                panel.axhline(sign * joint.limits.effort, color="#c92a2a", linestyle="--", linewidth=0.9)
        unit = "N m" if joint.kind is JointKind.REVOLUTE else "N"
        note = "limit not known" if joint.limits.effort is None else f"limit {joint.limits.effort:g} {unit}"
        panel.set_title(f"{joint.name} ({note})", fontsize=9, loc="left")
        _dressed(panel, f"[{unit}]")
    for panel in grid[arm.n :]:
        panel.set_visible(False)
    for panel in grid[max(0, arm.n - 2) : arm.n]:
        panel.tick_params(labelbottom=True)
    for panel in grid[max(0, arm.n - 2) : arm.n]:
        panel.set_xlabel("time [s]", fontsize=9)
    figure.suptitle("applied torque and its limits")
    figure.legend(*grid[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(shown), frameon=False)
    return figure


@in_house_style
def path_figure(
    runs: Sequence[Run], arms: Arm | Sequence[Arm], labels: Sequence[str] | None = None, plane: str | None = None
) -> Figure:
    """The path of the flange in a plane of the base [m], against what was asked.

    Parameters
    ----------
    runs, arms, labels
        As `replayed_runs`, and raises as it does.
    plane : {"xy", "xz", "yz"}, optional
        The one in which the reference is widest, if not given.

    Raises
    ------
    OptionError
        A plane of another name.
    """
    if plane is not None and plane not in _PLANES:
        raise OptionError("plane", repr(plane), ", ".join(_PLANES))
    shown = replayed_runs(runs, arms, labels)
    chosen = plane or widest_plane(shown[0].reference_path)
    a, b = _PLANES[chosen]
    figure = Figure(figsize=(6.4, 6.4), layout="constrained")
    panel = figure.subplots()
    for one in shown:
        points = one.reference_path
        panel.plot(points[:, a], points[:, b], color="#343a40", linewidth=2.6, alpha=0.35, label="reference")
    for one in shown:
        points = one.pose[:, :3, 3]
        panel.plot(points[:, a], points[:, b], color=one.colour, linewidth=1.1, label=one.label)
    panel.set_aspect("equal", adjustable="datalim")
    panel.set_xlabel(f"{chosen[0]} [m]")
    _dressed(panel, f"{chosen[1]} [m]")
    handles, names = panel.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside lower center", ncols=len(unique), frameon=False)
    figure.suptitle("path of the flange")
    return figure


def widest_plane(points: Array) -> str:
    """The coordinate plane that drops the axis in which points (m, 3) spread least.

    >>> widest_plane(np.array([[0.0, 0.0, 0.0], [0.1, 1.0, 2.0]]))
    'yz'
    """
    dropped = int(np.argmin(np.ptp(points, axis=0)))
    return ("yz", "xz", "xy")[dropped]


@in_house_style
def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as "png" or "svg"; the same figure gives the same bytes, whatever the user's matplotlib settings."""
    if kind not in ("png", "svg"):
        raise OptionError("kind", repr(kind), "png, svg")
    out = io.BytesIO()
    metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
    figure.savefig(out, format=kind, dpi=_DPI, metadata=metadata)
    return out.getvalue()


def save_figure(figure: Figure, path: str | Path) -> tuple[Path, Path]:
    """Write `path`.png and `path`.svg (a suffix given is replaced); returns both, raises `FileAccessError`."""
    targets = Path(path).with_suffix(".png"), Path(path).with_suffix(".svg")
    for target in targets:
        write_file(target, figure_bytes(figure, target.suffix[1:]))
    return targets


def _joint_panels(shown: Sequence[ReplayedRun], series: Sequence[Array], what: str, per: str) -> Figure:
    figure = Figure(figsize=(9.0, 1.1 + 2.5 * len(shown)), layout="constrained")
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False).ravel()
    for panel, one, values in zip(panels, shown, series, strict=True):
        kinds = [link.kind for link in one.arm.chain.links]
        units = [f"mrad{per}" if kind is JointKind.REVOLUTE else f"mm{per}" for kind in kinds]
        for j, name in enumerate(one.arm.joint_names):
            colour = _JOINT_COLOURS[j % len(_JOINT_COLOURS)]
            panel.plot(one.run.t, values[:, j], color=colour, linewidth=1.0, label=name)
        panel.set_title(one.label, fontsize=10, loc="left")
        panel.axhline(0.0, color="#868e96", linewidth=0.6)
        _dressed(panel, f"{what} [{', '.join(dict.fromkeys(units))}]")
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=8)
    panels[-1].set_xlabel("time [s]")
    return figure


def _dressed(panel: Axes, label: str) -> None:
    panel.set_ylabel(label)
    panel.grid(True, color="#dee2e6", linewidth=0.6)
    for side in ("top", "right"):
        panel.spines[side].set_visible(False)
