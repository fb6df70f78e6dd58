"""Texts in the small part of C (closed forms, loops of kernels) as LLVM's intermediate language.

Sums and products stay as they are written, none is fused, so the bits are those of C, JavaScript and Python. The
numbers of an arm are a table that every function gets, so one compilation serves all arms of a kind.
"""

import struct
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.closed_forms import tree

_KINDS = {"double": "double", "int": "i64", "void": "void", "double*": "ptr"}

_ARITHMETIC = {"+": "add", "-": "sub", "*": "mul", "/": "div", "%": "rem"}

_COMPARED = {
    "<": ("olt", "slt"), ">": ("ogt", "sgt"), "<=": ("ole", "sle"), ">=": ("oge", "sge"), "==": ("oeq", "eq"),
    "!=": ("une", "ne"),
}  # fmt: skip

_INTRINSICS = {
    "sqrt": "llvm.sqrt.f64", "floor": "llvm.floor.f64", "fabs": "llvm.fabs.f64", "copysign": "llvm.copysign.f64",
}  # fmt: skip

_ELSEWHERE = ("@llvm.floor.f64(double)", "@llvm.copysign.f64(double, double)")
"""Those that `DECLARATIONS` leaves out."""

Value = tuple[str, str]
"""(LLVM's type, name or literal)."""


def double(x: float) -> str:
    """A double by its bits."""
    return f"0x{struct.unpack('>Q', struct.pack('>d', x))[0]:016X}"


@dataclass(frozen=True, slots=True)
class TablePlace:
    """Where in the table of an arm's numbers a name begins."""

    at: int
    is_array: bool


def table_places(numbers: Mapping[str, Any]) -> dict[str, TablePlace]:
    """Of all names; whole numbers are in the text itself."""
    found, at = {}, 0
    for name, value in numbers.items():
        if not isinstance(value, int):
            found[name] = TablePlace(at, np.ndim(value) > 0)
            at += np.size(value)
    return found


def table(numbers: Mapping[str, Any]) -> Array:
    """The numbers at these places."""
    return np.concatenate(
        [np.ravel(np.asarray(x, dtype=np.float64)) for x in numbers.values() if not isinstance(x, int)]
    )


DECLARATIONS = "declare double @llvm.sqrt.f64(double)\ndeclare double @llvm.fabs.f64(double)\n"
"""What stands in front of the functions of a text, unless it stands there already."""


def llvm_text(text: tree.CText, constants: Mapping[str, Any], places: Mapping[str, TablePlace], entry: str) -> str:
    """The functions of a text, and `kernel` (given, step, out, numbers, start, stop) around its function `entry`.

    Constants are the same for every arm; `places` are those of `table_places`.
    """
    kernel = [
        "define i64 @kernel(ptr %given, i64 %step, ptr %out, ptr %numbers, i64 %start, i64 %stop) {",
        f"  %r = call i64 @{entry}(ptr %numbers, ptr %given, ptr %out)", "  ret i64 %r", "}",
    ]  # fmt: skip
    return "\n".join([llvm_functions(text, constants, places), *kernel]) + "\n"


def llvm_functions(
    text: tree.CText,
    constants: Mapping[str, Any],
    places: Mapping[str, TablePlace],
    others: Iterable[tree.CFunction] = (),
) -> str:
    """The functions of a text, each with the table of numbers in front of its arguments; `others` stand elsewhere."""
    known = {name: value for name, value in {**constants, **text.constants}.items() if not isinstance(value, int)}
    lines = [
        f"@{name} = internal constant [{np.size(value)} x double] "
        f"[{', '.join(f'double {double(x)}' for x in np.ravel(value))}]"
        for name, value in known.items()
        if np.ndim(value)
    ]
    kinds = {f.name: f for f in (*others, *text.functions)}
    for function in text.functions:
        lines += _LlvmWriter(function, kinds, known, places).lines()
    lines += [f"declare double {call}" for call in _ELSEWHERE if any(call.partition("(")[0] in line for line in lines)]
    return "\n".join(lines)


