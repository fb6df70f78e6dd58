"""The loop that rollouts share, checked as `simulate` checks it: arms, references at every sample, options.

References are sampled once for many calls: following a path in space takes longer than a hundred runs of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from math import isfinite
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.kernel_spec import friction_table
from lwr_dyn.codegen.rollouts.philox_code import MOST_SEED
from lwr_dyn.codegen.rollouts.run_parameters import mass_matrices
from lwr_dyn.codegen.rollouts.symbolic_arm import check_friction
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.run import Motion, Reference
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, prepare

_KEPT = 16
"""Motions of each reference, references, and tables that are kept."""


class KnownReference:
    """A reference that keeps the motions that it was asked for."""

    __slots__ = ("_motions", "about", "duration", "name", "reference")

    def __init__(self, reference: Reference) -> None:
        self.reference, self.duration = reference, float(reference.duration)
        self.name = getattr(reference, "name", type(reference).__name__)
        self.about: Any = getattr(reference, "about", {})
        self._motions: dict[tuple[int, float], Motion] = {}

    def sample(self, t: Array) -> Motion:
        """The motion at times from 0 on in equal steps, (k,) [s]."""
        key = len(t), float(t[-1])
        if key not in self._motions:
            if len(self._motions) >= _KEPT:
                self._motions.clear()
            self._motions[key] = self.reference.sample(t)
        return self._motions[key]


def known_reference(reference: Reference) -> KnownReference:
    """The same object for the same reference of this package; a user's own may change, and is sampled at every call."""
    own: Any = reference
    return _known(own) if type(own).__module__.startswith("lwr_dyn.") else KnownReference(reference)


_known = lru_cache(maxsize=_KEPT)(KnownReference)


@lru_cache(maxsize=_KEPT)
def reference_rows(motion: Motion, chain: Chain) -> Array:
    """Rows of a kernel's table, (samples, 3 n + 3): q, dq, ddq, and the place of the tip."""
    return np.hstack([motion.q, motion.dq, motion.ddq, flange_pose(chain, motion.q)[:, :3, 3]])


FRICTIONS = ("none", "smooth")


@dataclass(frozen=True, slots=True, eq=False)
class LoopSetup:
    """What all runs share: `motions` are the references at all samples; `loop` has the friction and the duration."""

    arm: Arm
    controller: Controller
    references: tuple[Reference, ...]
    motions: tuple[Motion, ...]
    loop: Loop
    friction_width: float

    @property
    def plant(self) -> Arm:
        """The arm that is simulated."""
        return self.arm if self.loop.plant is None else self.loop.plant

    @property
    def samples(self) -> int:
        """Samples of a run."""
        return int(self.motions[0].t.size)

    @property
    def t(self) -> Array:
        """Times of the samples [s]."""
        return self.motions[0].t

    def table(self) -> Array:
        """Rows of all references, (references, samples, 3 n + 3): q, dq, ddq, and the place of the tip."""
        return np.ascontiguousarray(np.stack([reference_rows(motion, self.plant.chain) for motion in self.motions]))

    def record(self) -> dict[str, Any]:
        """The options as JSON values."""
        names = ("rate", "substeps", "friction", "saturate", "position_limits", "delay", "seed", "duration")
        width = {} if self.loop.friction == "none" else {"friction_width": self.friction_width}
        references = [str(getattr(each, "name", type(each).__name__)) for each in self.references]
        encoder = None if self.loop.encoder is None else asdict(self.loop.encoder)
        return (
            {name: getattr(self.loop, name) for name in names} | width | {"references": references, "encoder": encoder}
        )


def loop_setup(
    arm: Arm,
    controller: Controller,
    reference: Reference | Sequence[Reference],
    loop: Loop,
    friction_width: float = SMOOTH_SPEED,
) -> LoopSetup:
    """The loop, checked as `simulate` checks it; errors as of `rollouts`, whose friction is "none" or "smooth"."""
    references = tuple(reference) if isinstance(reference, Sequence) else (reference,)
    for each in references:
        if not hasattr(each, "sample"):
            raise OptionError("reference", repr(each), "a Reference, with `sample(t)` and `duration`, or several")
    if not references:
        raise OptionError("reference", "an empty sequence", "a reference, or several")
    _check_friction(arm if loop.plant is None else loop.plant, loop.friction, friction_width)
    encoder = loop.encoder
    if encoder is not None and type(encoder).sensor is not Encoder.sensor:
        raise OptionError("encoder", f"{type(encoder).__name__}, with a sensor of its own", "an Encoder")
    long = max(float(each.duration) for each in references) if loop.duration is None else loop.duration
    free = replace(loop, friction="none", duration=long)
    motions = tuple(prepare(arm, controller, known_reference(each), free).motion for each in references)
    if loop.seed > MOST_SEED:
        raise OptionError("seed", loop.seed, "a whole number below 2^64")
    own = replace(free, friction="smooth") if loop.friction == "smooth" else free
    return LoopSetup(arm, controller, references, motions, own, friction_width)


def _check_friction(plant: Arm, friction: Any, width: float) -> None:
    if friction not in (*FRICTIONS, "set-valued"):
        raise OptionError("friction", repr(friction), ", ".join(FRICTIONS))
    if friction == "set-valued" and any(plant.friction_models()):
        other = "friction 'smooth' with friction_width [rad/s], or simulate"
        raise OptionError("friction", "'set-valued': a kernel has no true stick", other)
    if friction == "smooth":
        friction_table(plant.friction_models())
        if not (isfinite(width) and width > 0.0):
            raise OptionError("friction_width", width, "a speed above 0")


def check_starts(setup: LoopSetup, given: Mapping[str, Array]) -> None:
    """Raise `OptionError` for a run that starts outside the position limits."""
    if not (setup.loop.position_limits and "q0" in given):
        return
    q0, lower, upper = given["q0"], setup.plant.lower, setup.plant.upper
    for run, joint in np.argwhere((q0 < lower) | (q0 > upper))[:1].tolist():
        allowed = f"{lower[joint]:.6g} to {upper[joint]:.6g}, or position_limits=False"
        name = f"q0 of run {run}, {setup.plant.joint_names[joint]}"
        raise OptionError(name, f"{q0[run, joint]:.6g}", allowed)


def check_smooth_friction(setup: LoopSetup, given: Mapping[str, Array]) -> None:
    """Raise `OptionError` for friction of single runs without "smooth", or too stiff for the step where runs begin.

    The mass matrix is that of each run's plant, where the first reference begins.
    """
    own = given.get("friction")
    if setup.loop.friction != "smooth":
        if own is not None:
            raise OptionError("friction", f"{setup.loop.friction!r} with a parameter friction", "'smooth'")
        return
    tables = friction_table(setup.plant.friction_models()) if own is None else own
    B = mass_matrices(setup.plant.chain, setup.motions[0].q[0], given)
    check_friction(B, tables, setup.friction_width, setup.loop.rate, setup.loop.substeps)
