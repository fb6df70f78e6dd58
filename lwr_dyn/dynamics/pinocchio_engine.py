"""Road A: the only module that imports Pinocchio. The model is built from the URDF text; rotors enter as `armature`."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.dynamics.protocol import Gated
from lwr_dyn.dynamics.regressor import chain_with_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind

PinocchioModel = Any
"""pinocchio.Model; the wheel ships no types."""


def rotation_vector(R: Array) -> Array:
    """The vector (3,) [rad] about which a rotation (3, 3) turns, up to half a turn."""
    turn: Array = pin.log3(R)
    return turn


def pinocchio_model(arm: Arm) -> PinocchioModel:
    """The arm's URDF text as a Pinocchio model, with rotor inertia in `armature` and the arm's gravity.

    The text is in the arm's own frames, not in those of a foreign file: there a `continuous` joint has two coordinates.
    Each call gives a model of its own.
    """
    return _built(arm).copy()


@lru_cache(maxsize=32)
def _built(arm: Arm) -> PinocchioModel:
    model = pin.buildModelFromXML(urdf_text(replace(arm, layout=None)))
    model.armature = arm.armature
    model.gravity.linear = np.array(arm.chain.gravity)
    return model


def file_model(path: str | Path, srdf: str | Path | None = None) -> PinocchioModel:
    """Pinocchio's own reading of a URDF file, nothing of ours in it; raises as its parser.

    With `srdf`, the rotors of that file are its armature.
    """
    model = pin.buildModelFromUrdf(str(path))
    if srdf is not None:
        pin.loadRotorParameters(model, str(srdf), False)
    return model


def flange_poses(model: PinocchioModel, q: Array, tip: str = "") -> Array:
    """Pose of a link, the URDF's last if not named, in its first by Pinocchio, (k, 4, 4), for q (k, n); no inertias."""
    data = model.createData()
    flange = model.getFrameId(tip, pin.FrameType.BODY) if tip else model.nframes - 1
    poses = []
    for state in q:
        pin.forwardKinematics(model, data, np.ascontiguousarray(state))
        poses.append(np.array(pin.updateFramePlacement(model, data, flange).homogeneous))
    return np.array(poses)


class FlangeAndJacobian:
    """Pinocchio's q (n,) -> pose (4, 4) and Jacobian (6, n) of flange or tool, linear rows over angular, base frame."""

    __slots__ = ("_data", "_flange", "_model")

    def __init__(self, model: PinocchioModel) -> None:
        self._model, self._data = model, model.createData()
        self._flange = model.nframes - 1  # the last: the tool where the arm has one

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """Pose and Jacobian at q, not checked; the pose stands until the next call."""
        model, data, flange = self._model, self._data, self._flange
        pin.computeJointJacobians(model, data, q)  # computeFrameJacobian would leave the poses of the joints stale
        J = pin.getFrameJacobian(model, data, flange, pin.LOCAL_WORLD_ALIGNED)
        return pin.updateFramePlacement(model, data, flange).homogeneous, J.reshape(6, model.nv)

    def __reduce__(self) -> tuple[type["FlangeAndJacobian"], tuple[PinocchioModel]]:
        return FlangeAndJacobian, (self._model,)


def flange_and_jacobian(arm: Arm) -> FlangeAndJacobian:
    """Pose and Jacobian of an arm's flange or tool."""
    return FlangeAndJacobian(pinocchio_model(arm))


class PinocchioCall(partial[Any]):
    """A function of Pinocchio with its model and data: a law keeps single ones, so each can be pickled by itself."""

    def __reduce__(self) -> tuple[Callable[..., "PinocchioCall"], tuple[str, PinocchioModel]]:
        return pinocchio_call, (self.func.__name__, self.args[0])


def pinocchio_call(name: str, model: PinocchioModel, data: Any = None) -> PinocchioCall:
    """The function of that name; with data of its own where none is given."""
    return PinocchioCall(getattr(pin, name), model, model.createData() if data is None else data)


class PinocchioCalls:
    """Pinocchio's functions bound to one model and its data, nothing checked. Not for use by two threads at once."""

    __slots__ = (
        "acceleration_slopes",
        "bias_torque",
        "coriolis_matrix",
        "data",
        "forward_dynamics",
        "gravity_vector",
        "inverse_dynamics",
        "mass_matrix",
        "mechanical_energy",
        "model",
        "potential_energy",
        "torque_regressor",
    )

    def __init__(self, model: PinocchioModel) -> None:
        self.model, self.data = model, model.createData()
        self.mass_matrix = pinocchio_call("crba", model, self.data)
        self.coriolis_matrix = pinocchio_call("computeCoriolisMatrix", model, self.data)
        self.gravity_vector = pinocchio_call("computeGeneralizedGravity", model, self.data)
        self.bias_torque = pinocchio_call("nonLinearEffects", model, self.data)
        self.inverse_dynamics = pinocchio_call("rnea", model, self.data)
        self.forward_dynamics = pinocchio_call("aba", model, self.data)
        self.acceleration_slopes = pinocchio_call("computeABADerivatives", model, self.data)
        """(q, dq, tau) -> slopes (n, n) of ddq over q, over dq, and over tau, which is B^-1."""
        self.potential_energy = pinocchio_call("computePotentialEnergy", model, self.data)
        self.torque_regressor = pinocchio_call("computeJointTorqueRegressor", model, self.data)  # no rotors
        self.mechanical_energy = pinocchio_call("computeMechanicalEnergy", model, self.data)

    def __reduce__(self) -> tuple[type["PinocchioCalls"], tuple[PinocchioModel]]:
        return PinocchioCalls, (self.model,)


def pinocchio_dynamics(arm: Arm, rotors: str = "armature") -> Gated[PinocchioCalls]:
    """The engine "pinocchio", whose rotors are "armature"; raises `MissingDataError` for an arm without inertias."""
    chain = chain_with_dynamics(arm)
    # B_11 of a sliding first joint is the mass of the arm, whatever q is
    slow = ("mass_matrix",) if chain.links[0].kind is JointKind.PRISMATIC else ()
    maker = pinocchio_dynamics, (arm, rotors)
    return Gated("pinocchio", arm.n, PinocchioCalls(pinocchio_model(arm)), slow=slow, maker=maker)
