"""A function on symbols as operations in order, each once, with the places where results are stored.

Sines and cosines are the project's own polynomials ("own": the same bits on every machine that does not contract
products and sums) or calls of the language's library ("libm").
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

from lwr_dyn.codegen.emit.functions import EmittedFunction
from lwr_dyn.codegen.kernels.sincos import sincos
from lwr_dyn.codegen.kernels.straight_line import OPERATIONS, Node, StraightLineCode, Value, straight_line_code
from lwr_dyn.foundation.errors import OptionError

SinCosKind = Literal["own", "libm"]
SINCOS = get_args(SinCosKind)
_BY_BITS = ("2^", "exponent", "significand")


@dataclass(frozen=True, slots=True)
class LibraryCalls:
    """Sine and cosine as calls: takes the place of `SinCos` in straight-line code."""

    magic: float
    most_half_turns: int

    def expand(self, writer: Any, x: Any) -> tuple[Any, Any, Any]:
        """sin x and cos x as nodes; no half turns are subtracted."""
        return writer.node("sin", x.node, x.node), writer.node("cos", x.node, x.node), writer.number(0.0)


@dataclass(frozen=True, slots=True)
class Operation:
    """Node `index` is computed."""

    index: int
    node: Node


@dataclass(frozen=True, slots=True)
class Store:
    """Result `place` gets the value."""

    place: int
    value: Value


@dataclass(frozen=True, eq=False)
class EmittedCode:
    """The operations of a function."""

    function: EmittedFunction
    code: StraightLineCode
    kind: SinCosKind
    dtype: str

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Operations, constants and inputs."""
        return self.code.nodes

    @property
    def operations(self) -> int:
        """Additions, products, quotients, roots and calls of one state."""
        return self.code.operations

    @property
    def stores_early(self) -> bool:
        """Whether a result is stored as soon as it is known, so that fewer are held: then it may not be an argument.

        With as many results as joints they are stored last, and may take the place of an argument.
        """
        is_wide = self.function.width > max(argument.width for argument in self.function.arguments)
        return is_wide or any(self.nodes[value.node].op == "in" for value in self.code.results)

    @cached_property
    def statements(self) -> tuple[Operation | Store, ...]:
        """In order; constants and inputs have no statement of their own."""
        return tuple(self._early() if self.stores_early else self._late())

    def _operations(self) -> Iterator[Operation]:
        return (Operation(i, node) for i, node in enumerate(self.nodes) if node.op in OPERATIONS)

    def _late(self) -> Iterator[Operation | Store]:
        yield from self._operations()
        yield from (Store(place, value) for place, value in enumerate(self.code.results))

    def _early(self) -> Iterator[Operation | Store]:
        wanted: dict[int, list[Store]] = {}
        for place, value in enumerate(self.code.results):
            wanted.setdefault(value.node, []).append(Store(place, value))
        for i, node in enumerate(self.nodes):
            if node.op in OPERATIONS:
                yield Operation(i, node)
            yield from wanted.get(i, ())


def check_sincos(kind: str) -> None:
    """Raise `OptionError` for another kind of sine and cosine."""
    if kind not in SINCOS:
        raise OptionError("sincos", repr(kind), ", ".join(SINCOS))


def emitted_code(function: EmittedFunction, kind: SinCosKind = "own", dtype: str = "float64") -> EmittedCode:
    """The operations of a function.

    Parameters
    ----------
    function : EmittedFunction
    kind : {"own", "libm"}
        Whose sine and cosine.
    dtype : {"float64", "float32"}

    Raises
    ------
    OptionError
        Another kind, or a function that float32 cannot compute.
    """
    check_sincos(kind)
    numbers: Any = sincos(dtype)
    if kind == "libm":
        numbers = LibraryCalls(numbers.magic, numbers.most_half_turns)
    code = straight_line_code(function.symbolic, numbers, is_flagged=False)
    if dtype != "float64" and any(node.op in _BY_BITS for node in code.nodes):
        raise OptionError(
            "dtype", repr(dtype), f"float64: {function.name} has exponentials, which are of float64 alone"
        )
    return EmittedCode(function, code, kind, dtype)
