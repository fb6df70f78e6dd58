"""The parameters of a fit as HTML: value, sigma, the table's value, how far apart they are in sigmas, and the state."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.report.inertia_ellipsoids import central_moments, semi_axes
from lwr_dyn.pages.plotting.axes import short

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
