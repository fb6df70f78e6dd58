"""Names that can be seen in a routine: what they are, and what is said where one is not known."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.diagnosis import Diagnosis, Severity
from lwr_dyn.krl.known import CONFIG, FUNCTIONS, SYSTEM
from lwr_dyn.krl.program import Names, Program, Variable, declare, known_structure
from lwr_dyn.krl.source import SourceFile
from lwr_dyn.krl.structure import Routine
from lwr_dyn.krl.types import ENUMS, LARGEST, UNKNOWN, Type


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


def scope_of(program: Program, routine: Routine, found: list[Diagnosis]) -> Scope:
    """The names a routine sees: its parameters and declarations, wherever in its body they stand."""
    own = Names()
    for p in routine.head.parameters:
        own.variables[p.name.upper()] = Variable(
            p.name, Type("?", p.dimensions), routine.file.place(routine.first - 1, p.column)
        )
    for i, x in routine.lines():
        declare(own, x, routine.file, i, found)
    return Scope(program, own, routine.file, found)


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
