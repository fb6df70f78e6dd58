"""The assignments after WITH of a spline motion: they hold for it alone, then the old values come back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from types import TracebackType

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import root_name
from lwr_dyn.krl.running.values import ArrayValue, Value, copied

TIMED = ("$VEL", "$ACC", "$APO", "$VEL_AXIS", "$ACC_AXIS", "$TOOL", "$BASE", "$IPO_MODE", "$ADVANCE", "$OV_PRO")
"""Variables that change where or when the arm moves; another one that cannot be computed is only noted."""
OF_ALL_AXES = ("$VEL_AXIS", "$ACC_AXIS", "$GEAR_JERK")
"""Given for axis 1 alone, as inline forms do, they count for all axes."""


@dataclass(slots=True)
class WithSettings(AbstractContextManager[None]):
    """Applies assignments, and takes them back at its exit."""

    controller: ControllerState
    note: Callable[[str], None]
    settings: Sequence[s.Assign]
    assign: Callable[[s.Assign], None]
    before: dict[str, Value | None] = field(default_factory=dict)
    speeds: set[str] = field(default_factory=set)

    def __enter__(self) -> None:
        c = self.controller
        known = set(c.speeds_set)
        for setting in self.settings:
            name = root_name(setting.target)
            variable = c.variable(name) if name.startswith("$") else None
            if variable is not None and name not in self.before:
                self.before[name] = None if variable.value is None else copied(variable.value)
            try:
                self.assign(setting)
            except ExecutionError as fault:
                if name in TIMED or fault.code != "not-modelled":
                    self.__exit__(None, None, None)
                    raise
                self.note(f"{name} after WITH")
        for name in OF_ALL_AXES:
            self._spread(name)
        self.speeds = c.speeds_set - known

    def _spread(self, name: str) -> None:
        """Give the value of axis 1 to all axes when no other one is set."""
        targets = [x.target for x in self.settings if root_name(x.target) == name]
        variable = self.controller.variables.get(name)
        if len(targets) == 1 and isinstance(targets[0], e.Index) and variable is not None:
            array = variable.value
            if isinstance(array, ArrayValue) and targets[0].indices == (e.Integer(1),) and (1,) in array.items:
                self.controller.assumptions.note(f"{name}[1] after WITH", "", "counts for all axes")
                array.items.update(dict.fromkeys([(i,) for i in range(1, 7)], array.items[1,]))

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        for name, value in self.before.items():
            self.controller.variables[name].value = value
        self.controller.speeds_set -= self.speeds
