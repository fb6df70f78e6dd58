"""Torque against prediction: a row a joint with what was measured, what the fit predicts, and below what is left."""

from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.report.line_plane import band_path, grid_path, line_path, plane_html
from lwr_dyn.pages.plotting.axes import Axis, axis_of, round_length, short
from lwr_dyn.pages.plotting.charts import tick_marks

SIGMAS = 3.0
"""Half-width of the band of noise behind what is left."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownRecording:
    """One recording: t (k,) [s] from its first row; measured and predicted torques (k, n) [N m or N]; q (k, n).

    `used` (k, n) are the equations that the fit saw.
    """

    source: str
    t: Array
    q: Array
    measured: Array
    predicted: Array
    used: NDArray[np.bool_]

    def __post_init__(self) -> None:
        freeze_arrays(self, "t", "q", "measured", "predicted")

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.t[-1] - self.t[0])


def torque_rows_html(one: ShownRecording, noise: Array, joints: tuple[str, ...], units: tuple[str, ...]) -> str:
    """The rows of a recording.

    Parameters
    ----------
    one : ShownRecording
    noise : (n,) array
        Standard deviation of the torques as the fit found it [N m or N].
    joints, units : tuple of str
        Name of each joint, unit of its torque.
    """
    across = axis_of(one.t, most=8, padding=0.0)
    rows = "".join(_row(one, j, float(noise[j]), joints[j], units[j], across) for j in range(len(joints)))
    foot = f'<div class="trow foot"><div></div><div class="area"><div class="yt"></div>{_seconds(across)}</div></div>'
    return f'<div class="torques" data-low="{across.low:.6g}" data-high="{across.high:.6g}">{rows}{foot}</div>'


def _seconds(across: Axis) -> str:
    return tick_marks(across, "xt", "left", "s")


def _row(one: ShownRecording, j: int, noise: float, joint: str, unit: str, across: Axis) -> str:
    measured, predicted, used = one.measured[:, j], one.predicted[:, j], one.used[:, j]
    left = np.where(used, measured - predicted, np.nan)
    up = axis_of(np.concatenate([measured, predicted]), most=4)
    wide = SIGMAS * noise if np.isfinite(noise) else 0.0
    reach = max(float(np.nanmax(np.abs(left), initial=0.0)), wide) or 1.0
    end = round_length(reach)
    below = Axis(-1.1 * reach, 1.1 * reach, (-end, 0.0, end))
    rms, peak = rms_of(left), largest_of(left)
    label = (
        f"{joint}: torque at most {said(largest_of(measured), unit)}; measured less predicted has an RMS "
        f"of {said(rms, unit)} and reaches {said(peak, unit)}"
    )
    lines = [
        grid_path(None, up), line_path(one.t, measured, across, up, "ref"),
        line_path(one.t, predicted, across, up, "r1"),
    ]  # fmt: skip
    ends = np.array([across.low, across.high])
    rest = [
        band_path(ends, np.full(2, -wide), np.full(2, wide), across, below, "band"),
        grid_path(None, below), line_path(one.t, left, across, below, "left"),
    ]  # fmt: skip
    facts = (("RMS left", rms), ("noise", noise), ("largest", peak))
    listed = "".join(f"<li><span>{name}</span> <b>{said(value, unit)}</b></li>" for name, value in facts)
    two = (
        f'<div class="area">{tick_marks(up, "yt", "top")}{plane_html(label, lines, "torque")}'
        f"{tick_marks(below, 'yt', 'top')}{plane_html(f'{joint}: measured less predicted torque', rest, 'rest')}</div>"
    )
    who = f'<div class="who"><h3>{escape(joint)}</h3><ul class="figures">{listed}</ul></div>'
    return f'<div class="trow">{who}{two}</div>'


def said(value: float, unit: str) -> str:
    """A number with its unit; "none" where nothing is known.

    >>> said(0.25, "N m"), said(float("nan"), "N m")
    ('0.25 N m', 'none')
    """
    return f"{short(value)} {unit}" if np.isfinite(value) else "none"


def largest_of(values: Array) -> float:
    """The largest magnitude of the finite values; NaN of none."""
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if finite.size else float("nan")


def rms_of(values: Array) -> float:
    """Root mean square of the finite values; NaN of none.

    >>> rms_of(np.array([3.0, np.nan, -3.0]))
    3.0
    """
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(np.square(finite)))) if finite.size else float("nan")


KEY = (
    '<ul class="key"><li><i class="sw ref"></i>measured</li><li><i class="sw r1"></i>predicted</li>'
    '<li><i class="sw left"></i>measured less predicted, where the fit used it</li>'
    '<li><i class="sw band"></i>3 sigma of the noise</li></ul>'
)
"""What the lines are."""
