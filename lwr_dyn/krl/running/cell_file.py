"""Reads a cell file (TOML), and gives a commented one to start from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from lwr_dyn.arms.papers.fields import Fields, parse_toml
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.foundation.files import read_text
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.lexer import LineError
from lwr_dyn.krl.language.line_parser import parse_line
from lwr_dyn.krl.language.statements import Condition, Invoke
from lwr_dyn.krl.running.cell import Reply, RobotCell, Stub
from lwr_dyn.krl.running.constants import constant_value, refuse_place
from lwr_dyn.krl.running.values import POSE_NAMES, StructValue, Value

T = TypeVar("T")
AXES = "the six axes in deg"
LONGEST = 1e6
"""[s] The latest time of an event."""


def read_cell(path: str | Path) -> RobotCell:
    """Read a cell file; raises `FileAccessError`, or `PaperError` for a field that is missing, unknown or wrong."""
    text = read_text(path, "a cell file (TOML): lwr-dyn new cell FILE writes one")
    return cell_of(parse_toml(text, str(path)), str(path))


def cell_of(table: Mapping[str, Any], file: str = "cell") -> RobotCell:
    """A cell from the tables of its file; paths are relative to it. Raises `PaperError`."""
    top = Fields(table, file, "")
    inputs = _table(top, "inputs")
    others = inputs.pop("others", None)
    home, called = (top.take(name, list, default=None) for name in ("home_deg", "called_at_deg"))
    values = {
        **_numbered(inputs, "$IN[{}]", file, "inputs", lambda x, name: _truth(x, file, name)),
        **_numbered(_table(top, "analog_inputs"), "$ANIN[{}]", file, "analog_inputs", lambda x, n: _value(x, file, n)),
        **_numbered(_table(top, "tools"), "TOOL_DATA[{}]", file, "tools", lambda x, name: _frame(x, file, name)),
        **_numbered(_table(top, "bases"), "BASE_DATA[{}]", file, "bases", lambda x, name: _frame(x, file, name)),
        **_places(_table(top, "states"), file, "states", system=True),
        **_places(_table(top, "variables"), file, "variables", system=False),
    }  # fmt: skip
    stubs = _table(top, "stubs")
    other_stubs = _truth(stubs.pop("others", False), file, "stubs.others")
    cell = RobotCell(
        file=file, robot=_robot(top.take("robot", str, default=None), file),
        home_deg=None if home is None else _numbers(home, AXES, file, "home_deg"),
        called_at_deg=None if called is None else _numbers(called, AXES, file, "called_at_deg"),
        ignore_turn=_truth(top.take("ignore_turn", object, default=False), file, "ignore_turn"),
        values=values, other_inputs=None if others is None else _truth(others, file, "inputs.others"),
        stubs={name.upper(): _stub(x, file, f"stubs.{name}") for name, x in stubs.items()},
        other_stubs=other_stubs,
        arguments=_places(_table(top, "arguments"), file, "arguments", system=False),
        replies=tuple(_reply(x, file, f"reply[{i}]") for i, x in enumerate(top.take("reply", list, default=[]))),
        submits=tuple(_path(x, file, "submits") for x in top.take("submits", list, default=[])),
        unmet_wait=_seconds(top.take("unmet_wait_s", object, default=None), file, "unmet_wait_s"),
    )  # fmt: skip
    top.refuse_unknown()
    return cell


def new_cell_text(file: str) -> str:
    """A commented cell file to start from; it runs as it stands."""
    return (files("lwr_dyn.krl.running") / "new_cell.txt").read_text(encoding="utf-8").replace("@@file@@", file)


def _table(top: Fields, key: str) -> dict[str, Any]:
    return dict(top.take(key, dict, default={}))


def _numbered(table: Mapping[str, Any], form: str, file: str, path: str, read: Callable[[Any, str], T]) -> dict[str, T]:
    out = {}
    for key, x in table.items():
        if not key.isdecimal() or not 1 <= int(key) <= 8192:
            raise PaperError(file, f"{path}.{key}", "no number", "a number from 1 to 8192")
        out[form.format(int(key))] = read(x, f"{path}.{key}")
    return out


def _places(table: Mapping[str, Any], file: str, path: str, system: bool) -> dict[str, Value]:
    out = {}
    for key, x in table.items():
        name = key.replace(" ", "").upper()
        if name.startswith("$") != system:
            raise PaperError(file, f"{path}.{key}", "no such name", '"$T1", "$ERR.NUMBER"' if system else "PART, P[3]")
        out[name] = _value(x, file, f"{path}.{key}")
        try:
            refuse_place(name, out[name])
        except ExecutionError as fault:
            raise PaperError(file, f"{path}.{key}", repr(x), fault.hint or fault.message) from None
    return out


def _value(x: Any, file: str, name: str) -> Value:
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
    raise PaperError(file, name, repr(x), 'a number, true, false, text, or a constant of KRL: "#EX", "{X 1, Y 2}"')


def _truth(x: Any, file: str, name: str) -> bool:
    if not isinstance(x, bool):
        raise PaperError(file, name, repr(x), "true or false")
    return x


def _frame(x: Any, file: str, name: str) -> Value:
    numbers = _numbers(x, "X, Y, Z, A, B, C in mm and deg", file, name)
    return StructValue("FRAME", dict(zip(POSE_NAMES, numbers, strict=True)))


def _numbers(x: Any, wanted: str, file: str, name: str) -> tuple[float, ...]:
    if not (isinstance(x, list) and len(x) == 6 and all(_is_number(v) for v in x)):
        raise PaperError(file, name, repr(x), f"a list of numbers: {wanted}")
    return tuple(float(v) for v in x)


def _is_number(x: object) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < 1e9


def _seconds(x: Any, file: str, name: str) -> float | None:
    if x is None:
        return None
    if not _is_number(x) or not 0.0 <= x <= LONGEST:
        raise PaperError(file, name, repr(x), f"seconds, from 0 to {LONGEST:g}")
    return float(x)


def _stub(x: Any, file: str, name: str) -> Stub:
    if not _is_called(name.removeprefix("stubs.")):
        raise PaperError(file, name, "no name of a routine", "a name that is no word of KRL: MSGNOTIFY")
    fields = Fields(x, file, name)
    returns = fields.take("returns", object, default=None)
    out = _numbered(_table(fields, "out"), "{}", file, f"{name}.out", lambda v, of: _value(v, file, of))
    fields.refuse_unknown()
    value = None if returns is None else _value(returns, file, f"{name}.returns")
    return Stub(value, {int(key): v for key, v in out.items()})


def _is_called(name: str) -> bool:
    """Whether `name( )` is the call of a routine."""
    try:
        statement, _ = parse_line(f"{name}( )")
        return isinstance(statement, Invoke) and statement.call.name.upper() == name.upper()
    except LineError:
        return False


def _reply(x: Any, file: str, name: str) -> Reply:
    fields = Fields(x, file, name)
    when = fields.take("when", str, default=None)
    after = _seconds(fields.take("after_s", object, default=0.0), file, f"{name}.after_s")
    given = fields.take("set", dict)
    fields.refuse_unknown()
    values: dict[str, Value] = {}
    for key, v in given.items():
        values |= _places({key: v}, file, f"{name}.set", key.strip().startswith("$"))
    return Reply(None if when is None else _condition(when, file, f"{name}.when"), after or 0.0, values)


def _condition(text: str, file: str, name: str) -> e.Expression:
    try:
        statement, _ = parse_line(f"WHILE {text}")
    except LineError:
        statement = None
    if not isinstance(statement, Condition):
        raise PaperError(file, name, repr(text), 'a condition of KRL: "$OUT[5]", "PART == 3"')
    return statement.value


def _robot(x: str | None, file: str) -> str | None:
    """A robot's name, or the path of its file, relative to the cell file."""
    return x if x is None or not Path(x).suffix else str(Path(file).parent / x)


def _path(x: Any, file: str, name: str) -> str:
    if not isinstance(x, str) or not x.lower().endswith(".sub"):
        raise PaperError(file, name, repr(x), "paths that end in .sub")
    return str(Path(file).parent / x)
