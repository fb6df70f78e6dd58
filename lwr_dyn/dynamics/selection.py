"""Which engine computes an arm's dynamics; engines are imported when they are asked for."""

from __future__ import annotations

from lwr_dyn.arm import Arm
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.errors import OptionError, UnknownNameError

ENGINES = ("pinocchio", "newton-euler")


def dynamics_of(arm: Arm, engine: str = "pinocchio", rotors: str = "armature") -> Dynamics:
    """The dynamics of an arm by one of the engines.

    Parameters
    ----------
    arm : Arm
    engine : {"pinocchio", "newton-euler"}
    rotors : {"armature", "full", "none"}
        "full" adds the paper's spin couplings; only the hand-written recursion has other than "armature".

    Raises
    ------
    UnknownNameError
        No engine of that name.
    OptionError
        Rotors the engine does not know.
    MissingDataError
        The arm has no inertias.
    """
    if rotors not in ("armature", "full", "none"):
        raise OptionError("rotors", repr(rotors), "armature, full, none")
    if engine == "newton-euler":
        from lwr_dyn.dynamics.newton_euler import NewtonEuler

        return NewtonEuler(arm.require_dynamics(), rotors)  # type: ignore[arg-type]
    if engine == "pinocchio":
        if rotors != "armature":
            raise OptionError("rotors", f"{rotors!r} with engine pinocchio", "armature, or engine newton-euler")
        from lwr_dyn.dynamics.engine import Pinocchio

        return Pinocchio(arm)
    raise UnknownNameError("engine", engine, ENGINES)
