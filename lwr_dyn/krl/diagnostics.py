"""Diagnostics: what is wrong or doubtful in a program, where, and what helps; and the log of those of a run."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Annotated, Any, Literal, NoReturn, TypeAlias, TypedDict

Severity = Literal["error", "warning", "note"]
SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
MOST = 100
"""Diagnostics of one code and severity in one file that are shown."""
Report: TypeAlias = Callable[[Severity, str, str, str], None]
"""Reports a diagnostic: severity, code, message, hint."""


@dataclass(frozen=True, slots=True)
class SourcePosition:
    """A position in a file: line and column from 1."""

    file: str
    line: int
    column: int = 1

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One message about one position; `code` is stable and can be looked up, `hint` is a way to mend it.

    An error stops the program or the robot; a warning runs, but perhaps not as meant; a note says what was not checked.
    """

    position: SourcePosition
    severity: Severity
    code: str
    message: str
    hint: str = ""

    def __str__(self) -> str:
        hint = f" ({self.hint})" if self.hint else ""
        return f"{self.position}: {self.severity} {self.code}: {self.message}{hint}"

    def to_json(self) -> dict[str, Any]:
        """As one JSON object."""
        rest = {key: getattr(self, key) for key in ("severity", "code", "message", "hint")}
        return {**asdict(self.position), **rest}


class DiagnosticRecord(TypedDict):
    """`Diagnostic.to_json`."""

    file: str
    line: int
    column: int
    severity: Annotated[Severity, "error, warning or note."]
    code: Annotated[str, "Stable; it can be looked up."]
    message: str
    hint: Annotated[str, "A way to mend it; empty where none is known."]


def sorted_diagnostics(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Each diagnostic once, by file, line and column; of one kind in a file the first `MOST` and a note of the rest."""
    ordered = sorted(
        dict.fromkeys(diagnostics), key=lambda d: (d.position.file, d.position.line, d.position.column, d.code)
    )
    shown: list[Diagnostic] = []
    counts: dict[tuple[str, Severity, str], int] = {}
    cut: dict[tuple[str, Severity, str], int] = {}
    for d in ordered:
        kind = (d.position.file, d.severity, d.code)
        counts[kind] = counts.get(kind, 0) + 1
        if counts[kind] == MOST + 1:
            cut[kind] = len(shown)
        if counts[kind] <= MOST + 1:
            shown.append(d)
    for kind, at in cut.items():
        _, severity, code = kind
        message = f"from here {counts[kind] - MOST} more of severity {severity} and code {code}, not shown"
        shown[at] = Diagnostic(shown[at].position, "note", "more", message, f"{MOST} of them are shown")
    return tuple(shown)


def summary(diagnostics: Sequence[Diagnostic]) -> str:
    """The number of diagnostics of each severity.

    >>> summary([])
    'no findings'
    """
    counts = {severity: sum(d.severity == severity for d in diagnostics) for severity in SEVERITIES}
    parts = [f"{n} {severity}{'s' if n > 1 else ''}" for severity, n in counts.items() if n]
    return ", ".join(parts) or "no findings"


def has_no_error(diagnostics: Sequence[Diagnostic]) -> bool:
    """Whether none of them is an error."""
    return all(d.severity != "error" for d in diagnostics)


class ExecutionError(Exception):
    """A statement that cannot be executed: code, message, hint, and the variable without a value, if that is why.

    Used inside this package only.
    """

    def __init__(self, code: str, message: str, hint: str = "", variable: str = "") -> None:
        super().__init__(message)
        self.code, self.message, self.hint, self.variable = code, message, hint, variable


class RunEndedError(Exception):
    """Ends a run early: with the diagnostic of its fault or bound, or None. Used inside this package only."""

    def __init__(self, diagnostic: Diagnostic | None) -> None:
        super().__init__()
        self.diagnostic = diagnostic


class ResumedError(Exception):
    """RESUME has ended an interrupt and the calls below the routine that declared it. Used inside this package only."""


@dataclass(slots=True, eq=False)
class DiagnosticLog:
    """The diagnostics of a run; an error ends the run unless `tolerant`."""

    position: SourcePosition
    """Of the statement that is executed now."""
    tolerant: bool
    diagnostics: list[Diagnostic] = field(default_factory=list)
    unassigned: set[str] = field(default_factory=set)
    """Variables, in capitals, whose assignment had a fault: that they have no value is not reported again."""

    def report(self, severity: Severity, code: str, message: str, hint: str) -> None:
        """Add a diagnostic at the current statement; raises `RunEndedError`."""
        diagnostic = Diagnostic(self.position, severity, code, message, hint)
        if severity == "error" and not self.tolerant:
            raise RunEndedError(diagnostic)
        self.diagnostics.append(diagnostic)

    def end_run(self, severity: Severity, code: str, message: str, hint: str) -> NoReturn:
        """End the run at the current statement with a diagnostic."""
        raise RunEndedError(Diagnostic(self.position, severity, code, message, hint))

    def report_fault(self, fault: ExecutionError) -> None:
        """Report why the current statement cannot be executed; raises `RunEndedError` unless the run can go on."""
        # a check ends quietly at a value or a function that only the real controller has
        if self.tolerant and fault.code in ("unknown-input", "not-modelled"):
            self.end_run("note", fault.code, f"not looked at from here: {fault.message}", fault.hint)
        # the static checks report an undeclared name; a value that is missing after a fault is no other fault
        if self.tolerant and (fault.code == "undeclared" or fault.variable in self.unassigned):
            return
        self.report("error", fault.code, fault.message, fault.hint)
        if fault.code in ("recursion", "waits-forever"):
            raise RunEndedError(None)
