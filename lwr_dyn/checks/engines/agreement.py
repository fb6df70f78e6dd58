"""Mass, B, C dq, g, torque and flange of a loaded file against ours, largest difference over the states."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.engines.child_process import Loaded
from lwr_dyn.checks.engines.engine import tolerance
from lwr_dyn.checks.engines.reference import FileReference
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.arrays import Array

QUANTITIES = ("B", "C dq", "g", "torque", "flange")


@dataclass(frozen=True, slots=True, eq=False)
class Agreement:
    """Largest differences of an engine from ours: absolute [kg m^2, N m, m], and relative to our largest value."""

    engine: str
    file: str
    mass: float | None
    """What the engine weighs the links that it moves [kg], with those that it fixes to the ground."""
    absolute: dict[str, float]
    relative: dict[str, float]

    def beyond(self) -> list[str]:
        """The quantities above the engine's tolerance."""
        allowed = {"B": "inertia", "C dq": "inertia", "torque": "torque"}
        out = [x for x, value in self.relative.items() if not value <= tolerance(self.engine, allowed.get(x, "g"))]
        return out + [x for x in ("flange",) if not self.absolute[x] <= tolerance(self.engine, "pose")]


def agreement(engine: str, file: str, loaded: Loaded, reference: FileReference, rotors: bool = True) -> Agreement:
    """The differences; without `rotors`, the file's rotor inertia is not expected."""
    absolute = {"flange": _largest(loaded.flange - reference.flange())}
    relative: dict[str, float] = {}
    if loaded.has_dynamics and reference.has_dynamics:
        for name, (theirs, ours) in _pairs(loaded, reference, rotors).items():
            absolute[name] = _largest(theirs - ours)
            scale = _largest(ours)
            relative[name] = absolute[name] / scale if scale > 0.0 else absolute[name]
    return Agreement(engine, file, loaded.mass, absolute, relative)


def _pairs(loaded: Loaded, reference: FileReference, rotors: bool) -> dict[str, tuple[Array, Array]]:
    x, arm = reference.states, reference.arm
    ours = newton_euler_dynamics(arm.chain, rotors="armature" if rotors else "none")
    gravity = ours.gravity_vector(x.q)
    return {
        "B": (loaded.mass_matrix, ours.mass_matrix(x.q)),
        "C dq": (loaded.velocity_torque, ours.bias_torque(x.q, x.dq) - gravity),
        "g": (loaded.gravity_torque, gravity),
        "torque": (loaded.torque, ours.inverse_dynamics(x.q, x.dq, x.ddq) + reference.friction(arm)),
    }


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
