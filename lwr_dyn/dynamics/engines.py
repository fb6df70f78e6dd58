"""The engines of an arm's dynamics, by name."""

from collections.abc import Callable

from lwr_dyn.dynamics.protocol import Dynamics, Gated
from lwr_dyn.foundation.arrays import arm_argument
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm

ROTORS = ("armature", "full", "none")
ENGINES: Registry[Callable[[Arm, str], Dynamics]] = Registry(
    "engine",
    {
        "pinocchio": Row(
            "lwr_dyn.dynamics.pinocchio_engine:pinocchio_dynamics",
            "URDF text and Pinocchio",
            facts={"rotors": ("armature",)},
        ),
        "newton-euler": Row(
            "lwr_dyn.dynamics.newton_euler:newton_euler_of_arm", "the recursion on the paper's own frames"
        ),
        "kernels": Row(
            "lwr_dyn.codegen.kernels.engine:kernel_engine", "generated code, for loops and large batches", "batch"
        ),
    },
)
"""Engines by name; each row is a function of the arm and the treatment of its rotors, `ROTORS` where it names none."""


def dynamics_of(arm: Arm, engine: str = "pinocchio", rotors: str = "armature") -> Dynamics:
    """The dynamics of an arm by one of `engines()`: "pinocchio", "newton-euler", or "kernels".

    "kernels" is for loops in Python and for large batches; it compiles a function when it is first used.

    They can be pickled and copied: the copy is made again from the arm and gives the same bits. So can all that
    `lwr_dyn` makes of them: controllers, references, solvers and results go to a process pool.

    Parameters
    ----------
    arm : Arm
    engine : str
    rotors : {"armature", "full", "none"}
        "full" adds the paper's spin couplings; Pinocchio takes "armature" only.

    Raises
    ------
    UnknownNameError
        No engine of that name.
    OptionError
        Rotors that the engine does not have.
    MissingDataError
        The arm has no inertias.
    MissingPackageError
        The engine's extra is not installed.
    """
    arm_argument(arm)
    known = ENGINES[engine].facts.get("rotors", ROTORS)
    if rotors not in known:
        others = [name for name, row in ENGINES.rows.items() if rotors in row.facts.get("rotors", ROTORS)]
        allowed = ", ".join(known) + (f", or engine {' or '.join(others)}" if others else "")
        raise OptionError("rotors", f"{rotors!r} with engine {engine}", allowed)
    made = ENGINES.load(engine)(arm, rotors)
    if isinstance(made, Gated) and made.maker is None:  # a row of another package
        made.maker = dynamics_of, (arm, engine, rotors)
    return made


def engines() -> dict[str, str]:
    """Names of the engines of `dynamics_of`, with a line on each.

    >>> list(engines())[:2]
    ['pinocchio', 'newton-euler']
    """
    return {name: ENGINES[name].about for name in ENGINES.names}
