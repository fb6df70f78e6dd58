"""The error tree: every error of this package is an `LwrDynError` and carries its facts as attributes.

Each leaf also has a built-in parent, so ``except ValueError`` written by somebody who does not know this
package still works. `exit_code` is what `lwr-dyn` returns when the error ends a command.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class LwrDynError(Exception):
    """Parent of every error this package raises on purpose."""

    exit_code = 2


class RatingWarning(UserWarning):
    """Something is asked of an arm that its maker does not rate it for."""


class ShapeError(LwrDynError, ValueError):
    """An array has the wrong shape, or holds a number that is not finite."""

    def __init__(self, name: str, found: str, allowed: str) -> None:
        super().__init__(f"{name}: {found}; allowed: {allowed}")
        self.name, self.found, self.allowed = name, found, allowed


class OptionError(LwrDynError, ValueError):
    """An option or argument has a value outside what is allowed."""

    def __init__(self, name: str, found: object, allowed: str) -> None:
        super().__init__(f"{name}: {found}; allowed: {allowed}")
        self.name, self.found, self.allowed = name, found, allowed


class UnknownNameError(LwrDynError, LookupError):
    """A robot, reading, joint, link or engine of that name does not exist."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        name = str(name)  # a number or None, given by mistake, is told too
        self.kind, self.name, self.known = kind, name, tuple(known)
        near = get_close_matches(name, self.known, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        super().__init__(f"no {kind} named {name!r}{hint}; known: {', '.join(self.known) or 'none'}")


class PaperError(LwrDynError, ValueError):
    """A data file breaks the schema; says which file, which field, and what is allowed."""

    def __init__(self, file: str, field: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {field}: {found}; allowed: {allowed}")
        self.file, self.field, self.found, self.allowed = file, field, found, allowed


class UrdfError(LwrDynError, ValueError):
    """A URDF cannot be read as a serial chain; says which file, which element, and what is allowed."""

    def __init__(self, file: str, element: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {element}: {found}; allowed: {allowed}")
        self.file, self.element, self.found, self.allowed = file, element, found, allowed


class NotPhysicalError(LwrDynError, ValueError):
    """An arm has inertias that no body can have, and was asked to move."""

    def __init__(self, arm: str, links: Iterable[str]) -> None:
        self.arm, self.links = arm, tuple(links)
        super().__init__(
            f"{arm}: the inertia of {', '.join(self.links)} is not physical; "
            "allowed: another reading, or allow_unphysical (--allow-unphysical)"
        )


class MissingDataError(LwrDynError, ValueError):
    """The data file does not give what was asked for (an exercise without masses has no dynamics)."""

    def __init__(self, arm: str, missing: str, needed_for: str) -> None:
        super().__init__(f"{arm}: {missing} not given; needed for {needed_for}")
        self.arm, self.missing, self.needed_for = arm, missing, needed_for


class FileAccessError(LwrDynError, OSError):
    """A file cannot be read or written."""

    def __init__(self, path: str, reason: str, allowed: str) -> None:
        super().__init__(f"{path}: {reason}; allowed: {allowed}")
        self.path, self.reason, self.allowed = path, reason, allowed

    def __str__(self) -> str:
        return str(self.args[0])


class MissingPackageError(LwrDynError, ImportError):
    """An optional package is needed and not installed."""

    def __init__(self, package: str, extra: str) -> None:
        target = f"lwr_dyn[{extra}]" if extra else "lwr_dyn"
        super().__init__(f"{package} is not installed; install it with: pip install '{target}'")
        self.package, self.extra = package, extra


class PathLimitError(LwrDynError, ValueError):
    """A movement leaves the reach or the position limits of the arm; says when, where, which joint, by how much."""

    def __init__(
        self, t: float, where: str, fault: str, allowed: str, joint: str | None = None, excess: float | None = None
    ) -> None:
        super().__init__(f"at t = {t:.6g} s, {where}: {fault}; allowed: {allowed}")
        self.t, self.where, self.fault, self.allowed = t, where, fault, allowed
        self.joint, self.excess = joint, excess


class DivergenceError(LwrDynError, ArithmeticError):
    """A simulation left what numbers can follow; `run` keeps what was computed up to then."""

    def __init__(self, t: float, joint: str, found: str, allowed: str, run: object = None) -> None:
        super().__init__(f"the simulation diverges at t = {t:.6g} s: {joint}: {found}; allowed: {allowed}")
        self.t, self.joint, self.found, self.allowed, self.run = t, joint, found, allowed, run


class OutOfReachError(LwrDynError, ValueError):
    """A pose on a path lies beyond what the arm can reach: at path parameter (or row) `at`, by `distance` [m]."""

    def __init__(self, arm: str, at: float, distance: float, parameter: str = "s") -> None:
        super().__init__(
            f"the path leaves the reach of {arm} at {parameter} = {at:.6g}, by {distance:.6g} m; "
            "allowed: a path whose wrist centre stays within reach"
        )
        self.arm, self.at, self.distance = arm, at, distance


class OutsideLimitsError(LwrDynError, ValueError):
    """No arm angle keeps a path inside the joint limits: worst at `at`, joint `joint`, by `excess` [rad]."""

    def __init__(self, arm: str, at: float, joint: str, excess: float, why: str) -> None:
        super().__init__(
            f"the path leaves the limits of {arm} at s = {at:.6g}: {joint} is outside by {excess:.6g} rad ({why}); "
            "allowed: a path inside the limits"
        )
        self.arm, self.at, self.joint, self.excess, self.why = arm, at, joint, excess, why


class SingularArmError(LwrDynError, ArithmeticError):
    """Joint rates are not determined: the arm is singular at row `index` of a path; `why` names the alignment."""

    def __init__(self, index: int, why: str) -> None:
        super().__init__(f"row {index} of the path: {why}; allowed: poses and arm angles away from singularities")
        self.index, self.why = index, why


class LogError(LwrDynError, ValueError):
    """A log cannot be used for identification; says which file, which row or column, and what is needed."""

    def __init__(self, file: str, where: str, found: str, needed: str) -> None:
        super().__init__(f"{file}: {where}: {found}; needed: {needed}")
        self.file, self.where, self.found, self.needed = file, where, found, needed


class ProgramError(LwrDynError, RuntimeError):
    """A KRL program cannot go on (or cannot begin): where, a code, what, and what helps."""

    def __init__(self, place: str, code: str, message: str, hint: str) -> None:
        super().__init__(f"{place}: {message}" + (f"; {hint}" if hint else ""))
        self.place, self.code, self.message, self.hint = place, code, message, hint


class CacheWarning(UserWarning):
    """Compiled kernels cannot be kept; every process compiles them anew."""

    def __init__(self, folder: str, reason: str) -> None:
        super().__init__(
            f"compiled kernels cannot be kept in {folder} ({reason}): this process compiles its own; "
            "name another folder in LWR_DYN_CACHE"
        )
        self.folder, self.reason = folder, reason


class NotFiniteWarning(UserWarning):
    """States of a batch hold a value that is not finite; their results are NaN, all others are computed."""

    def __init__(self, function: str, indices: Iterable[int], count: int) -> None:
        self.function, self.indices = function, tuple(int(i) for i in indices)
        shown = ", ".join(str(i) for i in self.indices[:5]) + (", ..." if len(self.indices) > 5 else "")
        super().__init__(
            f"{function}: {len(self.indices)} of {count} states are not finite (index {shown}): their results are NaN"
        )


class EvidenceError(LwrDynError, ValueError):
    """Evidence for a reading cannot be used; says which entry, what is there, and what is allowed."""

    def __init__(self, where: str, found: str, allowed: str) -> None:
        super().__init__(f"evidence: {where}: {found}; allowed: {allowed}")
        self.where, self.found, self.allowed = where, found, allowed


class TableError(LwrDynError, ValueError):
    """A file of tables cannot be read as one; says which file, where in it, what was found, and what is allowed."""

    def __init__(self, file: str, place: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {place}: {found}; allowed: {allowed}")
        self.file, self.place, self.found, self.allowed = file, place, found, allowed
