"""Operations -> JavaScript: one function each, over arrays of numbers; names of temporaries are used again.

V8 compiles a function to machine code only while its bytecode is below a bound, and each name costs some: a temporary
takes the name of one that no later operation reads, and a function with more than `LARGEST` operations is written as
several, each with a part of the results. Sine and cosine of one angle are one call of `sincos` (`javascript_shared`).
"""

from collections.abc import Iterator, Sequence

from lwr_dyn.codegen.emit.straight_code import EmittedCode, Operation, SinCosKind, Store
from lwr_dyn.codegen.kernels.straight_line import OPERATIONS, Node

LARGEST = 3500
"""Operations of one function: at 12 bytes of bytecode each, below V8's 61 440."""
_FORMS = {
    ">": "{0} > {1} ? 1.0 : 0.0", "?": "{0} > 0.5 ? {1} : 0.0", "min": "{0} > {1} ? {1} : {0}",
    "max": "{1} > {0} ? {1} : {0}", "sqrt": "Math.sqrt({0})", "abs": "Math.abs({0})", "2^": "two_to({0})",
    "exponent": "exponent({0})", "significand": "significand({0})",
}  # fmt: skip


def js_function(code: EmittedCode, name: str, sincos: SinCosKind = "own", largest: int = LARGEST) -> str:
    """The function, and those that it is split into.

    Parameters
    ----------
    code : EmittedCode
        With sines and cosines as calls ("libm"), or as operations.
    name : str
    sincos : {"own", "libm"}
        What a call becomes: one of `sincos` that gives both, or of Math.sin and Math.cos.
    largest : int
        Most operations of one function; one with a single result is never split.
    """
    arguments = ", ".join(a.name for a in code.function.arguments)
    head = f"{arguments}, out = new Float64Array({code.function.width})"
    parts = _parts(code, largest)
    if len(parts) == 1:
        return _FunctionText(code, parts[0], sincos).text(name, head)
    several = [
        _FunctionText(code, part, sincos).text(f"{name}_{k}", f"{arguments}, out") for k, part in enumerate(parts, 1)
    ]  # fmt: skip
    calls = "".join(f"  {name}_{k}({arguments}, out);\n" for k in range(1, len(parts) + 1))
    return "\n".join([*several, f"function {name}({head}) {{\n{calls}  return out;\n}}\n"])


def _parts(code: EmittedCode, largest: int) -> list[tuple[Operation | Store, ...]]:
    """The statements, split by results until no part is too large."""
    parts = [range(len(code.code.results))]
    while True:
        chosen = [_needed(code, part) for part in parts]
        large = [
            i for i, (part, places) in enumerate(zip(chosen, parts, strict=True))
            if len(part) - len(places) > largest and len(places) > 1
        ]  # fmt: skip
        if not large:
            return chosen
        at, places = large[0], parts[large[0]]
        parts[at : at + 1] = [places[: len(places) // 2], places[len(places) // 2 :]]


def _needed(code: EmittedCode, places: Sequence[int]) -> tuple[Operation | Store, ...]:
    """The statements that some results need."""
    wanted = {code.code.results[place].node for place in places}
    for i in range(len(code.nodes) - 1, -1, -1):
        if i in wanted and code.nodes[i].op in OPERATIONS:
            wanted |= {code.nodes[i].a, code.nodes[i].b}
    kept = set(places)
    return tuple(s for s in code.statements if (s.index in wanted if isinstance(s, Operation) else s.place in kept))


class _FunctionText:
    """Writes statements, with few names."""

    def __init__(self, code: EmittedCode, statements: Sequence[Operation | Store], sincos: SinCosKind) -> None:
        self.code, self.statements, self.sincos = code, statements, sincos
        self.last = _last_uses(statements)
        self.names: dict[int, int] = {}
        self.free: list[int] = []
        self.count = 0
        self.turned: int | None = None
        """The node whose sine and cosine stand in `turned`."""

    def text(self, name: str, arguments: str) -> str:
        """The whole function."""
        lines = [line for k, statement in enumerate(self.statements) for line in self._lines(k, statement)]
        names = ", ".join(f"v{i}" for i in range(self.count))
        head = [f"function {name}({arguments}) {{", *([f"  let {names};"] if self.count else [])]
        return "\n".join([*head, *(f"  {line}" for line in lines), "  return out;", "}", ""])

    def _read(self, i: int) -> str:
        node: Node = self.code.nodes[i]
        if node.op == "const":
            return repr(float(node.a)).replace("inf", "Infinity").replace("nan", "NaN")
        return f"{self.code.function.arguments[node.a].name}[{node.b}]" if node.op == "in" else f"v{self.names[i]}"

    def _lines(self, k: int, statement: Operation | Store) -> Iterator[str]:
        if isinstance(statement, Store):
            value = statement.value
            yield f"out[{statement.place}] = {'-' if value.sign < 0 else ''}{self._read(value.node)};"
            self._release(k, statement)
            return
        node = statement.node
        if node.op in ("sin", "cos"):
            if self.sincos == "own":
                yield from self._turn(node.a)
            right = self._sine_or_cosine(node)
        else:
            right = _FORMS.get(node.op, f"{{0}} {node.op} {{1}}").format(self._read(node.a), self._read(node.b))
        self._release(k, statement)
        yield f"v{self._named(statement.index)} = {right};"

    def _turn(self, angle: int) -> Iterator[str]:
        if self.turned == angle:
            return
        node = self.code.nodes[angle]
        if node.op == "in":
            yield f"sincos({self.code.function.arguments[node.a].name}, {node.b});"
        else:  # by an array: a number as an argument would be put on the heap
            yield f"turned[0] = {self._read(angle)};"
            yield "sincos(turned, 0);"
        self.turned = angle

    def _sine_or_cosine(self, node: Node) -> str:
        if self.sincos == "libm":
            return f"Math.{node.op}({self._read(node.a)})"
        return f"turned[{('sin', 'cos').index(node.op)}]"

    def _release(self, k: int, statement: Operation | Store) -> None:
        """The names that no later statement reads may be taken again."""
        used = {i for i in _reads(statement) if i in self.names and self.last[i] == k}
        self.free += sorted((self.names[i] for i in used), reverse=True)

    def _named(self, index: int) -> int:
        if not self.free:
            self.free.append(self.count)
            self.count += 1
        self.names[index] = self.free.pop()
        return self.names[index]


def _last_uses(statements: Sequence[Operation | Store]) -> dict[int, int]:
    """Node -> the statement that reads it last."""
    return {i: k for k, statement in enumerate(statements) for i in _reads(statement)}


def _reads(statement: Operation | Store) -> tuple[int, ...]:
    return (statement.value.node,) if isinstance(statement, Store) else (statement.node.a, statement.node.b)
