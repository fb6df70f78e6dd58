"""The error tree: every error of this package is an `LwrDynError` and keeps its facts as attributes.

Each error also has a built-in parent, so ``except ValueError`` works for callers that do not know this package.
`exit_code` is what `lwr-dyn` returns when the error ends a command. Optional packages define their own errors.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from typing import Any


class LwrDynError(Exception):
    """Parent of every error this package raises on purpose."""

    exit_code = 2


class FaultError(LwrDynError):
    """Parent of errors that say what is at fault (`name`), what was `found` there, and what is `allowed`.

    >>> print(FaultError("mass", -1.0, "a number above 0"))
    mass: -1.0; allowed: a number above 0
    """

    def __init__(self, name: str, found: object, allowed: str) -> None:
        super().__init__(f"{name}: {found}; allowed: {allowed}")
        self.name, self.found, self.allowed = name, found, allowed


class RatingWarning(UserWarning):
    """An arm is used beyond what its maker rates it for."""


class ShapeError(FaultError, ValueError):
    """An array has the wrong shape, or holds a number that is not finite."""


class OptionError(FaultError, ValueError):
    """An option or argument has a value outside what is allowed."""


OTHER_NAMES = {"computed-torque": "inverse-dynamics", "feedback-linearization": "inverse-dynamics", "pd": "pd-gravity"}
"""Other words of the field -> the name here."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The known name that is most like a misspelt one, as " (did you mean X?)"; empty where none is.

    >>> did_you_mean("pd-gravty", ("pid", "pd-gravity"))
    ' (did you mean pd-gravity?)'
    """
    known = list(known)
    near = [OTHER_NAMES[name]] if OTHER_NAMES.get(name) in known else get_close_matches(name.lower(), known, n=1)
    return f" (did you mean {near[0]}?)" if near else ""


class UnknownNameError(LwrDynError, LookupError):
    """A robot, reading, joint, link or engine of that name does not exist."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        name = str(name)  # callers may pass a number or None by mistake
        self.kind, self.name, self.known = kind, name, tuple(known)
        listed = ", ".join(self.known) or "none"
        super().__init__(f"no {kind} named {name!r}{did_you_mean(name, self.known)}; known: {listed}")


class LogError(LwrDynError, ValueError):
    """A log cannot be used for identification: which `file`, `where` (a row or column), `found` and `needed`."""

    def __init__(self, file: str, where: str, found: str, needed: str) -> None:
        super().__init__(f"{file}: {where}: {found}; needed: {needed}")
        self.file, self.where, self.found, self.needed = file, where, found, needed


