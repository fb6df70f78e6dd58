"""lwr_dyn: from a robot paper's tables to a URDF, its mass matrix B, Coriolis matrix C and gravity torque g.

    B(q) ddq + C(q, dq) dq + g(q) = tau - tau_friction(dq)

Names are loaded when they are first used, so importing the package loads no engine.
"""

from typing import TYPE_CHECKING, Any

from lwr_dyn.foundation.version import VERSION

__version__ = VERSION

if TYPE_CHECKING:
    from lwr_dyn.front import batch_dynamics as batch_dynamics
    from lwr_dyn.front import compare as compare
    from lwr_dyn.front import controller as controller
    from lwr_dyn.front import dynamics_of as dynamics_of
    from lwr_dyn.front import engines as engines
    from lwr_dyn.front import forward_kinematics as forward_kinematics
    from lwr_dyn.front import ik_solver as ik_solver
    from lwr_dyn.front import inverse_kinematics as inverse_kinematics
    from lwr_dyn.front import load as load
    from lwr_dyn.front import margins as margins
    from lwr_dyn.front import plot as plot
    from lwr_dyn.front import readings as readings
    from lwr_dyn.front import reference as reference
    from lwr_dyn.front import replay as replay
    from lwr_dyn.front import robots as robots
    from lwr_dyn.front import rollouts as rollouts
    from lwr_dyn.front import show as show
    from lwr_dyn.front import simulate as simulate
    from lwr_dyn.front import urdf_text as urdf_text
    from lwr_dyn.model.run import Run as Run

__all__ = [
    "Run",
    "batch_dynamics",
    "compare",
    "controller",
    "dynamics_of",
    "engines",
    "forward_kinematics",
    "ik_solver",
    "inverse_kinematics",
    "load",
    "margins",
    "plot",
    "readings",
    "reference",
    "replay",
    "robots",
    "rollouts",
    "show",
    "simulate",
    "urdf_text",
]


def __getattr__(name: str) -> Any:
    if name == "Run":
        from lwr_dyn.model import run

        return run.Run
    if name in __all__:
        from lwr_dyn import front

        return getattr(front, name)
    raise AttributeError(f"module 'lwr_dyn' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
