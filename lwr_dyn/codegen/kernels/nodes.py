"""The nodes of straight-line code, and what is done to them once all are known: reciprocals, the unused dropped."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Any, NamedTuple


class Value(NamedTuple):
    """A node with a sign."""

    sign: int
    node: int


class Node(NamedTuple):
    """`in` (row = array, column), `const` (its value), or an operation on nodes; of one node a = b.

    Beside + - * / and sqrt: > gives 1.0 or 0.0; min and max give the first where a node is NaN; ? gives b where a is
    1.0, else 0.0; abs; 2^ of a whole number; exponent e and significand m of 2^e m, 1 <= m < 2. sin and cos stand only
    in code for other languages, which call their library.
    """

    op: str
    a: Any
    b: Any = None


OPERATIONS = ("+", "-", "*", "/", ">", "sqrt", "min", "max", "?", "abs", "2^", "exponent", "significand",
              "sin", "cos")  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class StraightLineCode:
    """`nodes` in order, `results` as signed nodes, and a `flag` that marks invalid states.

    `flag` is 0 for a lane with finite inputs and angles that the range reduction accepts, NaN when an input (or a
    result that stands for it) is not finite, and above 0 for a finite angle that is too large.
    """

    nodes: tuple[Node, ...]
    results: tuple[Value, ...]
    flag: Value

    @property
    def operations(self) -> int:
        """Additions, products, quotients, comparisons and roots of one state."""
        return sum(node.op in OPERATIONS for node in self.nodes)

    def operations_after_contraction(self) -> int:
        """The same with fused multiply-add: a product that only one sum uses is not counted."""
        uses: dict[int, list[str]] = {}
        for node in self.nodes:
            if node.op in OPERATIONS:
                for i in {node.a, node.b}:
                    uses.setdefault(i, []).append(node.op)
        taken: set[int] = set()
        fused = 0
        for i, node in enumerate(self.nodes):
            if node.op in ("+", "-"):
                for operand in (node.a, node.b):
                    if i not in taken and self.nodes[operand].op == "*" and uses[operand] in (["+"], ["-"]):
                        fused, taken = fused + 1, taken | {i}
        return self.operations - fused


Traced = tuple[Sequence[Node], Sequence[Value], Value]
"""Nodes, results, flag."""


def by_reciprocals(nodes: Sequence[Node], results: Sequence[Value], flag: Value) -> Traced:
    """With x / d as x (1 / d) wherever d divides more than one number.

    A divider of a vector register takes as long as a dozen products. One quotient alone keeps its exact rounding.
    """
    divisors = Counter(node.b for node in nodes if node.op == "/")
    out: list[Node] = []
    new: list[int] = []
    one: dict[int, int] = {}

    def added(node: Node) -> int:
        out.append(node)
        return len(out) - 1

    for node in nodes:
        if node.op not in OPERATIONS:
            new.append(added(node))
            continue
        a, b = new[node.a], new[node.b]
        if node.op != "/" or divisors[node.b] == 1:
            new.append(added(Node(node.op, a, b)))
            continue
        if b not in one:
            one[b] = added(Node("/", added(Node("const", 1.0)), b))
        new.append(one[b] if out[a] == ("const", 1.0, None) else added(Node("*", *sorted((a, one[b])))))
    return out, [Value(v.sign, new[v.node]) for v in results], Value(flag.sign, new[flag.node])


def without_the_unused(nodes: Sequence[Node], results: Sequence[Value], flag: Value) -> StraightLineCode:
    """The code without operations that neither a result nor the flag needs."""
    needed = {value.node for value in (*results, flag)}
    for i in reversed(range(len(nodes))):
        if i in needed and nodes[i].op in OPERATIONS:
            needed |= {nodes[i].a, nodes[i].b}
    new: dict[int, int] = {}
    used: list[Node] = []
    for i, node in enumerate(nodes):
        if i in needed:
            new[i] = len(used)
            used.append(Node(node.op, new[node.a], new[node.b]) if node.op in OPERATIONS else node)
    renumbered = [Value(v.sign, new[v.node]) for v in results]
    return StraightLineCode(tuple(used), tuple(renumbered), Value(flag.sign, new[flag.node]))


_PASSING = {"+": 2, "-": 2, "*": 2, "/": 1, "sqrt": 1, "abs": 1}
"""Operations that give no finite number where one of their first so many operands is not finite."""


def reached_inputs(nodes: Sequence[Node]) -> list[int]:
    """For every node the inputs that make it not finite where they are not finite themselves: bit i for node i."""
    reached: list[int] = []
    for i, node in enumerate(nodes):
        passing = (node.a, node.b)[: _PASSING.get(node.op, 0)]
        reached.append(1 << i if node.op == "in" else reduce(or_, (reached[j] for j in passing), 0))
    return reached
