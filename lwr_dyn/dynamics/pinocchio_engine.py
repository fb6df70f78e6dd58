"""Road A: the only door to Pinocchio. The model is built from the URDF text; rotors enter as `armature`.

A single state takes the fast way: Pinocchio is called at once, and the gate only diagnoses what it refused or what came
out not finite. One entry is enough to see that: a value that is not finite runs outward with the motion and back with
the force, so it reaches the first torque, and the last acceleration.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import isfinite
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array, same_batch
from lwr_dyn.model.arm import Arm
from lwr_dyn.urdf.writer import urdf_text

PinocchioModel = Any
"""pinocchio.Model; the wheel ships no types."""


def pinocchio_model(arm: Arm) -> PinocchioModel:
    """The arm's URDF text as a Pinocchio model, with rotor inertia in `armature` and the arm's gravity.

    Raises `MissingDataError` for an arm without inertias.
    """
    arm.require_dynamics()
    model = pin.buildModelFromXML(urdf_text(arm))
    model.armature = arm.armature
    model.gravity.linear = np.array(arm.chain.gravity)
    return model


def flange_poses(arm: Arm, q: Array) -> Array:
    """Pose of the URDF's flange in its base by Pinocchio, (k, 4, 4), for q (k, n); needs no inertias."""
    model = pin.buildModelFromXML(urdf_text(arm))
    data, flange = model.createData(), model.getFrameId("flange", pin.FrameType.BODY)
    poses = []
    for state in q:
        pin.forwardKinematics(model, data, np.ascontiguousarray(state))
        poses.append(np.array(pin.updateFramePlacement(model, data, flange).homogeneous))
    return np.array(poses)


class PinocchioCalls:
    """Pinocchio's functions bound to one model and its data, nothing checked: for loops."""

    __slots__ = (
        "bias_torque",
        "coriolis_matrix",
        "forward_dynamics",
        "gravity_vector",
        "inverse_dynamics",
        "mass_matrix",
        "mechanical_energy",
        "potential_energy",
    )

    def __init__(self, model: PinocchioModel, data: Any) -> None:
        self.mass_matrix = partial(pin.crba, model, data)
        self.coriolis_matrix = partial(pin.computeCoriolisMatrix, model, data)
        self.gravity_vector = partial(pin.computeGeneralizedGravity, model, data)
        self.bias_torque = partial(pin.nonLinearEffects, model, data)
        self.inverse_dynamics = partial(pin.rnea, model, data)
        self.forward_dynamics = partial(pin.aba, model, data)
        self.potential_energy = partial(pin.computePotentialEnergy, model, data)
        self.mechanical_energy = partial(pin.computeMechanicalEnergy, model, data)


class Pinocchio:
    """The engine "pinocchio"; implements the `Dynamics` protocol. Not for use by two threads at once."""

    __slots__ = ("_shape", "data", "model", "n", "ungated")

    def __init__(self, arm: Arm) -> None:
        self.model = pinocchio_model(arm)
        self.data = self.model.createData()
        self.n: int = arm.n
        self._shape = (arm.n,)
        self.ungated = PinocchioCalls(self.model, self.data)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """B(q), (..., n, n)."""
        try:
            if q.shape == self._shape:  # type: ignore[union-attr]
                out: Array = self.ungated.mass_matrix(q)
                if isfinite(out.item(0) + q.item(0)):  # type: ignore[union-attr]
                    return out
        except (AttributeError, TypeError):
            pass  # not arrays of numbers: the gate says so
        return self._each(self.ungated.mass_matrix, q=q)

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq), (..., n, n)."""
        try:
            if q.shape == dq.shape == self._shape:  # type: ignore[union-attr]
                out: Array = self.ungated.coriolis_matrix(q, dq)
                if isfinite(q.dot(q) + dq.dot(dq)):  # type: ignore[union-attr]
                    return out
        except (AttributeError, TypeError):
            pass  # not arrays of numbers: the gate says so
        return self._each(self.ungated.coriolis_matrix, q=q, dq=dq)

    def gravity_vector(self, q: ArrayLike) -> Array:
        """g(q), (..., n)."""
        try:
            if q.shape == self._shape:  # type: ignore[union-attr]
                out: Array = self.ungated.gravity_vector(q)
                if isfinite(out.item(0)):
                    return out
        except (AttributeError, TypeError):
            pass  # not arrays of numbers: the gate says so
        return self._each(self.ungated.gravity_vector, q=q)

    def bias_torque(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """C(q, dq) dq + g(q), (..., n)."""
        try:
            if q.shape == dq.shape == self._shape:  # type: ignore[union-attr]
                out: Array = self.ungated.bias_torque(q, dq)
                if isfinite(out.item(0)):
                    return out
        except (AttributeError, TypeError):
            pass  # not arrays of numbers: the gate says so
        return self._each(self.ungated.bias_torque, q=q, dq=dq)

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Array:
        """tau, (..., n)."""
        try:
            if q.shape == dq.shape == ddq.shape == self._shape:  # type: ignore[union-attr]
                out: Array = self.ungated.inverse_dynamics(q, dq, ddq)
                if isfinite(out.item(0)):
                    return out
        except (AttributeError, TypeError):
            pass  # not arrays of numbers: the gate says so
        return self._each(self.ungated.inverse_dynamics, q=q, dq=dq, ddq=ddq)

    def forward_dynamics(self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike) -> Array:
        """ddq, (..., n)."""
        try:
            if q.shape == dq.shape == tau.shape == self._shape:  # type: ignore[union-attr]
                out: Array = self.ungated.forward_dynamics(q, dq, tau)
                if isfinite(out.item(-1)):
                    return out
        except (AttributeError, TypeError):
            pass  # not arrays of numbers: the gate says so
        return self._each(self.ungated.forward_dynamics, q=q, dq=dq, tau=tau)

    def potential_energy(self, q: ArrayLike) -> Array:
        """U(q), (...)."""
        return self._each(self.ungated.potential_energy, q=q)

    def _each(self, call: Callable[..., Any], **arrays: ArrayLike) -> Array:
        """`call` for every state of a batch, behind the shape gate."""
        checked = {name: joint_array(name, value, self.n) for name, value in arrays.items()}
        batch = same_batch(**checked)
        rows = [np.broadcast_to(a, (*batch, self.n)).reshape(-1, self.n) for a in checked.values()]
        out = [call(*(np.ascontiguousarray(r) for r in state)) for state in zip(*rows, strict=True)]
        if not out:
            probe = np.asarray(call(*(np.zeros(self.n) for _ in rows)))
            return np.zeros((*batch, *probe.shape))
        return np.array(out, dtype=np.float64).reshape((*batch, *np.shape(out[0])))


def pinocchio_engine(arm: Arm, rotors: str) -> Pinocchio:
    """The row "pinocchio" of the engines."""
    return Pinocchio(arm)
