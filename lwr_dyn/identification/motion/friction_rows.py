"""Friction beyond Coulomb and viscous as tables: Stribeck speeds that were searched, and shares of the load."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Fact, Note
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.load_friction import load_indices
from lwr_dyn.identification.regression.stribeck import StribeckSearch

Numbers = list[float]
IN_A_MODEL = "a data file has it as friction.load; simulations leave it out and say so"


def friction_parts(
    found: Information, states: Sequence[str], search: StribeckSearch | None, sigma: Array | None
) -> list[Any]:
    """Parts of a document; `sigma` (n,) are the standard errors of the speeds, `states` those of base parameters."""
    return [*_stribeck(search, sigma), *_load(found, states)]


def load_shares(found: Information) -> list[tuple[int, float, float]]:
    """Joint (from 1), share of the load, standard error; infinite where no motion shows it. Empty without the term."""
    places = load_indices(found.columns)
    at = np.searchsorted(found.base.kept, places)
    return [(j + 1, float(found.values[k]), float(found.sigma[k])) for j, k in enumerate(at)]


def load_words(found: Information) -> str:
    """The shares for a provenance, `friction of 0.1 +- 0.01, ... of the load`; empty without the term."""
    rows = load_shares(found)
    shown = ", ".join(f"{share:.2g} +- {error:.2g}" if np.isfinite(error) else "unknown" for _, share, error in rows)
    return f"friction of {shown} of the load" if rows else ""


def _stribeck(search: StribeckSearch | None, sigma: Array | None) -> list[Any]:
    speeds = np.zeros(0) if search is None else search.speeds
    errors = np.full(len(speeds), np.nan) if sigma is None else sigma
    rows = [
        (j + 1, v, errors[j], "bound of the search" if search is not None and search.at_bound[j] else "")
        for j, v in enumerate(speeds)
        if np.isfinite(v)
    ]
    heads = ("joint", Heading("speed", "rad/s, m/s", key="v", sigma="e"), Heading(key="e"), Heading("how", key=None))
    return [
        Table("Stribeck speeds", heads, rows),
        Note("Stribeck speeds: no joint asks for one", search is not None and not rows),
        Fact("stribeck_velocity", None if search is None else search.speeds,
             "Speeds found with --stribeck, null for a joint without one.", kind=Numbers | None),
        Fact("stribeck_velocity_error", sigma, "Their standard errors.", kind=Numbers | None),
    ]  # fmt: skip


def _load(found: Information, states: Sequence[str]) -> list[Any]:
    shares = load_shares(found)
    at = np.searchsorted(found.base.kept, load_indices(found.columns))
    rows = [(j, x, e, states[k]) for (j, x, e), k in zip(shares, at, strict=True)]
    heads = ("joint", Heading("share", "N m/(N m)", key="x", sigma="e"), Heading(key="e"), Heading("state", key=None))
    values, errors = ([row[i] for row in shares] or None for i in (1, 2))
    return [
        Table("friction that grows with the torque of bodies and rotors", heads, rows, IN_A_MODEL),
        Fact("load_friction", values, "Share of the torque of bodies and rotors, with --load-friction.",
             kind=Numbers | None),
        Fact("load_friction_error", errors, "Standard errors, null where no motion shows a share.",
             kind=Numbers | None),
    ]  # fmt: skip
