"""lwr_dyn: from a robot paper's tables to a URDF, its mass matrix B, Coriolis matrix C and gravity torque g.

    B(q) ddq + C(q, dq) dq + g(q) = tau - tau_friction(dq)

Names are loaded when they are first used, so importing the package loads no engine; `__init__.pyi` has their types.
"""

from importlib import import_module
from typing import Any

from lwr_dyn.foundation.version import VERSION

__version__ = VERSION

_PLACES = {
    "Motion": "lwr_dyn.model.run",
    "Run": "lwr_dyn.model.run",
    "batch_dynamics": "lwr_dyn.codegen.kernels.batch",
    "compare": "lwr_dyn.studies.compare.comparison",
    "controller": "lwr_dyn.control.controllers",
    "dynamics_of": "lwr_dyn.dynamics.engines",
    "engines": "lwr_dyn.dynamics.engines",
    "forward_kinematics": "lwr_dyn.kinematics.forward",
    "ik_solver": "lwr_dyn.kinematics.pose_solver",
    "inverse_kinematics": "lwr_dyn.kinematics.inverse",
    "load": "lwr_dyn.arms.loading",
    "margins": "lwr_dyn.design.margins",
    "plot": "lwr_dyn.pages.plotting.plots",
    "rank": "lwr_dyn.identification.ranking.rank",
    "readings": "lwr_dyn.arms.papers.catalog",
    "reference": "lwr_dyn.trajectory.references.references",
    "replay": "lwr_dyn.pages.replay.replay_page",
    "robots": "lwr_dyn.arms.papers.catalog",
    "rollouts": "lwr_dyn.codegen.rollouts.rollouts",
    "show": "lwr_dyn.pages.explorer.shown",
    "simulate": "lwr_dyn.simulation.simulate",
    "urdf_text": "lwr_dyn.arms.urdf.writer",
}
"""Name -> the module in which it stands."""
_EXTRAS = {"batch_dynamics": "batch", "plot": "plots", "rollouts": "batch", "show": "batch"}
"""Name -> the pip extra without which its module cannot be imported."""

__all__ = [*_PLACES]  # names as texts


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'lwr_dyn' has no attribute {name!r}")
    from lwr_dyn.foundation.errors import needs_extra

    with needs_extra(_EXTRAS.get(name, "")):
        found = getattr(import_module(_PLACES[name]), name)
    globals()[name] = found  # so that the next use is a plain attribute
    return found


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
