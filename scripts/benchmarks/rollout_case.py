"""The case of the rollouts' benchmark: IST under inverse dynamics, each run with bodies of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

import lwr_dyn
from benchmarks.timing import Call
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.run import Motion, Reference
from lwr_dyn.trajectory.references.ist import ist_reference

KP, KD, RATE = 2500.0, 100.0, 1000
MASS, CENTRE, TENSOR = 0.1, 0.005, 0.1
"""Shares of masses and tensors, and the length [m] of centres, by which bodies differ at most from the law's."""


class Sampled:
    """A reference that is sampled once: all loops of the benchmark follow a table."""

    def __init__(self, reference: Reference) -> None:
        self._reference, self._kept = reference, {}

    def __getattr__(self, name: str) -> object:
        return getattr(self._reference, name)

    def sample(self, t: np.ndarray) -> Motion:
        """As the reference has it."""
        key = np.asarray(t).tobytes()
        if key not in self._kept:
            self._kept[key] = self._reference.sample(t)
        return self._kept[key]


@dataclass(frozen=True, eq=False)
class RolloutCase:
    """`runs` arms, and what the law knows of them: the nominal one."""

    arm: Arm
    reference: Reference
    arms: tuple[Arm, ...]

    @classmethod
    def of(cls, runs: int) -> RolloutCase:
        """Seeded arms."""
        arm, rng = lwr_dyn.load("lwr4plus"), np.random.default_rng(5)

        def changed(body: Body) -> Body:
            mass, tensor = 1 + rng.uniform(-1, 1, 2) * (MASS, TENSOR)
            return Body(body.mass * mass, body.com + CENTRE * rng.uniform(-1, 1, 3), body.inertia_com * tensor)

        chains = [with_bodies(arm.chain, [changed(body) for body in arm.chain.bodies]) for _ in range(runs)]
        return cls(arm, Sampled(ist_reference(arm)), tuple(replace(arm, chain=chain) for chain in chains))

    @cached_property
    def inertia(self) -> np.ndarray:
        """(runs, 70) inertial parameters."""
        return np.array([inertial_parameters(arm.chain).ravel() for arm in self.arms])

    @cached_property
    def law(self) -> InverseDynamics:
        """Inverse dynamics of the nominal arm."""
        return InverseDynamics(lwr_dyn.dynamics_of(self.arm), KP, KD)

    def motion(self, seconds: float) -> Motion:
        """The reference at every sample, the end too."""
        return self.reference.sample(np.arange(round(seconds * RATE) + 1) / RATE)

    def rollouts(self, runs: int, seconds: float, record: int = 0) -> lwr_dyn.codegen.rollouts.result.Rollouts:
        """The first runs, by the kernel."""
        return lwr_dyn.rollouts(
            self.arm, self.law, self.reference, duration=seconds, record=record,
            parameters={"inertia": self.inertia[:runs]},
        )  # fmt: skip

    def ours(self, runs: int, seconds: float) -> Call:
        """From arrays of parameters to metrics, on one thread."""
        return lambda: self.rollouts(runs, seconds)

    def write(self, folder: Path, seconds: float) -> None:
        """What a peer in another environment reads: models, bodies in MuJoCo's terms, the motion."""
        import mujoco

        models = [mujoco.MjModel.from_xml_string(mjcf_text(arm)) for arm in self.arms]
        motion = self.motion(seconds)
        bodies = {
            name: np.array([getattr(model, name) for model in models])
            for name in ("body_mass", "body_inertia", "body_ipos", "body_iquat")
        }
        np.savez(folder / "case.npz", q=motion.q, dq=motion.dq, ddq=motion.ddq, gains=[KP, KD], rate=RATE, **bodies)
        for name, arm in (("law", self.arm), ("plant", self.arms[0])):
            (folder / f"{name}.xml").write_text(mjcf_text(arm), encoding="utf-8")
            (folder / f"{name}.urdf").write_text(lwr_dyn.urdf_text(arm), encoding="utf-8")
