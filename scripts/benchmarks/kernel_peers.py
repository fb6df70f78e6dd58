"""Pinocchio's answer to every function of a batch, state by state: what generated kernels are compared with."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from lwr_dyn.checks.arm.model_laws import random_states
from lwr_dyn.codegen.kernels.batch import batch_dynamics
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, in_parent_frame
from lwr_dyn.dynamics.pinocchio_engine import pinocchio_model
from lwr_dyn.model.arm import Arm

Answer = Callable[..., np.ndarray]


def parameters_moved(arm: Arm) -> np.ndarray:
    """(10 n, 10 n): inertial parameters in URDF frames from those in native link frames."""
    out = np.zeros((10 * arm.n, 10 * arm.n))
    for i, link in enumerate(arm.chain.links):
        for k, unit in enumerate(np.eye(10)):
            column = in_parent_frame(unit, link.after.rotation, link.after.position)
            out[10 * i : 10 * i + 10, 10 * i + k] = np.array(column, dtype=float)
    return out


def pinocchio_answers(arm: Arm) -> dict[str, Answer]:
    """Function of a batch -> the same by Pinocchio for one state."""
    model = pinocchio_model(arm)
    data, flange, moves = model.createData(), model.getFrameId("flange"), parameters_moved(arm)

    def pose(q: np.ndarray) -> np.ndarray:
        pin.framesForwardKinematics(model, data, q)
        return data.oMf[flange].homogeneous

    def torque_derivatives(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        by_q, by_v, _ = pin.computeRNEADerivatives(model, data, q, v, a)
        return np.stack([by_q, by_v, pin.crba(model, data, q)])

    def regressor(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return pin.computeJointTorqueRegressor(model, data, q, v, a) @ moves

    return {
        "inverse_dynamics": lambda q, v, a: pin.rnea(model, data, q, v, a),
        "mass_matrix": lambda q: pin.crba(model, data, q),
        "bias_torque": lambda q, v: pin.nonLinearEffects(model, data, q, v),
        "gravity_vector": lambda q: pin.computeGeneralizedGravity(model, data, q),
        "coriolis_matrix": lambda q, v: pin.computeCoriolisMatrix(model, data, q, v),
        "forward_dynamics": lambda q, v, tau: pin.aba(model, data, q, v, tau),
        "flange_pose": pose,
        "jacobian": lambda q: pin.computeFrameJacobian(model, data, q, flange, pin.LOCAL_WORLD_ALIGNED),
        "kinetic_energy": lambda q, v: np.array(pin.computeKineticEnergy(model, data, q, v)),
        "potential_energy": lambda q: np.array(pin.computePotentialEnergy(model, data, q)),
        "torque_regressor": regressor,
        "inverse_dynamics_derivatives": torque_derivatives,
        "forward_dynamics_derivatives": lambda q, v, tau: np.stack(pin.computeABADerivatives(model, data, q, v, tau)),
    }


PIECE = 10_000
"""States that are compared at once."""


def agreement(arm: Arm, count: int) -> dict[str, float]:
    """Function -> largest difference from Pinocchio over seeded random states, as a share of the largest value."""
    states = random_states(arm, count, seed=4)
    x = (states.q, states.dq, states.ddq)
    batch, answers = batch_dynamics(arm), pinocchio_answers(arm)
    out = {}
    for function in FUNCTIONS:
        offset, scale, worst = None, 0.0, 0.0
        for start in range(0, count, PIECE):
            part = tuple(a[start : start + PIECE] for a in x[: len(FUNCTIONS[function].states)])
            values = getattr(batch, function)(*part)
            if function.endswith("_derivatives"):
                last = values.by_ddq if function.startswith("inverse") else values.by_tau
                values = np.stack([values.by_q, values.by_dq, last], axis=1)
            expected = np.array([answers[function](*state) for state in zip(*part, strict=True)])
            if function == "potential_energy":  # only differences mean something
                offset = values[0] - expected[0] if offset is None else offset
                expected = expected + offset
            worst = max(worst, float(np.abs(values - expected).max()))
            scale = max(scale, float(np.abs(expected).max()))
        out[function] = worst / scale
    return out


def relative_difference(values: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference over the states as a share of the largest value; energies are compared by differences."""
    return float(np.abs(values - expected).max() / np.abs(expected).max())
