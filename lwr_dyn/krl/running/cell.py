"""A cell: what stands around a program: the robot, inputs, states, variables of a PLC, tools, stubs, its answers.

It is read from a cell file (TOML); its constants are written in KRL's own form: `3`, `TRUE`, `#EX`, `{X 1, Y 2}`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any, NoReturn

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.files import read_text
from lwr_dyn.krl.diagnostics import ExecutionError, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.declarations import External
from lwr_dyn.krl.language.line_parser import statement_of
from lwr_dyn.krl.language.statements import Assign, Condition, Invoke
from lwr_dyn.krl.names.known_names import CONFIG, SIMPLE, SYSTEM, UNKNOWN, Type
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.project.project import DeclaredName
from lwr_dyn.krl.running.evaluate import value_of
from lwr_dyn.krl.running.values import POSE_NAMES, StructValue, Value, converted


@dataclass(frozen=True, slots=True, eq=False)
class Stub:
    """A routine that is not there: what its call returns (None: nothing) and puts into its arguments, from 1."""

    returns: Value | None = None
    out: Mapping[int, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Reply:
    """What a PLC does: `after` [s] from the time at which `when` becomes true, or from the start, it sets values."""

    when: e.Expression | None
    after: float
    values: Mapping[str, Value]


@dataclass(frozen=True, slots=True, eq=False)
class RobotCell:
    """The surroundings of a program; an empty one gives nothing."""

    file: str = ""
    robot: str | None = None
    home_deg: tuple[float, ...] | None = None
    """Where the arm stands before the first motion, and XHOME."""
    called_at_deg: tuple[float, ...] | None = None
    """Where the arm stands when the routine that is run is called from another; None: it is started by itself."""
    ignore_turn: bool = False
    """Whether points are reached by the nearest solution with their Status, as of an assumed robot."""
    values: Mapping[str, Value] = field(default_factory=dict)
    """Inputs, states, variables, tools and bases: `$IN[3]`, `$T1`, `PART`, `TOOL_DATA[1]`, in capitals."""
    other_inputs: bool | None = None
    """The value of an input that is not listed; None: a program that asks for it stops."""
    stubs: Mapping[str, Stub] = field(default_factory=dict)
    """By name in capitals."""
    other_stubs: bool = False
    """Whether every other function that is not there returns FALSE, 0 or an empty structure."""
    arguments: Mapping[str, Value] = field(default_factory=dict)
    """Of the routine that is run, by the names of its parameters in capitals."""
    replies: tuple[Reply, ...] = ()
    submits: tuple[str, ...] = ()
    """Paths of submit programs (.sub) that run beside."""
    unmet_wait: float | None = None
    """[s] After which a WAIT FOR that nothing fulfils counts as fulfilled; None: the program stops there."""


PLACE = re.compile(r"\$?[A-Z_][A-Z0-9_$]*(\[\d{1,6}(,\d{1,6})*\])?(\.[A-Z_][A-Z0-9_]*)*")
"""What can be given from outside, in capitals."""


def constant_value(text: str) -> Value:
    """The value of a constant; raises `ExecutionError` where the text is none.

    >>> constant_value("{X 1.5}").parts["X"]
    1.5
    """
    return _assigned(f"X={text}")[1]


def input_values(texts: Sequence[str]) -> dict[str, Value]:
    """Inputs and variables set from outside, written as `$IN[3]=TRUE`: name -> value; raises `OptionError`.

    >>> input_values(["$IN[3]=TRUE", "n=2"])
    {'$IN[3]': True, 'N': 2}
    """
    values = {}
    for text in texts:
        try:
            name, value = _assigned(text)
        except ExecutionError:
            raise OptionError("--set", repr(text), "NAME=VALUE with a constant, such as $IN[3]=TRUE") from None
        try:
            refuse_place(name, value)
        except ExecutionError as fault:
            raise OptionError("--set", repr(text), fault.hint or fault.message) from None
        values[name] = value
    return values


def refuse_place(name: str, value: Value) -> None:
    """Raises `ExecutionError` where nothing is called so, or where an input or state is of another type.

    >>> refuse_place("$IN[0]", True)
    Traceback (most recent call last):
    ...
    lwr_dyn.krl.diagnostics.ExecutionError: $IN[0]
    """
    if not PLACE.fullmatch(name) or not isinstance(statement_of(f"{name}=0"), Assign):
        raise ExecutionError("name", name, "a name such as $IN[3], $T1, $ERR.NUMBER, PART, P[3]")
    root, indices, parts = re.match(r"([^\[.]*)(\[.*\])?(.*)", name).groups()  # type: ignore[union-attr]
    kind = SYSTEM.get(root, UNKNOWN)
    numbers = () if indices is None else tuple(map(int, indices[1:-1].split(",")))
    if kind.name == "?" or (kind.dimensions and kind.name not in SIMPLE):
        return
    if len(numbers) != kind.dimensions or not all(1 <= n <= m for n, m in zip(numbers, kind.sizes, strict=False)):
        most = f"{root}[1] to {root}[{kind.sizes[0]}]" if kind.sizes else f"{root} with its indices, from 1"
        raise ExecutionError("index-range", name, most if kind.dimensions else f"{root} without an index")
    if not parts:
        converted(value, kind.element)


def _assigned(text: str) -> tuple[str, Value]:
    name, statement = text.partition("=")[0], statement_of(text)
    if not isinstance(statement, Assign):
        raise ExecutionError("syntax", text)
    return name.replace(" ", "").upper(), value_of(_NoNames(), statement.value)


class _NoNames:
    """An environment without names: only constants have a value."""

    def signal_reference(self, name: str) -> None:
        return None

    def variable(self, *_: Any, **__: Any) -> NoReturn:
        raise ExecutionError("undeclared", "a name")

    element = call = note_read = variable

    def component_type(self, struct: str, name: str) -> Type:
        return UNKNOWN


AXES = "a list of numbers: the six axes in deg"
FRAMES = "a list of numbers: X, Y, Z, A, B, C in mm and deg"
MOST = 1e9
"""[mm, deg] Of a coordinate or an axis."""
LONGEST = 1e6
"""[s] The latest time of an event."""


def read_cell(path: str | Path) -> RobotCell:
    """Read a cell file; raises `FileAccessError`, or `PaperError` for a field that is missing, unknown or wrong."""
    text = read_text(path, "a cell file (TOML): lwr-dyn new cell FILE writes one")
    return cell_of(parse_toml(text, str(path)), str(path))


def cell_of(table: Mapping[str, Any], file: str = "cell") -> RobotCell:
    """A cell from the tables of its file; paths are relative to it. Raises `PaperError`."""
    top = Fields(table, file)
    inputs = top.table("inputs", {})
    others = inputs.truth("others", None)
    home, called = (top.row(key, 6, AXES, default=None, most=MOST) for key in ("home_deg", "called_at_deg"))
    values = {
        **_numbered(inputs, "$IN[{}]", Fields.truth),
        **_numbered(top.table("analog_inputs", {}), "$ANIN[{}]", _value),
        **_numbered(top.table("tools", {}), "TOOL_DATA[{}]", _frame),
        **_numbered(top.table("bases", {}), "BASE_DATA[{}]", _frame),
        **_places(top.table("states", {}), system=True),
        **_places(top.table("variables", {}), system=False),
    }  # fmt: skip
    stubs = top.table("stubs", {})
    other_stubs, robot = stubs.truth("others", False), top.text("robot", None)
    cell = RobotCell(
        file=file, robot=robot if robot is None or not Path(robot).suffix else _beside(file, robot),
        home_deg=home, called_at_deg=called, ignore_turn=top.truth("ignore_turn", False), values=values,
        other_inputs=others, stubs={name.upper(): _stub(stubs, name) for name in stubs.unread()},
        other_stubs=other_stubs, arguments=_places(top.table("arguments", {}), system=False),
        replies=tuple(map(_reply, top.tables("reply", []))),
        submits=tuple(_submit(top, x) for x in top.take("submits", list, [])),
        unmet_wait=_seconds(top, "unmet_wait_s", None),
    )  # fmt: skip
    top.refuse_unknown()
    return cell


MOST_ARGUMENTS = 40
"""Of a stub: any number up to this."""


def with_cell(program: Program, cell: RobotCell) -> Program:
    """The program with the variables and stubs of a cell among its names; those it declares itself stay."""
    names = program.names
    for name, value in cell.values.items():
        root, rest = re.match(r"([^\[.]*)(.*)", name).groups()  # type: ignore[union-attr]
        if not root.startswith("$") and root not in CONFIG:
            dimensions = rest.partition("]")[0].count(",") + 1 if rest.startswith("[") else 0
            kind = Type("?", dimensions) if rest else _type_of(value)
            names.variables.setdefault(root, DeclaredName(root, kind, SourcePosition(cell.file, 1)))
    for name, stub in cell.stubs.items():
        returns = None if stub.returns is None else _type_of(stub.returns).name
        names.externals.setdefault(name, External(name, returns, ("?",) * MOST_ARGUMENTS))
    return program


def _type_of(value: Value) -> Type:
    for kind, name in ((bool, "BOOL"), (int, "INT"), (float, "REAL")):
        if isinstance(value, kind):
            return Type(name)
    return Type(value.type) if isinstance(value, StructValue) and value.type != "?" else UNKNOWN


def new_cell_text(file: str) -> str:
    """A commented cell file to start from; it runs as it stands."""
    return (files("lwr_dyn.krl.running") / "new_cell.txt").read_text(encoding="utf-8").replace("@@file@@", file)


def _numbered(fields: Fields, form: str, read: Callable[[Fields, str], Value]) -> dict[str, Value]:
    """The fields whose names are numbers, read one by one."""
    out = {}
    for key in fields.unread():
        if not key.isdecimal() or not 1 <= int(key) <= 8192:
            raise fields.refuse(key, "no number", "a number from 1 to 8192")
        out[form.format(int(key))] = read(fields, key)
    return out


def _places(fields: Fields, system: bool | None) -> dict[str, Value]:
    """The fields whose names are variables, of the controller or not; None takes both."""
    out = {}
    for key in fields.unread():
        name = key.replace(" ", "").upper()
        if system is not None and name.startswith("$") != system:
            raise fields.refuse(key, "no such name", '"$T1", "$ERR.NUMBER"' if system else "PART, P[3]")
        x = fields.take(key, object)
        out[name] = _value_at(fields, key, x)
        try:
            refuse_place(name, out[name])
        except ExecutionError as fault:
            raise fields.refuse(key, repr(x), fault.hint or fault.message) from None
    return out


def _value(fields: Fields, key: str) -> Value:
    return _value_at(fields, key, fields.take(key, object))


def _value_at(fields: Fields, place: str, x: Any) -> Value:
    """A number or truth value; text that begins with #, { or a quote is a constant of KRL, other text is text."""
    if isinstance(x, bool | int | float):
        return x
    if isinstance(x, str):
        if not x.lstrip().startswith(("#", "{", '"')):
            return x
        try:
            return constant_value(x)
        except ExecutionError:
            pass
    raise fields.refuse(place, repr(x), 'a number, true, false, text, or a constant of KRL: "#EX", "{X 1, Y 2}"')


