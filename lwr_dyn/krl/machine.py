"""The interpreter: carries out a program's lines one by one on a robot's model, bounded in steps, time and depth."""

from __future__ import annotations

from collections.abc import Mapping

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.acts import assign, carry_out
from lwr_dyn.krl.built_in import function_value
from lwr_dyn.krl.controller import Controller
from lwr_dyn.krl.diagnosis import Diagnosis, Place
from lwr_dyn.krl.evaluate import value_of
from lwr_dyn.krl.findings import Findings, StoppedError
from lwr_dyn.krl.flow import Call
from lwr_dyn.krl.motions import Motions
from lwr_dyn.krl.program import Program, Variable, known_structure
from lwr_dyn.krl.scope import scope_of
from lwr_dyn.krl.settings import Settings
from lwr_dyn.krl.structure import Routine
from lwr_dyn.krl.types import UNKNOWN, Type
from lwr_dyn.krl.values import HaltError, Slot, Value, converted
from lwr_dyn.krl.variables import argument, fresh
from lwr_dyn.model.arm import Arm

DEEPEST = 40
"""Calls inside one another: a recursion ends here."""


class Machine:
    """One run of one program. With `tolerant` a faulty statement is left out and the run goes on."""

    def __init__(
        self, program: Program, arm: Arm, settings: Settings, given: Mapping[str, Value], tolerant: bool = False
    ) -> None:
        self.program, self.settings = program, settings
        self.findings = Findings(Place(program.source.name, 1), tolerant)
        self.controller = Controller(arm, settings, given)
        self.motions = Motions(self.controller, self.findings.say)
        self.calls: list[Call] = []
        self.steps = 0
        self.globals: dict[str, Slot] = {}
        self._types: dict[int, Mapping[str, Variable]] = {}

    # --- what evaluate.Environment asks for
    def slot(self, name: str) -> Slot:
        """A variable: the routine's own, then the `.dat`'s, then the controller's."""
        key = name.upper()
        for slots in ([self.calls[-1].slots] if self.calls else []) + [self.globals]:
            if key in slots:
                return slots[key]
        found = self.controller.slot(key)
        if found is None:
            raise HaltError("undeclared", f"{name} is not declared", "declare it in the .dat or with DECL")
        return found

    def element(self, name: str, index: tuple[int, ...]) -> Value | None:
        """An input's element; reading one stops the advance run, so that no blend goes over it."""
        if name.startswith("$"):
            found = self.controller.element(name, index)
            if found is not None and name.upper() in ("$IN", "$OUT", "$ANIN", "$ANOUT"):
                self.motions.stop_advance()
            return found
        return None

    def component_type(self, struct: str, name: str) -> Type:
        """The type of a component; unknown where the structure is."""
        known = known_structure(self.program.names, struct)
        return UNKNOWN if known is None else known.get(name, UNKNOWN)

    def call(self, x: e.Call) -> Value:
        """What a function returns: a built-in one, or one of the program, carried out to its end."""
        routine = self.program.routine(x.name)
        if routine is None:
            value = function_value(self, x)
            if value is None:
                raise HaltError("not-modelled", f"the function {x.name} is not modelled", "define it in the program")
            return value
        depth = len(self.calls)
        self.enter(routine, x)
        result: list[Value] = []
        while len(self.calls) > depth:
            self._step(result)
        if not result:
            raise HaltError("no-value", f"{x.name} ended without RETURN", "RETURN a value on every way")
        return result[-1]

    # --- the run
    def run(self) -> tuple[Diagnosis, ...]:
        """Carry the main routine out to its end, or to the fault or bound that ends it."""
        try:
            self._declare_globals()
            if not self.program.routines:
                return tuple(self.findings.found)
            self.enter(self.program.routines[0], None)
            while self.calls:
                self._step(None)
        except StoppedError as stop:
            if stop.diagnosis is not None:
                self.findings.found.append(stop.diagnosis)
        except RecursionError:
            deep = ("recursion", "functions call one another without end", "use a loop")
            self.findings.found.append(Diagnosis(self.findings.place, "error", *deep))
        return tuple(self.findings.found)

    def _step(self, result: list[Value] | None) -> None:
        now = self.calls[-1]
        if now.at >= now.routine.last:
            self.calls.pop()
            return
        at = now.at
        now.at += 1
        line = now.routine.file.lines[at]
        if line.statement is None:
            return
        self.findings.place = now.routine.file.place(at, getattr(line.statement, "column", 1))
        self._count()
        try:
            if isinstance(line.statement, s.Return):
                self._return(line.statement, result)
            else:
                carry_out(self, line.statement, now, at)
        except HaltError as fault:
            self.findings.halted(fault)

    def _return(self, x: s.Return, result: list[Value] | None) -> None:
        value = None if x.value is None else value_of(self, x.value)
        kind = self.calls[-1].routine.head.returns
        if value is not None and kind is not None:
            value = converted(value, Type(kind.upper()))
        self.calls.pop()
        if result is not None and value is not None:
            result.append(value)

    def _count(self) -> None:
        self.steps += 1
        bounds = (
            (self.steps > self.settings.steps, f"{self.settings.steps} statements"),
            (self.motions.timeline.duration > self.settings.seconds, f"{self.settings.seconds:g} s of simulated time"),
            (self.motions.count >= self.settings.motions, f"{self.settings.motions} motions"),
        )
        for reached, what in bounds:
            if reached:
                self.findings.stop(
                    "note", "bound", f"stopped here after {what}", "an endless loop is cut; the bound is an option"
                )

    def enter(self, routine: Routine, x: e.Call | None) -> None:
        """Begin a routine with the arguments of a call; OUT parameters are the caller's own variables."""
        if len(self.calls) >= DEEPEST:
            deep = f"{DEEPEST} calls inside one another, at {routine.head.name}"
            self.findings.stop("error", "recursion", deep, "use a loop")
        slots: dict[str, Slot] = {}
        kinds = self._variables(routine)
        arguments = () if x is None else x.arguments
        for i, p in enumerate(routine.head.parameters):
            kind = kinds[p.name.upper()].type if p.name.upper() in kinds else UNKNOWN
            slots[p.name.upper()] = argument(self, arguments[i] if i < len(arguments) else None, p, kind)
        self.calls.append(Call(routine, routine.first, slots))
        for name, variable in kinds.items():
            if name not in slots:
                slots[name] = self._fresh_or_empty(variable)

    def _variables(self, routine: Routine) -> Mapping[str, Variable]:
        key = id(routine)
        if key not in self._types:
            self._types[key] = scope_of(self.program, routine, []).own.variables
        return self._types[key]

    def _fresh_or_empty(self, variable: Variable) -> Slot:
        """The variable as it is declared; without a value where the declaration has a fault, which is said."""
        try:
            return fresh(self, variable)
        except HaltError as fault:
            self.findings.place = variable.place
            self.findings.halted(fault)
            return Slot(variable.type)

    def _declare_globals(self) -> None:
        data = self.program.data
        for name, variable in self.program.names.variables.items():
            self.globals[name] = self._fresh_or_empty(variable)
        files = [*self.program.lent, *([data] if data is not None else [])]
        for file in files:
            for i, x in self.program.structures[file.name].data if file.is_data else ():
                if isinstance(x, s.Assign):
                    self.findings.place = file.place(i, x.column)
                    try:
                        assign(self, x)
                    except HaltError as fault:
                        self.findings.halted(fault)
