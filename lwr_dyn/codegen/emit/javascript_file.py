"""An arm's functions as one JavaScript file: a plain script that defines one name, or an ES module.

Both hold the same object: `robot.NAME(arguments..., out)` fills and returns `out`; without it, it makes one. V8
compiles a function to machine code only while its bytecode is below a bound, and each name costs some: a temporary
takes the name of one that no later operation reads, and a function with more than `LARGEST` operations is written as
several, each with a part of the results. Sine and cosine of one angle are one call, with the bits of the C code; so are
powers of two.
"""

import json
import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Literal, get_args

import casadi

from lwr_dyn.codegen.emit import functions as emit
from lwr_dyn.codegen.emit.emission import EmittedArm, provenance_lines
from lwr_dyn.codegen.kernels.straight_line import OPERATIONS, Node
from lwr_dyn.foundation.errors import OptionError

LARGEST = 3500
"""Operations of one function: at 12 bytes of bytecode each, below V8's 61 440."""

_FORMS = {
    ">": "{0} > {1} ? 1.0 : 0.0", "?": "{0} > 0.5 ? {1} : 0.0", "min": "{0} > {1} ? {1} : {0}",
    "max": "{1} > {0} ? {1} : {0}", "sqrt": "Math.sqrt({0})", "abs": "Math.abs({0})", "2^": "two_to({0})",
    "exponent": "exponent({0})", "significand": "significand({0})",
}  # fmt: skip


def js_function(code: emit.EmittedCode, name: str, sincos: emit.SinCosKind = "own", largest: int = LARGEST) -> str:
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


def _parts(code: emit.EmittedCode, largest: int) -> list[tuple[emit.Operation | emit.Store, ...]]:
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


def _needed(code: emit.EmittedCode, places: Sequence[int]) -> tuple[emit.Operation | emit.Store, ...]:
    """The statements that some results need."""
    wanted = {code.code.results[place].node for place in places}
    for i in range(len(code.nodes) - 1, -1, -1):
        if i in wanted and code.nodes[i].op in OPERATIONS:
            wanted |= {code.nodes[i].a, code.nodes[i].b}
    kept = set(places)
    return tuple(
        s for s in code.statements if (s.index in wanted if isinstance(s, emit.Operation) else s.place in kept)
    )


class _FunctionText:
    """Writes statements, with few names."""

    def __init__(
        self, code: emit.EmittedCode, statements: Sequence[emit.Operation | emit.Store], sincos: emit.SinCosKind
    ) -> None:
        self.code, self.statements, self.sincos = code, statements, sincos
        self.last = {i: k for k, statement in enumerate(statements) for i in _reads(statement)}
        """Node -> the statement that reads it last."""
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

    def _lines(self, k: int, statement: emit.Operation | emit.Store) -> Iterator[str]:
        if isinstance(statement, emit.Store):
            value = statement.value
            yield f"out[{statement.place}] = {'-' if value.sign < 0 else ''}{self._read(value.node)};"
            self._release(k, statement)
            return
        node = statement.node
        if node.op in ("sin", "cos") and self.sincos == "libm":
            right = f"Math.{node.op}({self._read(node.a)})"
        elif node.op in ("sin", "cos"):
            yield from self._turn(node.a)
            right = f"turned[{('sin', 'cos').index(node.op)}]"
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

    def _release(self, k: int, statement: emit.Operation | emit.Store) -> None:
        """The names that no later statement reads may be taken again."""
        used = {i for i in _reads(statement) if i in self.names and self.last[i] == k}
        self.free += sorted((self.names[i] for i in used), reverse=True)

    def _named(self, index: int) -> int:
        if not self.free:
            self.free.append(self.count)
            self.count += 1
        self.names[index] = self.free.pop()
        return self.names[index]


def _reads(statement: emit.Operation | emit.Store) -> tuple[int, ...]:
    return (statement.value.node,) if isinstance(statement, emit.Store) else (statement.node.a, statement.node.b)


_POWERS = """\
const bits = new Float64Array(1), words = new Int32Array(bits.buffer);
const high = new Int8Array(new Int16Array([1]).buffer)[0];
function two_to(n) {
  words[1 - high] = 0;
  words[high] = (n + 1023) << 20;
  return bits[0];
}
function exponent(x) {
  bits[0] = x;
  return ((words[high] >> 20) & 2047) - 1023;
}
function significand(x) {
  bits[0] = x;
  words[high] = (words[high] & 1048575) | 1072693248;
  return bits[0] + (x - x);
}
"""
"""Of normal numbers; NaN and inf have the fraction NaN."""


def shared_functions(text: str) -> str:
    """The functions that a text of emitted functions calls."""
    needs_turns, needs_powers = "sincos(" in text, re.search(r"\b(two_to|exponent|significand)\(", text) is not None
    return (_sincos() if needs_turns else "") + (_POWERS if needs_powers else "")


@cache
def _sincos() -> str:
    """`sincos(x, i)`: sine and cosine of x[i] into `turned`, operation by operation those of the C code."""
    x = casadi.SX.sym("x")
    symbolic = casadi.Function("sincos", [x], [casadi.vertcat(casadi.sin(x), casadi.cos(x))])
    function = emit.EmittedFunction("sincos", "", (emit.Argument("x", 1, "rad"),), (2,), "1", symbolic)
    text = js_function(emit.emitted_code(function, "own"), "sincos")
    head = "const turned = new Float64Array(2);\nfunction sincos(x, i) {"
    text = text.replace("function sincos(x, out = new Float64Array(2)) {", head)
    return text.replace("x[0]", "x[i]").replace("out[", "turned[").replace("  return out;\n", "")


