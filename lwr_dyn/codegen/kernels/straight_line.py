"""Straight-line code: a symbolic function as a list of additions, products and quotients, each computed once.

CasADi's instructions are value-numbered with the sign kept apart (a - b and b - a are one difference, a negation is
free), sines and cosines become a range reduction and polynomials, and operations that no result needs are dropped.
Where several numbers are divided by one, they are multiplied by its reciprocal.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from math import frexp
from operator import or_
from typing import Any, Literal, NamedTuple

import casadi

from lwr_dyn.codegen.kernels import elementary
from lwr_dyn.codegen.kernels.elementary import SinCos


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

    def contraction(self) -> dict[int, int]:
        """Sums that become one instruction with a product that nothing else uses (fused multiply-add): sum -> product.

        Chosen here and not by a compiler, whose choice depends on the number of lanes: so all kernels give the same
        bits.
        """
        uses = Counter(value.node for value in (*self.results, self.flag))
        for node in self.nodes:
            if node.op in OPERATIONS:
                uses.update((node.a, node.b))  # a root has its operand twice
        taken: dict[int, int] = {}
        for i, node in enumerate(self.nodes):
            if node.op in ("+", "-"):
                products = [x for x in (node.a, node.b) if self.nodes[x].op == "*" and uses[x] == 1]
                if products:
                    taken[i] = products[0]
        return taken

    def operations_after_contraction(self) -> int:
        """The same with fused multiply-add."""
        return self.operations - len(self.contraction())


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


FlaggedBy = Literal["inputs", "few results", "results"]


class _Writer:
    """Adds nodes, each once (value numbering)."""

    def __init__(self, sincos: SinCos) -> None:
        self.sincos = sincos
        self.nodes: list[Node] = []
        self.index: dict[Node, int] = {}
        self.turns: dict[int, tuple[Value, Value, Value]] = {}

    def node(self, op: str, a: Any, b: Any = None) -> Value:
        key = Node(op, a, b)
        if key not in self.index:
            self.index[key] = len(self.nodes)
            self.nodes.append(key)
        return Value(1, self.index[key])

    def number(self, x: float) -> Value:
        return Value(-1 if x < 0 else 1, self.node("const", abs(float(x))).node)

    def _known(self, x: Value) -> float | None:
        node = self.nodes[x.node]
        return x.sign * node.a if node.op == "const" else None

    def minus(self, x: Value) -> Value:
        return Value(-x.sign, x.node)

    def plus(self, x: Value, y: Value) -> Value:
        known_x, known_y = self._known(x), self._known(y)
        if known_x is not None and known_y is not None:
            return self.number(known_x + known_y)
        if known_x == 0.0 or known_y == 0.0:
            return y if known_x == 0.0 else x
        first, second = sorted((x, y), key=lambda v: v.node)
        if x.sign == y.sign:
            return Value(x.sign, self.node("+", first.node, second.node).node)
        if x.node == y.node:
            return self.number(0.0)
        return Value(first.sign, self.node("-", first.node, second.node).node)

    def times(self, x: Value, y: Value) -> Value:
        known_x, known_y = self._known(x), self._known(y)
        if known_x is not None and known_y is not None:
            return self.number(known_x * known_y)
        for known, other in ((known_x, y), (known_y, x)):
            if known in (1.0, -1.0):
                return other if known == 1.0 else self.minus(other)
            if known == 0.0:
                return self.number(0.0)
        first, second = sorted((x.node, y.node))
        return Value(x.sign * y.sign, self.node("*", first, second).node)

    def over(self, x: Value, y: Value) -> Value:
        """x / y; by a power of two as a product, which is exact."""
        known = self._known(y)
        if known and frexp(abs(known))[0] == 0.5 and 1e-300 < abs(known) < 1e300:
            return self.times(x, self.number(1.0 / known))
        return Value(x.sign * y.sign, self.node("/", x.node, y.node).node)

    def root(self, x: Value) -> Value:
        """The square root; of a negated node as of 0 - node."""
        inner = x if x.sign > 0 else self.node("-", self.number(0.0).node, x.node)
        return self.node("sqrt", inner.node, inner.node)

    def is_positive(self, x: Value) -> Value:
        zero = self.number(0.0)
        return self.node(">", x.node, zero.node) if x.sign > 0 else self.node(">", zero.node, x.node)

    def turn(self, x: Value) -> tuple[Value, Value, Value]:
        """sin |x|, cos |x| and the number of half turns that the range reduction subtracts, for an input x."""
        if x.node not in self.turns:
            self.turns[x.node] = self.sincos.expand(self, Value(1, x.node))
        return self.turns[x.node]

    def apply(self, op: int, x: Sequence[Value]) -> Value:
        """One CasADi instruction."""
        match op:
            case casadi.OP_ADD:
                return self.plus(x[0], x[1])
            case casadi.OP_SUB:
                return self.plus(x[0], self.minus(x[1]))
            case casadi.OP_NEG:
                return self.minus(x[0])
            case casadi.OP_MUL | casadi.OP_SQ:
                return self.times(x[0], x[-1])
            case casadi.OP_TWICE:
                return self.plus(x[0], x[0])
            case _:
                return self._apply_rarer(op, x)

    def _apply_rarer(self, op: int, x: Sequence[Value]) -> Value:
        match op:
            case casadi.OP_SIN:
                return Value(x[0].sign, self.turn(x[0])[0].node) if x[0].sign > 0 else self.minus(self.turn(x[0])[0])
            case casadi.OP_COS:
                return self.turn(x[0])[1]
            case casadi.OP_DIV:
                return self.over(x[0], x[1])
            case casadi.OP_INV:
                return self.over(self.number(1.0), x[0])
            case casadi.OP_SQRT:
                return self.root(x[0])
            case casadi.OP_LT:
                return self.is_positive(self.plus(x[1], self.minus(x[0])))
            case _:
                return Value(*elementary.apply(self, op, x))


def straight_line_code(
    function: Any, sincos: SinCos, is_flagged: bool = True, flagged_by: FlaggedBy = "inputs"
) -> StraightLineCode:
    """The code of a CasADi function with one output vector.

    Parameters
    ----------
    function : casadi.Function
        Of SX; angles enter only through sines and cosines.
    sincos : SinCos
        Range reduction and polynomials of the number type.
    is_flagged : bool
        Without, the flag is 0: the function judges its numbers itself.
    flagged_by : {"inputs", "few results", "results"}
        Where the flag finds a number that is not finite: in every input; in results that every such input reaches, as
        few as possible (it is NaN where one of them overflows, too); in every input and every result.
    """
    code = _traced(function, sincos, flagged_by if is_flagged else None)
    return without_the_unused(*by_reciprocals(*code))


def _traced(function: Any, sincos: SinCos, flagged_by: FlaggedBy | None) -> Traced:
    """The nodes of all instructions, and of the flag."""
    writer = _Writer(sincos)
    work: dict[int, Value] = {}
    results: dict[int, Value] = {}
    inputs = [
        writer.node("in", row, column) for row in range(function.n_in()) for column in range(function.size1_in(row))
    ]
    for k in range(function.n_instructions()):
        op, out, arguments = (
            function.instruction_id(k), function.instruction_output(k), function.instruction_input(k)
        )  # fmt: skip
        if op == casadi.OP_OUTPUT:
            results[out[1]] = work[arguments[0]]
        elif op == casadi.OP_INPUT:
            work[out[0]] = writer.node("in", *arguments)
        elif op == casadi.OP_CONST:
            work[out[0]] = writer.number(function.instruction_constant(k))
        else:
            work[out[0]] = writer.apply(op, [work[i] for i in arguments])
    ordered = [results.get(i) or writer.number(0.0) for i in range(function.size1_out(0))]
    if flagged_by is None:
        return writer.nodes, ordered, writer.number(0.0)
    reached = reached_inputs(writer.nodes)
    shown = ordered if flagged_by == "results" else [] if flagged_by == "inputs" else _few(reached, ordered)
    known = _together(reached, shown)
    return writer.nodes, ordered, _flag(writer, [*shown, *(x for x in inputs if not known >> x.node & 1)])


def _together(reached: Sequence[int], results: Sequence[Value]) -> int:
    return reduce(or_, (reached[x.node] for x in results), 0)


def _few(reached: Sequence[int], results: Sequence[Value]) -> list[Value]:
    """Few results that the same inputs reach as all of them, the one of most inputs first."""
    left = _together(reached, results)
    chosen = []
    while left:
        best = max(results, key=lambda x: (left & reached[x.node]).bit_count())
        if (left & reached[best.node]).bit_count() < 2:  # the input itself does as well
            break
        chosen.append(best)
        left &= ~reached[best.node]
    return chosen


def _flag(writer: _Writer, numbers: Sequence[Value]) -> Value:
    """Sum of 0 x over the numbers, plus 1 if the squared half turns exceed the limit of the range reduction."""
    zero = writer.node("zero", 0.0)  # a zero that is not folded away: 0 NaN is NaN
    total = writer.number(0.0)
    if writer.turns:
        turned = writer.number(0.0)
        for _, _, turns in writer.turns.values():
            turned = writer.plus(turned, writer.times(turns, turns))
        limit = writer.number(float(writer.sincos.most_half_turns) ** 2)
        total = writer.plus(total, writer.node(">", turned.node, limit.node))
    for x in numbers:
        total = writer.plus(total, writer.times(x, zero))
    return total


def compact(code: StraightLineCode) -> tuple[StraightLineCode, tuple[int, ...], tuple[float, ...]]:
    """Code with every distinct result once, without constants; for each result its place, constants of the others.

    Places count from 1, negative where the sign is turned; 0 is a constant.
    """
    places: dict[int, int] = {}
    entries, constants = [], []
    for value in code.results:
        node = code.nodes[value.node]
        is_constant = node.op == "const"
        constants.append(value.sign * node.a if is_constant else 0.0)
        entries.append(0 if is_constant else value.sign * places.setdefault(value.node, len(places) + 1))
    results = tuple(Value(1, node) for node in places)
    return replace(code, results=results), tuple(entries), tuple(constants)
