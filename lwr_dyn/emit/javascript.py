"""Operations -> JavaScript: one function each, over arrays of numbers; names of temporaries are used again.

V8 compiles a function to machine code only while its bytecode is below a bound, and each name costs some: a temporary
takes the name of one that no later operation reads, and a function with more than `LARGEST` operations is written as
several, each with a part of the results.
"""

from collections.abc import Iterator, Sequence

from lwr_dyn.codegen.straight_line import OPERATIONS, Node
from lwr_dyn.emit.straight_code import EmittedCode, Operation, Store

LARGEST = 3500
"""Operations of one function: at 12 bytes of bytecode each, below V8's 61 440."""
_FORMS = {
    ">": "{0} > {1} ? 1.0 : 0.0", "?": "{0} > 0.5 ? {1} : 0.0", "min": "{0} > {1} ? {1} : {0}",
    "max": "{1} > {0} ? {1} : {0}", "sqrt": "Math.sqrt({0})", "abs": "Math.abs({0})", "sin": "Math.sin({0})",
    "cos": "Math.cos({0})",
}  # fmt: skip


def js_function(code: EmittedCode, name: str) -> str:
    """The function, and those that it is split into."""
    arguments = ", ".join(a.name for a in code.function.arguments)
    parts = _parts(code)
    if len(parts) == 1:
        return _function(code, name, arguments, parts[0])
    several = [_function(code, f"{name}_{k}", arguments, part) for k, part in enumerate(parts, 1)]
    calls = "".join(f"  {name}_{k}({arguments}, out);\n" for k in range(1, len(parts) + 1))
    return "\n".join([*several, f"function {name}({arguments}, out) {{\n{calls}  return out;\n}}\n"])


def _parts(code: EmittedCode) -> list[tuple[Operation | Store, ...]]:
    """The statements, split by results until no part is too large."""
    parts = [range(len(code.code.results))]
    while True:
        chosen = [_needed(code, part) for part in parts]
        large = [
            i for i, (part, places) in enumerate(zip(chosen, parts, strict=True))
            if len(part) - len(places) > LARGEST and len(places) > 1
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


def _function(code: EmittedCode, name: str, arguments: str, statements: Sequence[Operation | Store]) -> str:
    lines, count = _lines(code, statements)
    names = ", ".join(f"v{i}" for i in range(count))
    head = [f"function {name}({arguments}, out) {{", *([f"  let {names};"] if count else [])]
    return "\n".join([*head, *(f"  {line}" for line in lines), "  return out;", "}", ""])


def _lines(code: EmittedCode, statements: Sequence[Operation | Store]) -> tuple[list[str], int]:
    """The statements, and how many names they need."""
    last = _last_uses(code, statements)
    names: dict[int, str] = {}
    free: list[int] = []
    count = 0
    lines: list[str] = []

    def read(i: int) -> str:
        node: Node = code.nodes[i]
        if node.op == "const":
            return repr(float(node.a))
        return f"{code.function.arguments[node.a].name}[{node.b}]" if node.op == "in" else names[i]

    for k, statement in enumerate(statements):
        if isinstance(statement, Store):
            value = statement.value
            lines.append(f"out[{statement.place}] = {'-' if value.sign < 0 else ''}{read(value.node)};")
            used = {value.node}
        else:
            node = statement.node
            form = _FORMS.get(node.op, f"{{0}} {node.op} {{1}}")
            right, used = form.format(read(node.a), read(node.b)), {node.a, node.b}
        free += sorted((int(names[i][1:]) for i in used if i in names and last[i] == k), reverse=True)
        if isinstance(statement, Operation):
            if not free:
                free.append(count)
                count += 1
            names[statement.index] = f"v{free.pop()}"
            lines.append(f"{names[statement.index]} = {right};")
    return lines, count


def _last_uses(code: EmittedCode, statements: Sequence[Operation | Store]) -> dict[int, int]:
    """Node -> the statement that reads it last."""
    last: dict[int, int] = {}
    for k, statement in enumerate(statements):
        for i in _reads(statement):
            last[i] = k
    return last


def _reads(statement: Operation | Store) -> Iterator[int]:
    if isinstance(statement, Store):
        yield statement.value.node
    else:
        yield statement.node.a
        yield statement.node.b
