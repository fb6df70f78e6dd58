"""What the report shows, as plain values: made from a fit, or by hand.

The body of a link as the solid ellipsoid of one density that has its mass, centre of mass and inertia.

Of a pseudo-inertia P = [[S, h], [h^T, m]], S = integral of r r^T dm, a solid ellipsoid with semi-axes a has
S - h h^T / m = m / 5 R diag(a^2) R^T about its centre h / m, so its semi-axes are those of P, made visible: a body is
one that can be (P > 0) where all three are real.

The parameters of a fit as HTML: value, sigma, the table's value, how far apart they are in sigmas, and the state.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.bodies.possible_bodies import pseudo_inertias
from lwr_dyn.identification.report.charts import ShownRecording
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.pages.figures.figure import short

ROUNDING = 1e-9
"""Of the largest moment: a second moment this far below 0 counts as 0, as of a plate or a rod."""


def central_moments(parameters: Array) -> tuple[float, Array, Array]:
    """Mass [kg], centre of mass (3,) [m] and S (3, 3) [kg m^2] about it, of ten parameters as in `INERTIAL`.

    >>> mass, com, moments = central_moments(np.array([2.0, 0.0, 0.0, 2.0, 3.0, 0.0, 0.0, 3.0, 0.0, 1.0]))
    >>> mass, com.tolist(), np.diag(moments).tolist()
    (2.0, [0.0, 0.0, 1.0], [0.5, 0.5, 0.5])
    """
    P = pseudo_inertias(parameters)
    mass, first = float(P[3, 3]), P[:3, 3]
    if mass == 0.0:
        return mass, np.zeros(3), P[:3, :3]
    return mass, first / mass, P[:3, :3] - np.outer(first, first) / mass


def semi_axes(parameters: Array) -> tuple[Array, Array] | None:
    """Semi-axes (3,) [m], ascending, along the columns of a rotation (3, 3); None for what no body can be."""
    mass, _, moments = central_moments(parameters)
    if not (mass > 0.0 and np.isfinite(moments).all()):
        return None
    squares, axes = np.linalg.eigh(moments)
    if squares[0] < -ROUNDING * abs(squares[2]):
        return None
    axes = axes * np.where(np.linalg.det(axes) < 0.0, -1.0, 1.0)
    return np.sqrt(5.0 / mass * np.maximum(squares, 0.0)), axes


def ellipsoid_matrix(parameters: Array) -> Array | None:
    """The image of the unit sphere in the link's frame, (4, 4); None for what no body can be.

    >>> ball = np.array([5.0, 0.0, 0.0, 5.0, 7.0, 0.0, 0.0, 7.0, 0.0, 2.0])
    >>> ellipsoid_matrix(ball).tolist()
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]]
    """
    found = semi_axes(parameters)
    if found is None:
        return None
    sizes, axes = found
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = axes * sizes, central_moments(parameters)[1]
    return out


FAR = 10.0
"""Sigmas at which the bar of a difference is full."""

NOTICED = 3.0
"""Sigmas from which a difference is more than noise."""

_LONGEST = 60
"""Letters of a parameter's name that stand in the row; the whole name opens below it."""


@dataclass(frozen=True, slots=True)
class ShownParameter:
    """A parameter with its standard error, the values of the table and of the result's bodies, and its state; SI units.

    `bodies` is NaN where there are none.
    """

    name: str
    value: float
    sigma: float
    table: float
    bodies: float
    state: str

    @property
    def pull(self) -> float:
        """Value less table, in sigmas; NaN without a sigma."""
        return (self.value - self.table) / self.sigma if 0.0 < self.sigma < np.inf else float("nan")


def parameter_table_html(rows: Sequence[ShownParameter], caption: str) -> str:
    """The table, with a choice of the state where there are several."""
    states = list(dict.fromkeys(one.state for one in rows))
    options = "".join(
        f'<option value="{escape(s)}">{escape(s)} ({sum(r.state == s for r in rows)})</option>' for s in states
    )
    choice = (
        f'<p class="pick"><label>show <select class="states"><option value="">all ({len(rows)})</option>{options}'
        "</select></label></p>"
    )
    head = "".join(
        f'<th scope="col"{kind}>{name}</th>'
        for name, kind in (
            ("parameter <small>SI</small>", ""), ("value", ' class="n"'), ("sigma", ' class="n"'),
            ("bodies", ' class="n"'), ("table", ' class="n"'), ("value less table <small>sigma</small>", ""),
            ("state", ""),
        )
    )  # fmt: skip
    body = "".join(map(_row, rows))
    table = (
        f'<table class="parameters"><caption>{escape(caption)}</caption><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table>"
    )
    scrolled = f'<div class="scroll tall" tabindex="0" role="region" aria-label="{escape(caption)}">{table}</div>'
    return (choice if len(states) > 1 else "") + scrolled


