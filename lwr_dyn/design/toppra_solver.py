"""The only door to toppra: the fastest squared speeds on a grid under linear limits."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingPackageError

INSTEAD = "the timings of the task itself, as --timing smooth-blended"
FASTEST = 1e8
"""Largest squared speed that toppra takes, of a path of length 1."""


@dataclass(frozen=True, slots=True, eq=False)
class LinearLimits:
    """|a u + b x + c| <= 1 at the m + 1 points of a grid, (m + 1, r) each, and x <= `top` (m + 1,)."""

    a: Array
    b: Array
    c: Array
    top: Array


def fastest_squares(s: Array, limits: LinearLimits) -> Array | None:
    """x = ds^2 (m + 1,) at the grid s (m + 1,), rising from 0, from rest to rest; None where toppra finds none.

    Raises
    ------
    MissingPackageError
        toppra is not installed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its strings, where Python compiles it for the first time
            from toppra.algorithm import TOPPRA
            from toppra.constraint import LinearConstraint
            from toppra.interpolator import AbstractGeometricPath
    except ModuleNotFoundError as fault:
        raise MissingPackageError(fault.name or "toppra", "design", INSTEAD) from None
    length, rows = float(s[-1]), limits.a.shape[1]
    tempo = 1.0 / float(np.abs(limits.a).max() * length)

    class Grid(AbstractGeometricPath):  # type: ignore[misc]
        """toppra asks this path for its interval only: the limits on it are computed before, with exact derivatives."""

        dof, path_interval, waypoints = 1, np.array([0.0, 1.0]), None

    class Given(LinearConstraint):  # type: ignore[misc]
        """Limits that are known already, on a path of length 1, in a unit of time in which the largest a is 1."""

        def __init__(self) -> None:
            super().__init__()
            self.dof, self.identical = 1, True

        def compute_constraint_params(self, *_: Any, **__: Any) -> tuple[Any, ...]:
            both = np.vstack([np.eye(rows), -np.eye(rows)])
            top = np.column_stack([np.zeros(s.size), np.minimum(limits.top / (length**2 * tempo), FASTEST)])
            a, b = limits.a * (length * tempo), limits.b * (length**2 * tempo)
            return a, b, limits.c, both, np.ones(2 * rows), None, top

    with _quiet():
        solver = TOPPRA([Given()], Grid(), gridpoints=s / length, solver_wrapper="seidel")
        speeds = solver.compute_parameterization(0.0, 0.0)[1]
    return None if speeds is None or not np.isfinite(speeds).all() else np.asarray(speeds**2 * (length**2 * tempo))


@contextmanager
def _quiet() -> Iterator[None]:
    """Without toppra's warnings: what it cannot solve is an error of ours."""
    logger = logging.getLogger("toppra")
    before, logger.disabled = logger.disabled, True
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.disabled = before
        logger.setLevel(level)
