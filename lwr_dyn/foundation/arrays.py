"""Input checks of arrays: arguments become finite float64 arrays of the right shape, or raise one clear error.

They run in the functions of `import lwr_dyn` and in the public methods of the engines; recursions and loops behind them
run unchecked.
"""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lwr_dyn.foundation.errors import OptionError, ShapeError

Array = NDArray[np.float64]
T = TypeVar("T")


def arm_argument(arm: T) -> T:
    """The argument itself; raises `OptionError` for anything but an arm, above all for a robot's name."""
    if not hasattr(arm, "chain"):
        raise OptionError("arm", repr(arm), "an arm, such as lwr_dyn.load('lwr4plus') gives")
    return arm


def joint_array(name: str, value: ArrayLike, n: int) -> Array:
    """Joint vectors (..., n) of the argument `name` as float64.

    Raises `ShapeError`: not numbers, last axis not n, or a value that is not finite.

    >>> joint_array("q", [0, 1], 2)
    array([0., 1.])
    """
    array = real_array(name, value)
    if array.ndim == 0 or array.shape[-1] != n:
        raise ShapeError(name, _size(array), f"{n} numbers, one per joint")
    return array


def fixed_array(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """A finite float64 array of exactly `shape`; raises `ShapeError` otherwise.

    >>> fixed_array("point", (0, 0, 1), (3,))
    array([0., 0., 1.])
    """
    array = real_array(name, value)
    if array.shape != shape:
        raise ShapeError(name, _size(array), " x ".join(map(str, shape)) + " numbers" if shape else "one number")
    return array


def _size(array: Array) -> str:
    """The size of an array in words: "2 numbers", "an array of 3 x 4 numbers"."""
    if array.ndim == 0:
        return "a single number"
    if array.ndim == 1:
        return f"{len(array)} number{'' if len(array) == 1 else 's'}"
    return f"an array of {' x '.join(map(str, array.shape))} numbers"


def number_of(text: str) -> float:
    """The number that a text writes; raises `ValueError` for Python's `1_0` and for digits of other scripts too.

    >>> number_of("1e-3")
    0.001
    """
    if "_" in text or not text.isascii():
        raise ValueError(text)
    return float(text)


def real_array(name: str, value: ArrayLike) -> Array:
    """A finite float64 array of any shape; raises `ShapeError` for text, dates, ragged lists, NaN or infinity."""
    try:
        raw = np.asarray(value)
        array = np.asarray(raw.real if raw.dtype.kind == "c" else raw, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as fault:
        raise ShapeError(name, "not an array of numbers", "real numbers") from fault
    if raw.dtype.kind in "cmM":
        raise ShapeError(name, "complex numbers" if raw.dtype.kind == "c" else "dates or times", "real numbers")
    finite = np.isfinite(array)
    if not finite.all():
        where = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise ShapeError(name, f"{array[where]} at index {where}" if where else f"{array[where]}", "finite numbers")
    return array


def same_batch(**arrays: Array) -> tuple[int, ...]:
    """The common leading shape of joint arrays; raises `ShapeError` when they do not broadcast.

    >>> same_batch(q=np.zeros((5, 7)), dq=np.zeros(7))
    (5,)
    """
    try:
        return np.broadcast_shapes(*(a.shape[:-1] for a in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {a.shape}" for name, a in arrays.items())
        raise ShapeError(", ".join(arrays), shapes, "leading axes that broadcast together") from None


def freeze_arrays(record: object, *names: str) -> None:
    """Replaces fields of a frozen record by read-only float64 copies."""
    for name in names:
        object.__setattr__(record, name, read_only(getattr(record, name)))


def read_only(value: Any) -> Array:
    """A read-only float64 copy.

    >>> read_only([1.0]).flags.writeable
    False
    """
    array = np.array(value, dtype=np.float64)
    array.flags.writeable = False
    return array
