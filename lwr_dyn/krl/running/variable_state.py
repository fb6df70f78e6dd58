"""VARSTATE("name"): whether a variable, an element or a component is declared, and whether it has a value."""

from collections.abc import Sequence

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.lexer import LineError
from lwr_dyn.krl.language.line_parser import parse_line
from lwr_dyn.krl.language.statements import Assign
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment, reference_to, value_of
from lwr_dyn.krl.running.values import EnumValue, Value, text_of


def variable_state(env: Environment, c: ControllerState, arguments: Sequence[e.Expression]) -> Value:
    """#INITIALIZED, #DECLARED or #UNDEFINED; raises `ExecutionError` for an argument that is no text."""
    if not arguments:
        raise ExecutionError("arguments", "VARSTATE without a name", 'VARSTATE("name")')
    return EnumValue(_state(env, text_of(value_of(env, arguments[0]))))


def _state(env: Environment, name: str) -> str:
    try:
        statement, _ = parse_line(f"{name} = 0")
        if not isinstance(statement, Assign):
            return "UNDEFINED"
        return "DECLARED" if reference_to(env, statement.target).read() is None else "INITIALIZED"
    except (LineError, ExecutionError):
        return "UNDEFINED"
