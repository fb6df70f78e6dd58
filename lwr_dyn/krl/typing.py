"""Types of expressions in a scope, with a diagnosis where they do not fit; unknown types fit everything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.diagnosis import Diagnosis, Severity
from lwr_dyn.krl.known import CONFIG, FUNCTIONS, SYSTEM
from lwr_dyn.krl.program import Names, Program, known_structure
from lwr_dyn.krl.source import SourceFile
from lwr_dyn.krl.types import BOOL, CARTESIAN, ENUMS, INT, NUMBERS, REAL, STRUCTURES, UNKNOWN, Type, assignable

LARGEST = 2**31 - 1


@dataclass(slots=True)
class Scope:
    """Names that can be seen in one routine: its own, then the program's, then the controller's."""

    program: Program
    own: Names
    file: SourceFile
    found: list[Diagnosis]
    line: int = 0

    def say(self, column: int, code: str, message: str, hint: str = "", severity: Severity = "error") -> None:
        """A diagnosis in the line that is looked at."""
        self.found.append(Diagnosis(self.file.place(self.line, max(column, 1)), severity, code, message, hint))

    def variable(self, name: str) -> Type | None:
        """The type of a variable; None where it is not declared."""
        key = name.upper()
        for names in (self.own, self.program.names):
            if key in names.variables:
                return names.variables[key].type
        if key.startswith("$"):
            return SYSTEM.get(key, UNKNOWN)
        return CONFIG.get(key)

    def structure(self, name: str) -> Any:
        """Components of a structure, or None."""
        return known_structure(self.own, name) or known_structure(self.program.names, name)

    def enum(self, name: str) -> frozenset[str] | None:
        """Members of an enumeration, or None."""
        return self.own.enums.get(name) or self.program.names.enums.get(name) or ENUMS.get(name)

    def is_type(self, name: str) -> bool:
        """Whether a type of that name exists."""
        simple = name in ("INT", "REAL", "BOOL", "CHAR", "?")
        return simple or self.structure(name) is not None or self.enum(name) is not None

    def near(self, name: str) -> str:
        """A hint to the name that was probably meant."""
        known = {v.name for names in (self.own, self.program.names) for v in names.variables.values()}
        near = get_close_matches(name, sorted(known), n=1, cutoff=0.5)
        if near:
            return f"did you mean {near[0]}?"
        where = "" if self.program.data is not None else "; no .dat is there"
        return f"declare it in the .dat or with DECL{where}"


def type_in(scope: Scope, x: e.Expression) -> Type:
    """The type of an expression; what does not fit is said in `scope.found`."""
    return _TYPES[type(x)](scope, x)


def fits(scope: Scope, target: Type, x: e.Expression, what: str) -> None:
    """Say so when a value cannot go into `target`; an aggregate must name components that the target has."""
    if isinstance(x, e.Aggregate) and x.type is None and target.name != "?":
        _components(scope, x, target)
        return
    if isinstance(x, e.EnumConstant):
        _member(scope, x, target)
        return
    value = type_in(scope, x)
    if target.name == "CHAR" and value.name == "CHAR":
        return
    if not assignable(target, value):
        scope.say(x.column, "type", f"{what} is {target}, the value is {value}", f"a value of type {target}")


def _integer(scope: Scope, x: e.Integer) -> Type:
    if x.value > LARGEST and not (x.base != 10 and x.value <= 2 * LARGEST + 1):
        scope.say(x.column, "number-range", f"{x.value} is no INT", f"from {-LARGEST - 1} to {LARGEST}, or a REAL")
    return INT


def _real(scope: Scope, x: e.Real) -> Type:
    if abs(x.value) > 3.4e38:
        scope.say(x.column, "number-range", f"{x.value:g} is no REAL", "up to 3.4E38")
    return REAL


def _name(scope: Scope, x: e.Name) -> Type:
    found = scope.variable(x.name)
    if found is None:
        scope.say(x.column, "undeclared", f"{x.name} is not declared", scope.near(x.name))
        return UNKNOWN
    return found


def _index(scope: Scope, x: e.Index) -> Type:
    of = type_in(scope, x.of)
    for i in x.indices:
        if not assignable(INT, type_in(scope, i)):
            scope.say(i.column, "type", "an index must be INT", "a whole number from 1")
    if of.name == "?" or not x.indices:
        return of
    if of.dimensions == 0:
        scope.say(x.column, "no-array", "an index on what is no array", "declare it with brackets")
        return of
    if len(x.indices) != of.dimensions:
        said = f"{len(x.indices)} indices on an array of {of.dimensions}"
        scope.say(x.column, "no-array", said, f"{of.dimensions} indices")
    return of.element


def _component(scope: Scope, x: e.Component) -> Type:
    of = type_in(scope, x.of)
    if of.name == "?":
        return UNKNOWN
    known = scope.structure(of.name)
    found: Type | None = None if known is None or of.dimensions else known.get(x.name.upper())
    if found is None:
        allowed = ", ".join(known) if known and not of.dimensions else "a structure before the point"
        scope.say(x.column, "no-component", f"{of} has no component {x.name}", allowed)
        return UNKNOWN
    return found


def _call(scope: Scope, x: e.Call) -> Type:
    returned, fewest, most = signature(scope, x)
    given = len(x.arguments)
    for argument in x.arguments:
        if argument is not None:
            type_in(scope, argument)
    if not fewest <= given <= most:
        allowed = str(fewest) if fewest == most else f"{fewest} to {most}"
        scope.say(x.column, "arguments", f"{x.name} is given {given} arguments", f"it takes {allowed}")
    return UNKNOWN if returned is None else returned


def signature(scope: Scope, x: e.Call) -> tuple[Type | None, int, int]:
    """What a call returns, and how many arguments it takes at least and at most."""
    routine = scope.program.routine(x.name)
    if routine is not None:
        kind = routine.head.returns
        returned = None if kind is None else Type(kind.upper(), int(routine.head.returns_array))
        return returned, 0, len(routine.head.parameters)
    external = scope.own.externals.get(x.name.upper()) or scope.program.names.externals.get(x.name.upper())
    if external is not None:
        return (None if external.returns is None else Type(external.returns.upper())), 0, len(external.parameters)
    known = FUNCTIONS.get(x.name.upper())
    if known is not None:
        return known
    if scope.variable(x.name) is None:
        near = get_close_matches(x.name.upper(), [r.name for r in scope.program.routines] + list(FUNCTIONS), n=1)
        hint = f"did you mean {near[0]}?" if near else "define it, declare it with EXT, or name its file with --with"
        scope.say(x.column, "undeclared", f"the subprogram {x.name} is not known", hint)
    else:
        scope.say(x.column, "type", f"{x.name} is a variable, no subprogram", "an array takes square brackets")
    return UNKNOWN, 0, LARGEST


def _aggregate(scope: Scope, x: e.Aggregate) -> Type:
    if x.type is not None:
        target = Type(x.type.upper())
        if not scope.is_type(target.name):
            scope.say(x.column, "unknown-type", f"{x.type} is no type", "a structure that is declared or built in")
            return UNKNOWN
        _components(scope, x, target)
        return target
    for item in x.items:
        type_in(scope, item.value)
    return shape_of(x)


def shape_of(x: e.Aggregate) -> Type:
    """The geometric type that has these components, else unknown.

    >>> str(shape_of(e.Aggregate((e.Item("X", e.Integer(1)), e.Item("S", e.Integer(2))))))
    'POS'
    """
    names = {item.name.upper() for item in x.items}
    for kind in ("FRAME", "POS", "E3POS", "E6POS", "AXIS", "E3AXIS", "E6AXIS"):
        if names <= set(STRUCTURES[kind]):
            return Type(kind)
    return UNKNOWN


def _components(scope: Scope, x: e.Aggregate, target: Type) -> None:
    known = scope.structure(target.name)
    if known is None or target.dimensions:
        if target.name != "?" and scope.is_type(target.name):
            scope.say(x.column, "type", f"a structure where {target} is expected", f"a value of type {target}")
        return
    seen: set[str] = set()
    for item in x.items:
        name = item.name.upper()
        if name not in known:
            scope.say(item.column, "no-component", f"{target} has no component {item.name}", ", ".join(known))
            type_in(scope, item.value)
        else:
            fits(scope, known[name].element if item.indices else known[name], item.value, f"component {item.name}")
        if name in seen and item.indices is None:
            scope.say(item.column, "duplicate-name", f"the component {item.name} is given twice", "remove one")
        seen.add(name)


def _member(scope: Scope, x: e.EnumConstant, target: Type) -> None:
    if target.name == "?":
        return
    members = scope.enum(target.name)
    if members is None:
        if target.name in ("INT", "REAL", "BOOL", "CHAR") or scope.structure(target.name) is not None:
            scope.say(x.column, "type", f"#{x.name} where {target} is expected", f"a value of type {target}")
    elif x.name.upper() not in members and target.name not in ENUMS:
        scope.say(x.column, "no-component", f"{target} has no constant #{x.name}", ", ".join(sorted(members)))


def _unary(scope: Scope, x: e.Unary) -> Type:
    of = type_in(scope, x.operand)
    wanted = {"NOT": {"BOOL"}, "B_NOT": {"INT", "CHAR"}}.get(x.operator, NUMBERS)
    return _checked(scope, x, of, of, wanted)


def _binary(scope: Scope, x: e.Binary) -> Type:
    left, right = type_in(scope, x.left), type_in(scope, x.right)
    if x.operator == ":":
        _checked(scope, x, left, right, set(CARTESIAN))
        return right
    if x.operator in ("AND", "OR", "EXOR"):
        return _checked(scope, x, left, right, {"BOOL"}, BOOL)
    if x.operator.startswith("B_"):
        return _checked(scope, x, left, right, {"INT", "CHAR"}, INT)
    if x.operator in ("+", "-", "*", "/"):
        result = INT if left.name == right.name == "INT" else REAL
        return _checked(scope, x, left, right, NUMBERS, result)
    return _comparison(scope, x, left, right)


def _comparison(scope: Scope, x: e.Binary, left: Type, right: Type) -> Type:
    ordered = x.operator not in ("==", "<>")
    if not assignable(left, right) or (ordered and left.name not in (NUMBERS | {"?"})):
        hint = "numbers" if ordered else "two values of one type"
        if "BOOL" in (left.name, right.name):
            hint += "; comparisons bind weaker than AND and OR: put each in brackets"
        scope.say(x.column, "type", f"{left} {x.operator} {right} has no meaning", hint)
    return BOOL


def _checked(
    scope: Scope, x: e.Unary | e.Binary, left: Type, right: Type, wanted: Any, result: Type | None = None
) -> Type:
    for side in (left, right):
        if side.name not in wanted and side.name != "?":
            hint = f"{' or '.join(sorted(wanted))} on both sides" if isinstance(x, e.Binary) else "another operator"
            if wanted == {"BOOL"} and side.name in NUMBERS:
                hint += "; comparisons bind weaker than AND and OR: put each in brackets"
            scope.say(x.column, "type", f"{x.operator} on {side}", hint)
            return result or UNKNOWN
    return result or left


_TYPES: dict[type, Callable[[Scope, Any], Type]] = {
    e.Integer: _integer,
    e.Real: _real,
    e.Bool: lambda scope, x: BOOL,
    e.Text: lambda scope, x: Type("CHAR", 0 if len(x.value) == 1 else 1),
    e.EnumConstant: lambda scope, x: UNKNOWN,
    e.Name: _name,
    e.Index: _index,
    e.Component: _component,
    e.Call: _call,
    e.Aggregate: _aggregate,
    e.Unary: _unary,
    e.Binary: _binary,
}