class PaperError(FaultError, ValueError):
    """A data file breaks the schema: which `file`, which `field`."""

    def __init__(self, file: str, field: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {field}", found, allowed)
        self.file, self.field = file, field


class UrdfError(FaultError, ValueError):
    """A URDF cannot be read as a serial chain: which `file`, which `element`."""

    def __init__(self, file: str, element: str, found: str, allowed: str) -> None:
        super().__init__(f"{file}: {element}", found, allowed)
        self.file, self.element = file, element


class NotPhysicalError(LwrDynError, ValueError):
    """A simulation of an arm with inertias that no body can have."""

    def __init__(self, arm: str, links: Iterable[str]) -> None:
        self.arm, self.links = arm, tuple(links)
        super().__init__(
            f"{arm}: the inertia of {', '.join(self.links)} is not physical; "
            "allowed: a body that can exist (lwr-dyn check), another reading, or allow_unphysical "
            "(simulate --allow-unphysical)"
        )


class MissingDataError(LwrDynError, ValueError):
    """The data file lacks numbers that are needed (an exercise without masses has no dynamics)."""

    def __init__(self, arm: str, missing: str, needed_for: str) -> None:
        super().__init__(f"{arm}: {missing} not given; needed for {needed_for}")
        self.arm, self.missing, self.needed_for = arm, missing, needed_for


class FileAccessError(FaultError, OSError):
    """A file cannot be read or written: its `path` and the `reason`."""

    def __init__(self, path: str, reason: str, allowed: str) -> None:
        super().__init__(path, reason, allowed)
        self.path, self.reason = path, reason

    def __str__(self) -> str:
        return str(self.args[0])


class MissingPackageError(LwrDynError, ImportError):
    """An optional package is needed and not installed."""

    def __init__(self, package: str, extra: str, instead: str = "") -> None:
        target, without = f"lwr_dyn[{extra}]" if extra else "lwr_dyn", f"; without it: {instead}" if instead else ""
        super().__init__(f"{package} is not installed; install it with: pip install '{target}'{without}")
        self.package, self.extra = package, extra


@contextmanager
def needs_extra(extra: str) -> Iterator[None]:
    """A block of imports that needs a pip extra; raises `MissingPackageError` where a package is not installed.

    >>> with needs_extra("symbolic"):
    ...     import a_package_that_does_not_exist
    Traceback (most recent call last):
    lwr_dyn.foundation.errors.MissingPackageError: a_package_that_does_not_exist is not installed; install it with: ...
    """
    try:
        yield
    except ModuleNotFoundError as fault:
        raise MissingPackageError(fault.name or extra, extra) from None


class PathLimitError(FaultError, ValueError):
    """A movement leaves the reach or the position limits of the arm: when, where, which joint, by how much."""

    def __init__(
        self, t: float, where: str, fault: str, allowed: str, joint: str | None = None, excess: float | None = None
    ) -> None:
        super().__init__(f"at t = {t:.6g} s, {where}", fault, allowed)
        self.t, self.where, self.fault, self.joint, self.excess = t, where, fault, joint, excess


class DivergenceError(FaultError, ArithmeticError):
    """The state of a simulation grew beyond all bounds; `run` keeps what was computed up to then."""

    def __init__(self, t: float, joint: str, found: str, allowed: str, run: object = None) -> None:
        super().__init__(f"the simulation diverges at t = {t:.6g} s: {joint}", found, allowed)
        self.t, self.joint, self.run = t, joint, run


class OutOfReachError(LwrDynError, ValueError):
    """A pose on a path lies beyond what the arm can reach: at path parameter (or row) `at`, by `distance` [m]."""

    def __init__(self, arm: str, at: float, distance: float, parameter: str = "s") -> None:
        super().__init__(
            f"the path leaves the reach of {arm} at {parameter} = {at:.6g}, by {distance:.6g} m; "
            "allowed: a path whose wrist centre stays within reach"
        )
        self.arm, self.at, self.distance = arm, at, distance


class PoseNotReachedError(LwrDynError, ValueError):
    """A search found no joint positions for a pose: `distance` [m] and `angle` [rad] from the nearest it met, `q` (n,).

    Where the pose is reached outside the limits only, `joint` is the one that is out by most, by `excess` [rad or m].
    """

    def __init__(self, arm: str, distance: float, angle: float, q: Any, joint: str | None, excess: float) -> None:
        near = f"the nearest position found is {distance:.3g} m and {angle:.3g} rad off"
        out = f"{joint} is outside its limits by {excess:.3g} in the nearest solution found" if joint else near
        allowed = "another pose or q0, or limits=False" if joint else "a pose that the arm reaches, or another q0"
        super().__init__(f"{arm} does not reach the pose: {out}; allowed: {allowed}")
        self.arm, self.distance, self.angle, self.q, self.joint, self.excess = arm, distance, angle, q, joint, excess


class OutsideLimitsError(LwrDynError, ValueError):
    """No arm angle keeps a path inside the joint limits: worst at `at`, joint `joint`, by `excess` [rad]."""

    def __init__(self, arm: str, at: float, joint: str, excess: float, why: str) -> None:
        super().__init__(
            f"the path leaves the limits of {arm} at s = {at:.6g}: {joint} is outside by {excess:.6g} rad ({why}); "
            "allowed: a path inside the limits"
        )
        self.arm, self.at, self.joint, self.excess, self.why = arm, at, joint, excess, why


class SingularMassError(FaultError, ArithmeticError):
    """Accelerations are not determined: `joint` (from 1) moves no inertia, so the mass matrix has no inverse."""

    def __init__(self, joint: int) -> None:
        super().__init__(
            "forward dynamics", f"joint {joint} moves no inertia", "mass or a rotor at or beyond each joint"
        )
        self.joint = joint


class SingularArmError(LwrDynError, ArithmeticError):
    """Joint rates are not determined: the arm is singular at row `index` of a path; `why` names the alignment."""

    def __init__(self, index: int, why: str) -> None:
        super().__init__(f"row {index} of the path: {why}; allowed: poses and arm angles away from singularities")
        self.index, self.why = index, why