def _frame(fields: Fields, key: str) -> Value:
    numbers = fields.row_at(key, fields.take(key, object), 6, FRAMES, MOST)
    return StructValue("FRAME", dict(zip(POSE_NAMES, numbers, strict=True)))


def _seconds(fields: Fields, key: str, default: float | None) -> Any:
    return fields.number(key, default, allowed=f"seconds, from 0 to {LONGEST:g}", least=0.0, most=LONGEST)


def _stub(stubs: Fields, name: str) -> Stub:
    call = statement_of(f"{name}( )")
    if not isinstance(call, Invoke) or call.call.name.upper() != name.upper():
        raise stubs.refuse(name, "no name of a routine", "a name that is no word of KRL: MSGNOTIFY")
    fields = stubs.table(name)
    returns = fields.take("returns", object, None)
    out = _numbered(fields.table("out", {}), "{}", _value)
    fields.refuse_unknown()
    value = None if returns is None else _value_at(fields, "returns", returns)
    return Stub(value, {int(key): v for key, v in out.items()})


def _reply(fields: Fields) -> Reply:
    when, after, given = fields.text("when", None), _seconds(fields, "after_s", 0.0), fields.table("set")
    fields.refuse_unknown()
    values, condition = _places(given, system=None), None if when is None else statement_of(f"WHILE {when}")
    if when is not None and not isinstance(condition, Condition):
        raise fields.refuse("when", repr(when), 'a condition of KRL: "$OUT[5]", "PART == 3"')
    return Reply(condition.value if isinstance(condition, Condition) else None, after, values)


def _submit(top: Fields, path: Any) -> str:
    if not isinstance(path, str) or not path.lower().endswith(".sub"):
        raise top.refuse("submits", repr(path), "paths that end in .sub")
    return _beside(top.file, path)


def _beside(file: str, path: str) -> str:
    return str(Path(file).parent / path)