def _row(one: ShownParameter) -> str:
    name = escape(one.name)
    if len(one.name) > _LONGEST:
        cut = escape(one.name[: _LONGEST - 1].rsplit(" ", 1)[0])
        name = f"<details><summary>{cut} ...</summary>{name}</details>"
    cells = "".join(f'<td class="n">{escape(number(x))}</td>' for x in (one.value, one.sigma, one.bodies, one.table))
    return (
        f'<tr data-state="{escape(one.state)}"><th scope="row">{name}</th>{cells}<td>{_bar(one.pull)}</td>'
        f"<td>{escape(one.state)}</td></tr>"
    )


def number(value: float, digits: int = 4) -> str:
    """A number for people: nothing for NaN, "unknown" for an infinite one.

    >>> number(0.25), number(float("nan")), number(float("inf"))
    ('0.25', '', 'unknown')
    """
    return "" if np.isnan(value) else "unknown" if np.isinf(value) else short(value, digits)


def _bar(pull: float) -> str:
    """A bar from the middle, full at `FAR` sigmas, and the number."""
    if np.isnan(pull):
        return ""
    half = 50.0 * min(abs(pull), FAR) / FAR
    left = 50.0 if pull > 0.0 else 50.0 - half
    kind = "bar far" if abs(pull) > NOTICED else "bar"
    return (
        f'<span class="pull"><span class="track"><i class="{kind}" style="left:{left:.1f}%;width:{half:.1f}%"></i>'
        f'</span><span class="m">{number(pull, 2)}</span></span>'
    )


def link_table(names: Sequence[str], before: Array, after: Array, sigma: Array | None = None) -> Table:
    """Mass, centre of mass and ellipsoid of each link, by the table and by the result (n, 10), with its errors."""
    errors = [None] * len(names) if sigma is None else sigma[:, 0].tolist()
    rows = [_link(name, *three) for name, *three in zip(names, before, after, errors, strict=True)]
    return Table(
        "Links, by the table and by the result",
        (
            Heading("link"), Heading("mass, table", "kg", number), Heading("mass", "kg", number),
            Heading("sigma", "kg", number),
            Heading("centre moved by", "mm", number), Heading("semi-axes, table", "mm"), Heading("semi-axes", "mm"),
            Heading("a body"),
        ),
        rows,
    )  # fmt: skip


def _link(name: str, before: Array, after: Array, error: float | None) -> tuple[str | float | None, ...]:
    (m0, c0, _), (m1, c1, _) = central_moments(before), central_moments(after)
    moved = 1e3 * float(np.linalg.norm(c1 - c0)) if m0 > 0.0 and m1 > 0.0 else None
    said = "yes" if semi_axes(after) is not None else "no"
    return name, m0, m1, error, moved, _axes(before), _axes(after), said


def _axes(parameters: Array) -> str:
    found = semi_axes(parameters)
    return "none" if found is None else ", ".join(f"{1e3 * x:.0f}" for x in found[0][::-1])


_UNITS = {JointKind.REVOLUTE: ("rad/s", "N m"), JointKind.PRISMATIC: ("m/s", "N")}

Section = tuple[str, tuple[Table, ...], tuple[str, ...]]
"""Heading, tables and notes."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownFit:
    """A fit as the page shows it.

    Parameters
    ----------
    arm : Arm
        Whose shapes are drawn.
    title, command : str
        Headline; what made the page, as "lwr-dyn identify motion".
    said : tuple of str
        Sentences below the headline.
    figures : tuple of (str, str)
        Name and value of each head figure.
    recordings : tuple of ShownRecording
    noise : (n,) array
        Standard deviation of the torques [N m or N].
    before, after : (n, 10) array
        Inertial parameters of the links in the frames of the source: the table's, the result's.
    sigma : (n, 10) array or None
        Standard errors of `after`.
    speed, friction_torque : (k, n) array
        Of the friction maps; NaN where a torque is not used.
    friction, friction_before : tuple of n JointFriction or None
    friction_at : tuple of n str
        Whose friction it is: names of joints, or of motors.
    parameters : tuple of ShownParameter
    caption : str
        Of the table of parameters.
    notes : tuple of str
        Below that table.
    more : tuple of Section
        Cards at the end: validation, slips, logs.
    """

    arm: Arm
    title: str
    command: str
    said: tuple[str, ...]
    figures: tuple[tuple[str, str], ...]
    recordings: tuple[ShownRecording, ...]
    noise: Array
    before: Array
    after: Array
    sigma: Array | None
    speed: Array
    friction_torque: Array
    friction: tuple[JointFriction | None, ...]
    friction_before: tuple[JointFriction | None, ...]
    friction_at: tuple[str, ...]
    parameters: tuple[ShownParameter, ...]
    caption: str
    notes: tuple[str, ...] = ()
    more: tuple[Section, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self, "noise", "before", "after", "speed", "friction_torque")
        if self.sigma is not None:
            freeze_arrays(self, "sigma")

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.arm.joint_names

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the moved links."""
        return tuple(link.link for link in self.arm.chain.links)

    @property
    def units(self) -> tuple[tuple[str, str], ...]:
        """Of speed and torque, per joint."""
        return tuple(_UNITS[link.kind] for link in self.arm.chain.links)
