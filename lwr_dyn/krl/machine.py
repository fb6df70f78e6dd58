"""The interpreter: carries out a program's lines one by one on a robot's model, bounded in steps, time and depth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from lwr_dyn.arm import Arm
from lwr_dyn.krl import expressions as e
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.controller import Controller
from lwr_dyn.krl.diagnosis import Diagnosis, Place, Severity
from lwr_dyn.krl.evaluate import (
    aggregate_value,
    function_value,
    number_of,
    target_of,
    truth_of,
    value_of,
)
from lwr_dyn.krl.motions import Motions
from lwr_dyn.krl.program import Program, Variable, known_structure
from lwr_dyn.krl.settings import Settings
from lwr_dyn.krl.statics import scope_of
from lwr_dyn.krl.structure import Block, Routine
from lwr_dyn.krl.types import UNKNOWN, Type
from lwr_dyn.krl.typing import shape_of
from lwr_dyn.krl.values import HaltError, Many, Slot, Struct, Value, converted, copied

DEEPEST = 40
"""Calls inside one another: a recursion ends here."""
OPEN_ARRAY = 100_000
"""Elements of one array."""


@dataclass(slots=True, eq=False)
class Call:
    """A routine that is being carried out: its next line and its variables."""

    routine: Routine
    at: int
    slots: dict[str, Slot]
    loops: dict[int, tuple[int, int]] = field(default_factory=dict)
    """FOR line -> last value, step."""


class StoppedError(Exception):
    """A bound is reached, or the program ended by itself: why."""

    def __init__(self, diagnosis: Diagnosis | None) -> None:
        super().__init__()
        self.diagnosis = diagnosis


class Machine:
    """One run of one program. With `tolerant` a faulty statement is left out and the run goes on."""

    def __init__(
        self, program: Program, arm: Arm, settings: Settings, given: Mapping[str, Value], tolerant: bool = False
    ) -> None:
        self.program, self.settings, self.tolerant = program, settings, tolerant
        self.controller = Controller(arm, settings, given)
        self.motions = Motions(self.controller, self.say)
        self.found: list[Diagnosis] = []
        self.calls: list[Call] = []
        self.steps = 0
        self.place = Place(program.source.name, 1)
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
        self._enter(routine, x)
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
                return tuple(self.found)
            self._enter(self.program.routines[0], None)
            while self.calls:
                self._step(None)
        except StoppedError as stop:
            if stop.diagnosis is not None:
                self.found.append(stop.diagnosis)
        except RecursionError:
            self._report("error", "recursion", "functions call one another without end", "use a loop")
        return tuple(self.found)

    def say(self, severity: str, code: str, message: str, hint: str) -> None:
        """A diagnosis at the statement that is being carried out."""
        self._report(severity, code, message, hint)  # type: ignore[arg-type]

    def _report(self, severity: Severity, code: str, message: str, hint: str) -> None:
        found = Diagnosis(self.place, severity, code, message, hint)
        if severity == "error" and not self.tolerant:
            raise StoppedError(found)
        self.found.append(found)

    def _stop(self, severity: Severity, code: str, message: str, hint: str) -> None:
        raise StoppedError(Diagnosis(self.place, severity, code, message, hint))

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
        self.place = now.routine.file.place(at, getattr(line.statement, "column", 1))
        self._count()
        try:
            if isinstance(line.statement, s.Return):
                self._return(line.statement, result)
            else:
                self._carry_out(line.statement, now, at)
        except HaltError as fault:
            self._halted(fault)

    def _count(self) -> None:
        self.steps += 1
        bounds = (
            (self.steps > self.settings.steps, f"{self.settings.steps} statements"),
            (self.motions.timeline.duration > self.settings.seconds, f"{self.settings.seconds:g} s of simulated time"),
            (self.motions.count >= self.settings.motions, f"{self.settings.motions} motions"),
        )
        for reached, what in bounds:
            if reached:
                self._stop(
                    "note", "bound", f"stopped here after {what}", "an endless loop is cut; the bound is an option"
                )

    def _halted(self, fault: HaltError) -> None:
        # while checking, what a value is missing for has been said, or ends the run there
        if self.tolerant and fault.code in ("unknown-input", "not-modelled"):
            self._stop("note", fault.code, f"not looked at from here: {fault.message}", fault.hint)
        if self.tolerant and fault.code == "undeclared":
            return
        self._report("error", fault.code, fault.message, fault.hint)
        if fault.code in ("recursion", "waits-forever"):
            raise StoppedError(None)

    def _enter(self, routine: Routine, x: e.Call | None) -> None:
        if len(self.calls) >= DEEPEST:
            diagnosis = Diagnosis(
                self.place, "error", "recursion", f"{DEEPEST} calls inside one another, at {routine.head.name}",
                "use a loop",
            )  # fmt: skip
            raise StoppedError(diagnosis)
        slots: dict[str, Slot] = {}
        kinds = self._variables(routine)
        arguments = () if x is None else x.arguments
        for i, p in enumerate(routine.head.parameters):
            argument = arguments[i] if i < len(arguments) else None
            kind = kinds[p.name.upper()].type if p.name.upper() in kinds else UNKNOWN
            slots[p.name.upper()] = self._argument(argument, p, kind)
        self.calls.append(Call(routine, routine.first, slots))
        for name, variable in kinds.items():
            if name not in slots:
                slots[name] = self._fresh_or_empty(variable)

    def _argument(self, x: e.Expression | None, p: s.Parameter, kind: Type) -> Slot:
        """By value for IN; by reference for OUT: the slot itself where the argument is a plain variable."""
        if x is None:
            return Slot(kind)
        if p.mode != "IN" and isinstance(x, e.Name):
            return self.slot(x.name)
        if p.mode != "IN" and isinstance(x, e.Index) and not x.indices and isinstance(x.of, e.Name):
            return self.slot(x.of.name)
        return Slot(kind, converted(value_of(self, x), kind))

    def _variables(self, routine: Routine) -> Mapping[str, Variable]:
        key = id(routine)
        if key not in self._types:
            self._types[key] = scope_of(self.program, routine, []).own.variables
        return self._types[key]

    def _fresh_or_empty(self, variable: Variable) -> Slot:
        """The variable as it is declared; without a value where the declaration has a fault, which is said."""
        try:
            return self._fresh(variable)
        except HaltError as fault:
            self.place = variable.place
            self._halted(fault)
            return Slot(variable.type)

    def _fresh(self, variable: Variable) -> Slot:
        d, kind = variable.declarator, variable.type
        if d is None:
            return Slot(kind)
        if d.sizes is not None:
            return Slot(kind, self._array(d, kind))
        if kind.name == "?" and isinstance(d.value, e.Aggregate):
            kind = shape_of(d.value)
        slot = Slot(kind)
        if d.value is not None:
            slot.value = self._initial(d.value, kind)
        return slot

    def _array(self, d: s.Declarator, kind: Type) -> Value | None:
        sizes = tuple(int(number_of(self, x, "a size")) for x in d.sizes or ())
        if any(not 1 <= n <= OPEN_ARRAY for n in sizes):
            raise HaltError(
                "index-range", f"{d.name} has the size {', '.join(map(str, sizes))}", f"from 1 to {OPEN_ARRAY}"
            )
        if isinstance(d.value, e.Text):
            return d.value.value
        return Many(kind.name, sizes)

    def _initial(self, x: e.Expression, kind: Type) -> Value:
        if isinstance(x, e.Aggregate):
            return aggregate_value(self, x, kind.name)
        return converted(value_of(self, x), kind)

    def _declare_globals(self) -> None:
        data = self.program.data
        for name, variable in self.program.names.variables.items():
            self.globals[name] = self._fresh_or_empty(variable)
        files = [*self.program.lent, *([data] if data is not None else [])]
        for file in files:
            for i, x in self.program.structures[file.name].data if file.is_data else ():
                if isinstance(x, s.Assign):
                    self.place = file.place(i, x.column)
                    try:
                        self._assign(x)
                    except HaltError as fault:
                        self._halted(fault)

    # --- statements
    def _carry_out(self, x: s.Statement, now: Call, at: int) -> None:
        act = _ACTS.get(type(x))
        if act is not None:
            act(self, x, now, at)
        if not (isinstance(x, s.Plain) and x.keyword == "CONTINUE"):
            self.motions.kept = False

    def _assign(self, x: s.Assign) -> None:
        target = target_of(self, x.target)
        value = (
            aggregate_value(self, x.value, target.type.name)
            if isinstance(x.value, e.Aggregate)
            else value_of(self, x.value)
        )
        name = _root(x.target)
        before = target.read()
        if isinstance(x.value, e.Aggregate) and isinstance(before, Struct) and isinstance(value, Struct):
            # an aggregate sets the components it names, the others stay
            value = Struct(value.type, {**{k: copied(v) for k, v in before.parts.items()}, **value.parts})
        target.write(value)
        self.controller.written(name)
        if name.upper() in ("$OUT", "$ANOUT"):
            self.motions.stop_advance()

    def _invoke(self, x: s.Invoke) -> None:
        name = x.call.name.upper()
        routine = self.program.routine(name)
        if routine is not None:
            self._enter(routine, x.call)
        elif name == "BAS":
            self._bas(x.call)
        elif function_value(self, x.call) is None:
            self.motions.note_unmodelled(name)

    def _bas(self, x: e.Call) -> None:
        arguments = [a for a in x.arguments if a is not None]
        if not arguments or not isinstance(arguments[0], e.EnumConstant):
            raise HaltError("type", "BAS without a command", "BAS(#INITMOV, 0)")
        value = number_of(self, arguments[1], "the value of BAS") if len(arguments) > 1 else 0.0
        self.controller.bas(arguments[0].name.upper(), value)

    def _move(self, x: s.Move) -> None:
        for setting in x.settings:
            self._assign(setting)
        self.motions.move(self, x, self.place)

    def _wait(self, x: s.Wait) -> None:
        if x.kind == "SEC":
            self.motions.wait(number_of(self, x.value, "WAIT SEC"), self.place)
        elif not truth_of(self, x.value, "WAIT FOR"):
            raise HaltError(
                "waits-forever", "the condition is FALSE and nothing here can change it", "set its input: --set"
            )
        else:
            self.motions.stop_advance()

    def _plain(self, x: s.Plain, now: Call, at: int) -> None:
        block = now.routine.blocks.get(at)
        if x.keyword == "HALT":
            self.motions.stop_advance()
        elif x.keyword == "CONTINUE":
            self.motions.keep_advance()
        elif block is not None:
            self._jump(x.keyword, block, now)

    def _jump(self, keyword: str, block: Block, now: Call) -> None:
        if keyword in ("ELSE", "CASE", "DEFAULT", "EXIT"):
            now.at = block.last + 1
            return
        # an end line that also closes blocks whose own end is missing ends them all
        back = {"ENDLOOP": block.first + 1, "ENDWHILE": block.first}
        if keyword in back:
            now.at = back[keyword]
        elif keyword == "ENDFOR":
            self._next(block, now)

    def _condition(self, x: s.Condition, now: Call, at: int) -> None:
        block = now.routine.blocks.get(at)
        if block is None:
            return
        if x.keyword == "SWITCH":
            self._switch(x, block, now)
        elif x.keyword == "UNTIL":
            if not truth_of(self, x.value, "UNTIL"):
                now.at = block.first + 1
        elif not truth_of(self, x.value, x.keyword):
            now.at = (block.parts[0] if block.parts else block.last) + 1

    def _switch(self, x: s.Condition, block: Block, now: Call) -> None:
        value = value_of(self, x.value)
        for at in block.parts:
            case = now.routine.file.lines[at].statement
            if not isinstance(case, s.Case) or any(value_of(self, v) == value for v in case.values):
                now.at = at + 1
                return
        now.at = block.last + 1

    def _for(self, x: s.For, now: Call, at: int) -> None:
        first, last = (round(number_of(self, v, "FOR")) for v in (x.first, x.last))
        step = 1 if x.step is None else round(number_of(self, x.step, "STEP"))
        if step == 0:
            raise HaltError("endless", "STEP 0 never ends", "a step that is not 0")
        target_of(self, x.variable).write(first)
        now.loops[at] = (last, step)
        if (first - last) * step > 0:
            now.at = now.routine.blocks[at].last + 1

    def _next(self, block: Block, now: Call) -> None:
        x = now.routine.file.lines[block.first].statement
        if not isinstance(x, s.For) or block.first not in now.loops:
            return
        last, step = now.loops[block.first]
        target = target_of(self, x.variable)
        value = target.read()
        if not isinstance(value, int):
            raise HaltError("no-value", "the variable of FOR has lost its value", "do not assign it in the loop")
        if (value + step - last) * step <= 0:
            target.write(value + step)
            now.at = block.first + 1

    def _goto(self, x: s.Jump, now: Call) -> None:
        if x.label.upper() not in now.routine.labels:
            raise HaltError("undeclared", f"there is no label {x.label}", "")
        now.at = now.routine.labels[x.label.upper()]

    def _return(self, x: s.Return, result: list[Value] | None) -> None:
        value = None if x.value is None else value_of(self, x.value)
        kind = self.calls[-1].routine.head.returns
        if value is not None and kind is not None:
            value = converted(value, Type(kind.upper()))
        self.calls.pop()
        if result is not None and value is not None:
            result.append(value)

    def _trigger(self, x: s.Trigger) -> None:
        """A trigger's action is carried out where it is written: its time on the path is not modelled."""
        if isinstance(x.action, s.Assign):
            advance = self.motions.advance
            self._assign(x.action)
            self.motions.advance = advance

    def _spline(self, x: s.SplineBlock, now: Call, at: int) -> None:
        raise HaltError("not-modelled", f"{x.kind} ... ENDSPLINE is not modelled", "single SPTP, SLIN, SCIRC are")


def _root(target: e.Reference) -> str:
    while not isinstance(target, e.Name):
        target = target.of
    return target.name


_Act = Callable[[Machine, Any, Call, int], None]
_ACTS: dict[type, _Act] = {
    s.Assign: lambda m, x, now, at: m._assign(x),
    s.Invoke: lambda m, x, now, at: m._invoke(x),
    s.Move: lambda m, x, now, at: m._move(x),
    s.Wait: lambda m, x, now, at: m._wait(x),
    s.Plain: lambda m, x, now, at: m._plain(x, now, at),
    s.Condition: lambda m, x, now, at: m._condition(x, now, at),
    s.Case: lambda m, x, now, at: m._jump("CASE", now.routine.blocks[at], now) if at in now.routine.blocks else None,
    s.For: lambda m, x, now, at: m._for(x, now, at) if at in now.routine.blocks else None,
    s.Jump: lambda m, x, now, at: m._goto(x, now),
    s.Trigger: lambda m, x, now, at: m._trigger(x),
    s.SplineBlock: lambda m, x, now, at: m._spline(x, now, at),
}
