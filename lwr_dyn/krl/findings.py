"""What is said while a program runs, and how a fault or a bound ends it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NoReturn

from lwr_dyn.krl.diagnosis import Diagnosis, Place, Severity
from lwr_dyn.krl.values import HaltError


class StoppedError(Exception):
    """A bound is reached, or the program ended by itself: why."""

    def __init__(self, diagnosis: Diagnosis | None) -> None:
        super().__init__()
        self.diagnosis = diagnosis


@dataclass(slots=True, eq=False)
class Findings:
    """Diagnoses at the statement that is being carried out; an error ends the run unless `tolerant`."""

    place: Place
    """Of that statement."""
    tolerant: bool
    found: list[Diagnosis] = field(default_factory=list)

    def say(self, severity: str, code: str, message: str, hint: str) -> None:
        """A diagnosis here."""
        said = Diagnosis(self.place, severity, code, message, hint)  # type: ignore[arg-type]
        if severity == "error" and not self.tolerant:
            raise StoppedError(said)
        self.found.append(said)

    def stop(self, severity: Severity, code: str, message: str, hint: str) -> NoReturn:
        """End the run here, with a diagnosis."""
        raise StoppedError(Diagnosis(self.place, severity, code, message, hint))

    def halted(self, fault: HaltError) -> None:
        """Say what a statement halted at, and whether the run can go on without it."""
        # while checking, what a value is missing for has been said, or ends the run there
        if self.tolerant and fault.code in ("unknown-input", "not-modelled"):
            self.stop("note", fault.code, f"not looked at from here: {fault.message}", fault.hint)
        if self.tolerant and fault.code == "undeclared":
            return
        self.say("error", fault.code, fault.message, fault.hint)
        if fault.code in ("recursion", "waits-forever"):
            raise StoppedError(None)
