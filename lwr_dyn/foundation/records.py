"""Frozen dataclasses made in a fifth of the time, for those that are made by the million."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypeVar

Record = TypeVar("Record")


def quick_maker(kind: type[Record]) -> Callable[..., Record]:
    """A function of all fields in order that makes a frozen dataclass with slots.

    A frozen class sets each field through `object.__setattr__`. Here they are set in an object of a class with the same
    slots that is not frozen, which then becomes one of `kind`; Python allows that where the slots are the same.

    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True, slots=True)
    ... class Pair:
    ...     one: int
    ...     other: int
    >>> quick_maker(Pair)(1, 2)
    Pair(one=1, other=2)
    """
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    lines = [
        f"def make({', '.join(names)}):", "    made = new()", *(f"    made.{name} = {name}" for name in names),
        "    made.__class__ = kind", "    return made",
    ]  # fmt: skip
    known: dict[str, Any] = {"new": type(kind.__name__, (), {"__slots__": tuple(names)}), "kind": kind}
    exec("\n".join(lines), known)
    make: Callable[..., Record] = known["make"]
    return make