class _LlvmWriter:
    """Of one function."""

    def __init__(
        self,
        function: tree.CFunction,
        functions: Mapping[str, tree.CFunction],
        known: Mapping[str, Any],
        places: Mapping[str, TablePlace],
    ) -> None:
        self._function, self._functions, self._known, self._places = function, functions, known, places
        self._room: list[str] = []
        self._body: list[str] = []
        self._variables: dict[str, str] = {}
        """Name -> LLVM's type; "ptr" for arrays."""
        self._count = 0
        self._inlined = all(isinstance(x, tree.CReturn) for x in function.body)
        """Inside a loop that only sets numbers: what it calls is put in, so that LLVM can work at many at once."""

    def lines(self) -> list[str]:
        """The definition."""
        function = self._function
        arguments = ", ".join(
            ["ptr noalias readonly %numbers", *(f"{_KINDS[kind]} %given.{name}" for kind, name in function.arguments)]
        )
        for kind, name in function.arguments:
            if kind == "double*":
                self._variables[name] = "ptr"
                self._body.append(f"  %{name}.p = getelementptr double, ptr %given.{name}, i64 0")
            else:
                self._declare(name, _KINDS[kind])
                self._body.append(f"  store {_KINDS[kind]} %given.{name}, ptr %{name}.{_KINDS[kind]}")
        self._statements(function.body)
        end = {"void": "ret void", "int": "ret i64 0", "double": f"ret double {double(0.0)}"}[function.kind]
        kind = _KINDS[function.kind]
        return [f"define internal {kind} @{function.name}({arguments}) {{", *self._room, *self._body, f"  {end}", "}"]

    def _new(self) -> str:
        self._count += 1
        return f"%t{self._count}"

    def _emit(self, kind: str, code: str) -> Value:
        name = self._new()
        self._body.append(f"  {name} = {code}")
        return kind, name

    def _label(self, name: str) -> None:
        self._body += [f"  br label %{name}", f"{name}:"]

    def _declare(self, name: str, kind: str) -> None:
        room = f"  %{name}.{kind} = alloca {kind}"
        if room not in self._room:
            self._room.append(room)
        self._variables[name] = kind

    def _statements(self, statements: Iterable[tree.CStatement]) -> None:
        for x in statements:
            self._statement(x)

    def _statement(self, x: tree.CStatement) -> None:
        match x:
            case tree.CRoom(name, size):
                self._room.append(f"  %{name}.p = alloca [{size} x double]")
                self._variables[name] = "ptr"
            case tree.CSet():
                self._set(x)
            case tree.CDo(call):
                self._call(call)
            case tree.CReturn(value):
                self._return(value)
            case tree.CFor(name, first, end, step, body):
                self._set(tree.CSet("int", tree.CName(name), first))
                counted = tree.CSet("", tree.CName(name), tree.CBinary("+", tree.CName(name), tree.CNumber(step)))
                outside, self._inlined = self._inlined, all(isinstance(y, tree.CSet) for y in body)
                self._while(tree.CBinary("<", tree.CName(name), end), (*body, counted))
                self._inlined = outside
            case tree.CWhile(test, body):
                self._while(test, body)
            case tree.CIf(test, yes, no):
                self._branch(test, lambda: self._statements(yes), lambda: self._statements(no))

    def _set(self, x: tree.CSet) -> None:
        value = self._value(x.value)
        if isinstance(x.target, tree.CItem):
            kind, place = "double", self._place(x.target)
        else:
            if x.declared:
                self._declare(x.target.name, _KINDS[x.declared])
            kind = self._variables[x.target.name]
            place = f"%{x.target.name}.{kind}"
        self._body.append(f"  store {kind} {self._as(value, kind)}, ptr {place}")

    def _return(self, value: tree.CExpression | None) -> None:
        kind = _KINDS[self._function.kind]
        result = "void" if value is None else f"{kind} {self._as(self._value(value), kind)}"
        self._body += [f"  ret {result}", f"{self._new()[1:]}.dead:"]

    def _while(self, test: tree.CExpression, body: Iterable[tree.CStatement]) -> None:
        name = self._new()[1:]
        self._label(f"{name}.test")
        condition = self._as(self._value(test), "i1")
        self._body += [f"  br i1 {condition}, label %{name}.body, label %{name}.end", f"{name}.body:"]
        self._statements(body)
        self._body += [f"  br label %{name}.test", f"{name}.end:"]

    def _branch(self, test: tree.CExpression, yes: Callable[[], None], no: Callable[[], None]) -> None:
        """What `yes` or `no` emit, by the test."""
        name, condition = self._new()[1:], self._as(self._value(test), "i1")
        self._body += [f"  br i1 {condition}, label %{name}.yes, label %{name}.no", f"{name}.yes:"]
        yes()
        self._body += [f"  br label %{name}.end", f"{name}.no:"]
        no()
        self._label(f"{name}.end")

    def _as(self, value: Value, kind: str) -> str:
        """The value as another type."""
        had, name = value
        if had == kind:
            return name
        if kind == "double":
            return self._emit(kind, f"sitofp i64 {self._as(value, 'i64')} to double")[1]
        return self._emit(kind, f"zext i1 {name} to i64" if kind == "i64" else f"icmp ne i64 {name}, 0")[1]

    def _place(self, x: tree.CItem) -> str:
        """The address of an array's number."""
        at = self._as(self._value(x.place), "i64")
        if x.array in self._places and x.array not in self._variables:
            at = self._emit("i64", f"add i64 {at}, {self._places[x.array].at}")[1]
            base = "%numbers"
        else:
            base = f"@{x.array}" if x.array in self._known else f"%{x.array}.p"
        return self._emit("ptr", f"getelementptr double, ptr {base}, i64 {at}")[1]

    def _value(self, x: tree.CExpression) -> Value:
        match x:
            case tree.CNumber(value):
                return ("i64", str(value)) if isinstance(value, int) else ("double", double(value))
            case tree.CName(name):
                return self._named(name)
            case tree.CItem():
                return self._emit("double", f"load double, ptr {self._place(x)}")
            case tree.CCall():
                return self._call(x)
            case tree.CUnary(sign, of):
                return self._unary(sign, self._value(of))
            case tree.CBinary():
                return self._binary(x)
            case tree.CChoice(test, yes, no):
                return self._choice(test, lambda: self._value(yes), lambda: self._value(no))

    def _named(self, name: str) -> Value:
        if name in self._variables:
            kind = self._variables[name]
            return (kind, f"%{name}.p") if kind == "ptr" else self._emit(kind, f"load {kind}, ptr %{name}.{kind}")
        if name == "NAN":
            return "double", double(float("nan"))
        if name in self._known:
            return ("ptr", f"@{name}") if np.ndim(self._known[name]) else ("double", double(float(self._known[name])))
        where = self._emit("ptr", f"getelementptr double, ptr %numbers, i64 {self._places[name].at}")
        return where if self._places[name].is_array else self._emit("double", f"load double, ptr {where[1]}")

    def _unary(self, sign: str, value: Value) -> Value:
        if sign == "!":
            return self._emit("i1", f"xor i1 {self._as(value, 'i1')}, true")
        return self._emit(value[0], f"fneg double {value[1]}" if value[0] == "double" else f"sub i64 0, {value[1]}")

    def _binary(self, x: tree.CBinary) -> Value:
        if x.sign == "&&":
            return self._choice(x.left, lambda: self._truth(x.right), lambda: ("i1", "false"))
        if x.sign == "||":
            return self._choice(x.left, lambda: ("i1", "true"), lambda: self._truth(x.right))
        sign, left, right = x.sign, self._value(x.left), self._value(x.right)
        kind = "double" if "double" in (left[0], right[0]) else "i64"
        pair = f"{kind} {self._as(left, kind)}, {self._as(right, kind)}"
        if sign in _COMPARED:
            ordered, whole = _COMPARED[sign]
            return self._emit("i1", f"fcmp {ordered} {pair}" if kind == "double" else f"icmp {whole} {pair}")
        name = _ARITHMETIC[sign]
        prefix = "f" if kind == "double" else "s" if sign in "/%" else ""
        return self._emit(kind, f"{prefix}{name} {pair}")

    def _truth(self, x: tree.CExpression) -> Value:
        return "i1", self._as(self._value(x), "i1")

    def _choice(self, test: tree.CExpression, yes: Callable[[], Value], no: Callable[[], Value]) -> Value:
        """By a branch, as only the one that is chosen may be worked out; both are of one type."""
        kinds, room = set[str](), f"%choice.{self._new()[1:]}"

        def kept(of: Callable[[], Value]) -> None:
            kind, value = of()
            kinds.add(kind)
            self._body.append(f"  store {kind} {value}, ptr {room}")

        self._branch(test, lambda: kept(yes), lambda: kept(no))
        (kind,) = kinds
        self._room.append(f"  {room} = alloca {kind}")
        return self._emit(kind, f"load {kind}, ptr {room}")

    def _call(self, x: tree.CCall) -> Value:
        given = [self._value(y) for y in x.arguments]
        if x.function == "int":
            return self._emit("i64", f"fptosi double {self._as(given[0], 'double')} to i64")
        if x.function in _INTRINSICS:
            numbers = ", ".join(f"double {self._as(y, 'double')}" for y in given)
            return self._emit("double", f"call double @{_INTRINSICS[x.function]}({numbers})")
        function = self._functions[x.function]
        kinds = [_KINDS[kind] for kind, _ in function.arguments]
        arguments = ", ".join(f"{kind} {self._as(y, kind)}" for kind, y in zip(kinds, given, strict=True))
        code = f"call {_KINDS[function.kind]} @{function.name}(ptr %numbers, {arguments})"
        code += " alwaysinline" * self._inlined
        if function.kind == "void":
            self._body.append(f"  {code}")
            return "void", ""
        return self._emit(_KINDS[function.kind], code)
