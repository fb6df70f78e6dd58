"""Checking a program: what a compiler says, and what a careful commissioner would find on the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from lwr_dyn.krl.diagnosis import Diagnosis, in_order
from lwr_dyn.krl.machine import Machine
from lwr_dyn.krl.program import Program
from lwr_dyn.krl.settings import Settings
from lwr_dyn.krl.statics import static_diagnoses
from lwr_dyn.krl.values import Value
from lwr_dyn.model.arm import Arm

MOTIONS = 1000
"""Motions of a program that a check plans; the run plans all."""
UNREADABLE = frozenset({
    "syntax", "unknown-keyword", "open-bracket", "open-string", "bad-literal", "bad-character", "long-line",
    "missing-end", "stray-end", "wrong-end", "missing-def", "outside-routine", "encoding", "deep-nesting",
})  # fmt: skip
"""With one of these errors it is not clear what would run: motions are not looked at."""


def check_program(
    program: Program, arm: Arm | None = None, settings: Settings | None = None, given: Mapping[str, Value] | None = None
) -> tuple[Diagnosis, ...]:
    """Everything there is to say of a program, in order; of its motions too when an arm is given.

    Parameters
    ----------
    program : Program
    arm : Arm, optional
        Whose motions are planned; without it only language and types are checked.
    settings : Settings, optional
    given : mapping, optional
        Inputs and variables the world sets: `$IN[3]` -> value.

    Raises
    ------
    OptionError, MissingDataError
        The arm has no KUKA axes, or no axis speeds.

    >>> from lwr_dyn.krl.program import parse_program
    >>> for d in check_program(parse_program("DEF a( )\\nWAIT SEC x\\nEND\\n", name="a")): print(d)
    a.src:2:10: error undeclared: x is not declared (declare it in the .dat or with DECL; no .dat is there)
    """
    found = [*program.found, *static_diagnoses(program)]
    broken = any(d.severity == "error" and d.code in UNREADABLE for d in found)
    if arm is None or broken:
        return in_order(found)
    used = settings or Settings()
    machine = Machine(program, arm, replace(used, motions=min(MOTIONS, used.motions)), given or {}, tolerant=True)
    known = {(d.place.file, d.place.line, d.code) for d in found}
    ran = machine.run()
    return in_order([*found, *(d for d in ran if (d.place.file, d.place.line, d.code) not in known)])
