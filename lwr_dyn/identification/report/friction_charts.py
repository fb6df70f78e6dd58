"""Friction maps: what is left of the torques without the bodies, over speed, and the friction fitted to it."""

from collections.abc import Sequence
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.report.line_plane import dots_path, grid_path, line_path, plane_html
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.pages.plotting.axes import axis_of, short
from lwr_dyn.pages.plotting.charts import tick_marks

DOTS = 600
"""Of a map at most, evenly in time."""
CURVE = 120
"""Points of a curve a direction."""
_SHARE = (0.002, 0.998)
"""Of the dots that the axis holds: single rows may be far off."""


def friction_maps_html(
    speed: Array, torque: Array, fitted: Sequence[JointFriction | None], table: Sequence[JointFriction | None],
    joints: tuple[str, ...], units: tuple[tuple[str, str], ...],
) -> str:  # fmt: skip
    """A map a joint.

    Parameters
    ----------
    speed : (k, n) array
        [rad/s or m/s]
    torque : (k, n) array
        Measured torque less what bodies and rotors take, NaN where it is not used [N m or N].
    fitted, table : sequence of n JointFriction or None
        The result, and the friction that the arm had.
    joints : tuple of str
    units : tuple of (str, str)
        Of speed and torque of each joint.
    """
    figures = (_map(speed[:, j], torque[:, j], fitted[j], table[j], joints[j], units[j]) for j in range(len(joints)))
    return f'<div class="many maps">{"".join(figures)}</div>'


def _map(
    speed: Array, torque: Array, fitted: JointFriction | None, table: JointFriction | None, joint: str,
    units: tuple[str, str],
) -> str:  # fmt: skip
    rows = np.flatnonzero(np.isfinite(torque) & np.isfinite(speed))
    rows = rows[:: max(1, -(-rows.size // DOTS))]
    v, tau = speed[rows], torque[rows]
    fastest = float(np.abs(v).max(initial=0.0)) or 1.0
    curves = [(one, kind) for one, kind in ((table, "ref"), (fitted, "r1")) if one is not None]
    lines = [(_curve(one, fastest), kind) for one, kind in curves]
    seen = np.quantile(tau, _SHARE) if tau.size else np.array([-1.0, 1.0])
    up = axis_of(np.concatenate([seen, *(y[np.isfinite(y)] for (_, y), _ in lines)]), most=5)
    across = axis_of(np.array([-fastest, fastest]), most=5, padding=0.02)
    paths = [grid_path(None, up), f'<path class="zero" d="M{round(2000 * float(across.share(0.0)))},0V1000"/>']
    paths += [dots_path(v, tau, across, up, "dots")]
    paths += [line_path(x, y, across, up, kind) for (x, y), kind in lines]
    label = f"{joint}: friction torque over speed, {rows.size} dots; {friction_words(fitted, units[1])}"
    area = (
        f'<div class="area">{tick_marks(up, "yt", "top")}{plane_html(label, paths, "map")}'
        f"<div></div>{tick_marks(across, 'xt', 'left')}</div>"
    )
    head = f"<figcaption><h3>{escape(joint)} <small>{' over '.join(reversed(units))}</small></h3></figcaption>"
    words = escape(friction_words(fitted, units[1]))
    return f'<figure>{head}{area}<p class="note">{words}</p></figure>'


def _curve(one: JointFriction, fastest: float) -> tuple[Array, Array]:
    """Speeds and torques of both directions, with a gap at rest."""
    v = fastest * np.linspace(1e-6, 1.0, CURVE)
    x = np.concatenate([-v[::-1], [0.0], v])
    y = one.torque(x)
    y[CURVE] = np.nan
    return x, y


def friction_words(one: JointFriction | None, unit: str) -> str:
    """A joint's friction in a sentence.

    >>> from lwr_dyn.model.friction import symmetric
    >>> friction_words(symmetric(2.0, 0.5), "N m")
    'Coulomb 2 and 2 N m (up, down), viscous 0.5 and 0.5, offset 0 N m'
    """
    if one is None:
        return "values that no friction can have: a level below 0"
    up, down = one.positive, one.negative
    said = (
        f"Coulomb {short(up.coulomb)} and {short(down.coulomb)} {unit} (up, down), viscous {short(up.viscous)} and "
        f"{short(down.viscous)}, offset {short(one.offset)} {unit}"
    )
    return said + "".join(_stribeck(way, each, unit) for way, each in (("up", up), ("down", down)))


def _stribeck(way: str, one: Direction, unit: str) -> str:
    if one.static is None or one.stribeck_velocity is None or one.static <= one.coulomb:
        return ""
    return f"; Stribeck {way}: {short(one.static)} {unit} at rest, falling over {short(one.stribeck_velocity)}"
