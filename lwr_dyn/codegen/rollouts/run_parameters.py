"""The parameters that differ from run to run: their names and shapes, and arrays of any accepted form made whole."""

from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.laws.gain_values import check_gains
from lwr_dyn.codegen.rollouts.step import MOST_DELAY
from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OptionError, ShapeError, UnknownNameError

MOST_RUNS = 10_000_000


def parameter_shapes(n: int, gains: Mapping[str, tuple[int, ...]] | None = None) -> dict[str, tuple[int, ...]]:
    """Name -> shape of one run's value, for n joints; `gains` are those of the law.

    >>> parameter_shapes(7)["inertia"], parameter_shapes(7)["payload_com"]
    ((70,), (3,))
    """
    plant: dict[str, tuple[int, ...]] = {
        "inertia": (10 * n,), "payload": (), "payload_com": (3,), "armature": (n,), "friction": (5, n), "effort": (n,),
        "q0": (n,), "dq0": (n,), "delay": (), "resolution": (), "noise": (), "reference": (),
        "model_inertia": (10 * n,), "model_payload": (), "model_payload_com": (3,),
    }  # fmt: skip
    return plant | dict(gains or {})


def run_parameters(
    given: Mapping[str, Any], runs: int | None, shapes: Mapping[str, tuple[int, ...]], references: int = 1
) -> tuple[int, dict[str, Array]]:
    """The number of runs, and each parameter as an array (runs, *shape).

    A row (runs,) or (runs, 1) for a joint vector stands for all joints; trailing axes may be flat, and inertias may
    have an axis of links (runs, n, 10). Other axes are refused: transposed ones would be read as other numbers.

    Raises
    ------
    UnknownNameError
        A name that is not in `shapes`.
    ShapeError
        Another shape, a number that is not finite, parameters with different numbers of rows.
    OptionError
        No number of runs, or one that is not from 1 on; a value outside what is allowed.
    """
    for name in given:
        if name not in shapes:
            raise UnknownNameError("parameter of rollouts", name, shapes)
    arrays = {name: _rows(name, value) for name, value in given.items()}
    rows = {name: len(array) for name, array in arrays.items()}
    count = next(iter(rows.values()), None) if runs is None else runs
    if count is None:
        raise OptionError("runs", "not given", "a number of runs, or parameters with a row for each")
    if not (isinstance(count, int) and not isinstance(count, bool) and 1 <= count <= MOST_RUNS):
        raise OptionError("runs", count, f"a whole number from 1 to {MOST_RUNS}")
    for name, found in rows.items():
        if found != count:
            raise ShapeError(f"parameter {name}", f"{found} rows", f"{count} rows, one a run")
    whole = {name: _whole(name, array, shapes[name]) for name, array in arrays.items()}
    _check(whole, references)
    return count, whole


def _rows(name: str, value: Any) -> Array:
    array = real_array(f"parameter {name}", value)
    if array.ndim == 0:
        raise ShapeError(f"parameter {name}", "a single number", "an array with a row a run")
    return array


def _whole(name: str, array: Array, shape: tuple[int, ...]) -> Array:
    runs, rest = len(array), array.shape[1:]
    by_link = (shape[0] // 10, 10) if name.endswith("inertia") else shape
    if rest in (shape, by_link) or (len(rest) <= 1 and prod(rest) == prod(shape)):
        return np.ascontiguousarray(array.reshape(runs, *shape))
    if len(shape) == 1 and prod(rest) == 1 and not name.endswith(("inertia", "com")):
        return np.repeat(array.reshape(runs, 1), shape[0], axis=1)
    words = f"({runs}, {', '.join(map(str, shape))})" if shape else f"({runs},)"
    raise ShapeError(f"parameter {name}", f"shape {array.shape}", words)


def _check(values: Mapping[str, Array], references: int) -> None:
    bounds = {"payload": np.inf, "model_payload": np.inf, "armature": np.inf, "effort": np.inf, "resolution": np.inf}
    bounds |= {"noise": np.inf, "delay": MOST_DELAY, "reference": references - 1}
    for name, most in bounds.items():
        array = values.get(name, np.zeros(1))
        bad = (array < 0.0) | (array > most)
        if name in ("delay", "reference"):
            bad |= array != np.round(array)
        if bad.any():
            where = int(np.argwhere(bad)[0][0])
            kind = "whole numbers" if name in ("delay", "reference") else "numbers"
            end = "from 0 on" if np.isinf(most) else f"from 0 to {most}"
            raise OptionError(f"parameter {name}", f"{array[bad][0]:g} in run {where}", f"{kind} {end}")
    for load in ("payload", "model_payload"):
        if f"{load}_com" in values and load not in values:
            raise OptionError(f"parameter {load}_com", f"given without {load}", f"both, or {load} alone")
    for name in ("inertia", "model_inertia"):
        masses = values.get(name, np.zeros((0, 10)))[:, ::10]
        for run, link in np.argwhere(masses < 0.0)[:1].tolist():
            found = f"a mass of {masses[run, link]:g} kg in run {run}, link {link + 1}"
            raise OptionError(f"parameter {name}", found, "masses from 0 on")
    check_gains(values)