ScriptForm = Literal["script", "module"]

SCRIPT_FORMS = get_args(ScriptForm)

_ENDINGS: dict[str, ScriptForm] = {".js": "script", ".mjs": "module"}

_USE = {
    "script": "a plain script that defines {0}: const result = {0}.{1};",
    "module": "an ES module: import {0} from this file; const result = {0}.{1};",
}

_TAKEN = (
    "arguments await break case catch class const continue debugger default delete do else enum eval export extends "
    "false finally for function if implements import in instanceof interface let new null package private protected "
    "public return static super switch this throw true try typeof undefined var void while with yield NaN Infinity "
    "name top self window parent status location document history length event origin"
)


def js_files(emitted: EmittedArm, path: Path) -> dict[Path, str]:
    """The file, a module where its name ends in .mjs; raises `OptionError` for an ending, type, name it cannot have."""
    if path.suffix not in _ENDINGS:
        raise OptionError("--out", repr(str(path)), "a path that ends in .js (a plain script) or .mjs (an ES module)")
    if emitted.dtype != "float64":
        raise OptionError("--dtype", repr(emitted.dtype), "float64: numbers of JavaScript are double")
    if emitted.prefix in _TAKEN.split():
        raise OptionError("--prefix", repr(emitted.prefix), "a name that JavaScript and browsers have not taken")
    functions: list[emit.Emitted] = [*(code.function for code in emitted.codes), *emitted.templates]
    form = _ENDINGS[path.suffix]
    head = "\n".join([*provenance_lines(emitted), *_use(emitted, form)])
    return {path: javascript_source(functions, emitted.prefix, form, emitted.kind, head=head)}


def javascript_source(
    functions: Sequence[emit.Emitted],
    name: str,
    form: ScriptForm = "script",
    sincos: emit.SinCosKind = "own",
    is_compact: bool = False,
    head: str = "",
) -> str:
    """The text of a file.

    Parameters
    ----------
    functions : sequence of EmittedFunction, TemplateFunction
        Members of the object, beside `name`, `n` (joints) and `functions`: their arguments, results and units.
    name : str
        Of the object: an identifier.
    form : {"script", "module"}
    sincos : {"own", "libm"}
        The bits of the C code, or Math.sin and Math.cos.
    is_compact : bool
        Without the space that only people need.
    head : str
        Lines of a comment at the top.

    Raises
    ------
    OptionError
        Another form.
    """
    if form not in SCRIPT_FORMS:
        raise OptionError("form", repr(form), ", ".join(SCRIPT_FORMS))
    written = [f for f in functions if isinstance(f, emit.EmittedFunction) or "js" in f.source]
    body = "\n".join(_text(f, sincos) for f in written)
    joints = {a.width for f in written if isinstance(f, emit.EmittedFunction) for a in f.arguments if a.name == "q"}
    facts: dict[str, object] = {"name": name, **({"n": max(joints)} if joints else {})}
    names = [name for f in written for name in _names(f)]
    facts["functions"] = {f.name: _facts(f) for f in written}
    members = [*(f"{key}: {json.dumps(value)}" for key, value in facts.items()), *names]
    inside = f"{shared_functions(body)}{body}return {{\n  {f',{chr(10)}  '.join(members)}\n}};\n"
    text = f'(function () {{\n"use strict";\n{inside}}})();\n'
    if form == "script":
        text = f"var {name} = {text}"
    else:
        exported = ", ".join([*facts, *names])
        text = f"const robot = {text}export default robot;\nexport const {{ {exported} }} = robot;\n"
    if is_compact:  # statements without space and with short numbers
        text = "\n".join(map(_short, text.splitlines())) + "\n"
    return "".join(f"// {line}".rstrip() + "\n" for line in head.splitlines()) + text


def _text(function: emit.Emitted, sincos: emit.SinCosKind) -> str:
    if isinstance(function, emit.EmittedFunction):
        return js_function(emit.emitted_code(function, "libm"), function.name, sincos)
    members = ", ".join(_names(function))
    source = function.written("js", sincos).replace("@NAME@", function.name)
    return f"const {{ {members} }} = (function () {{\n{source.rstrip()}\nreturn {{ {members} }};\n}})();\n"


def _names(function: emit.Emitted) -> list[str]:
    """Members of the object: a template may give several."""
    if isinstance(function, emit.EmittedFunction):
        return [function.name]
    return [name.strip() for name in function.declaration.get("js", function.name).split(",")]


def _facts(function: emit.Emitted) -> dict[str, object]:
    if isinstance(function, emit.TemplateFunction):
        return {"text": function.text}
    arguments = [[a.name, a.width, a.unit] for a in function.arguments]
    return {"arguments": arguments, "width": function.width, "shape": list(function.shape), "unit": function.unit,
            "text": function.text}  # fmt: skip


def _use(emitted: EmittedArm, form: ScriptForm) -> list[str]:
    """How the file is used, by its first function."""
    if not emitted.codes:
        return []
    function = emitted.codes[0].function
    call = f"{function.name}({', '.join(a.name for a in function.arguments)})"
    first = _USE[form].format(emitted.prefix, call)
    return [first, "arrays of numbers; a last argument out is filled and returned, without it a new one is made"]


_STATEMENT = re.compile(r"(v\d+|out\[\d+\]|turned\[\d\]) = ")


def _short(line: str) -> str:
    """A line that is no statement stays."""
    line = line.lstrip()
    if not _STATEMENT.match(line):
        return line
    line = re.sub(r"\b0(\.\d+)", r"\1", re.sub(r"(\d)\.0\b", r"\1", line))
    return line.replace(" ", "")
