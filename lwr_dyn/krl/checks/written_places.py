"""What a program may not write: inputs, measured values, constants, signals on inputs; texts without their brackets."""

from __future__ import annotations

from lwr_dyn.krl.diagnostics import Severity
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.names.known_names import Type
from lwr_dyn.krl.project.program import Scope
from lwr_dyn.krl.project.project import DeclaredName

OUTPUT_OF = {"$IN": "$OUT", "$ANIN": "$ANOUT"}
"""What may be written instead of an input."""


def check_written(scope: Scope, target: e.Expression) -> None:
    """Report a place that a program can only read; a `.dat` gives it its first value all the same."""
    if scope.routine is None or not isinstance(target, e.Name | e.Index | e.Component):
        return
    root = e.root_name(target)
    declared = _declared(scope, root)
    # machine data declare such variables as signals on outputs: SIGNAL $PERI_RDY $OUT[1012]
    behind = root if declared is None or root in scope.known.read_only else _behind(declared)
    if declared is not None and declared.const:
        message = f"{declared.name} is CONST, a program cannot write it"
        scope.report(target.column, "read-only", message, "declare it without CONST, or write another variable")
    elif behind in scope.known.read_only:
        is_signal = behind != root
        what = f"{declared.name}, a SIGNAL on {behind}" if declared is not None and is_signal else behind
        hint = _instead(target, behind, is_signal)
        # a public backup writes such signals, and it is not known whether it ever ran
        severity: Severity = "warning" if is_signal else "error"
        scope.report(target.column, "read-only", f"a program cannot write {what}", hint, severity)


def _declared(scope: Scope, root: str) -> DeclaredName | None:
    return next((names.variables[root] for names in scope.tables if root in names.variables), None)


def _behind(declared: DeclaredName) -> str:
    """The system variable of a SIGNAL; of another variable its own name."""
    signal = declared.signal
    is_on = signal is not None and not isinstance(signal.first, e.Bool)
    return e.root_name(signal.first) if is_on else declared.name.upper()  # type: ignore[union-attr,arg-type]


def _instead(target: e.Reference, behind: str, is_signal: bool) -> str:
    output = OUTPUT_OF.get(behind)
    if output is None:
        return "the controller sets it, read it only"
    if is_signal:
        return f"SIGNAL ... {output}[...] where an output is meant"
    text = expression_text(target)
    return f"{output}{text[len(behind) :]} where an output is meant"


def check_text(scope: Scope, target: e.Expression, kind: Type, value: e.Expression) -> None:
    """Report a text that is assigned to the name of an array of CHAR without its brackets."""
    is_text = isinstance(value, e.Text) and len(value.value) != 1
    if is_text and isinstance(target, e.Name | e.Component) and kind.name == "CHAR" and kind.dimensions == 1:
        name = expression_text(target)
        message = f"{name} is an array of CHAR, a text goes to all of it"
        scope.report(target.column, "text-brackets", message, f"{name}[] = {expression_text(value)}")
