"""Kernel forms of PD with gravity, PID, inverse dynamics, and PD on the motor side of rigid joints."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.rollouts.law_forms import Column, LawInputs, finite_limits
from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicModel
from lwr_dyn.control.laws.motor_side import MotorSidePD
from lwr_dyn.control.paper_laws import PID, InverseDynamics, PDGravity
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

NOTHING = casadi.SX.zeros(0)


def speed_error(x: LawInputs, velocity_error: bool) -> Column:
    """What Kd acts on: dq, or dq - dq_ref."""
    return x.dq - x.dq_ref if velocity_error else x.dq


@dataclass(frozen=True, slots=True, eq=False)
class PDGravityForm:
    """tau = g(q) + Kp (q_ref - q) - Kd dq, or with Kd on dq - dq_ref."""

    law: PDGravity
    takes = PDGravity
    name = PDGravity.name
    memory = 0

    @classmethod
    def of(cls, law: PDGravity, arm: Arm) -> "PDGravityForm":
        """The form of a controller."""
        return cls(law)

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """Kp [N m/rad], Kd [N m s/rad]."""
        return {"Kp": self.law.Kp.shape, "Kd": self.law.Kd.shape}

    @property
    def digest(self) -> str:
        """The variant."""
        return f"{self.name} velocity_error={self.law.velocity_error}"

    def values(self) -> Mapping[str, Array]:
        """The controller's gains."""
        return {"Kp": self.law.Kp, "Kd": self.law.Kd}

    def start(self) -> Array:
        """No memory."""
        return np.zeros(0)

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        p = x.parameters
        tau = model.gravity(x.q) + p["Kp"] * (x.q_ref - x.q) - p["Kd"] * speed_error(x, self.law.velocity_error)
        return tau, NOTHING

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        law = self.law
        return PDGravity(dynamics_of(arm), values["Kp"], values["Kd"], law.velocity_error, law.gains)


@dataclass(frozen=True, slots=True, eq=False)
class PIDForm:
    """tau = Kp e + I - Kd dq [+ g], dI/dt = Ki e + (sat(tau) - tau) / T_t; the integral is the memory."""

    law: PID
    takes = PID
    name = PID.name

    @classmethod
    def of(cls, law: PID, arm: Arm) -> "PIDForm":
        """The form of a controller."""
        return cls(law)

    @property
    def has_gravity(self) -> bool:
        """Whether g(q) is added."""
        return bool(self.law.parameters["gravity"])

    @property
    def memory(self) -> int:
        """One integral a joint."""
        return self.law.memory_size

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """Gains, the tracking time [s], and the torque limits that the law knows [N m]."""
        return {name: (self.memory,) for name in ("Kp", "Ki", "Kd", "tracking_time", "law_effort")}

    @property
    def digest(self) -> str:
        """The variant."""
        return f"{self.name} velocity_error={self.law.velocity_error} gravity={self.has_gravity}"

    def values(self) -> Mapping[str, Array]:
        """The controller's gains and limits."""
        law = self.law
        limits = [np.inf if x is None else x for x in law.parameters["effort"]]
        gains = {"Kp": law.Kp, "Ki": law.Ki, "Kd": law.Kd, "tracking_time": law.tracking_time}
        return {**gains, "law_effort": finite_limits(limits)}

    def start(self) -> Array:
        """The integral starts at zero."""
        return np.zeros(self.memory)

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        p, error = x.parameters, x.q_ref - x.q
        tau = p["Kp"] * error + x.memory - p["Kd"] * speed_error(x, self.law.velocity_error)
        if self.has_gravity:
            tau = tau + model.gravity(x.q)
        within = casadi.fmax(casadi.fmin(tau, p["law_effort"]), -p["law_effort"])
        return tau, x.memory + x.h * (p["Ki"] * error + (within - tau) / p["tracking_time"])

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        v = values
        model = dynamics_of(arm) if self.has_gravity else None
        return PID(
            v["Kp"], v["Kd"], v["law_effort"], v["Ki"], model, self.law.velocity_error,
            tracking_time=v["tracking_time"],
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class InverseDynamicsForm:
    """tau = B y + C dq [+ g], y = Kp (q_ref - q) + Kd (dq_ref - dq) [+ ddq_ref]."""

    law: InverseDynamics
    takes = InverseDynamics
    name = InverseDynamics.name
    memory = 0

    @classmethod
    def of(cls, law: InverseDynamics, arm: Arm) -> "InverseDynamicsForm":
        """The form of a controller."""
        return cls(law)

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """Kp [1/s^2], Kd [1/s]."""
        return {"Kp": self.law.Kp.shape, "Kd": self.law.Kd.shape}

    @property
    def digest(self) -> str:
        """The variant."""
        return f"{self.name} feedforward={self.law.feedforward} gravity={self.law.gravity}"

    def values(self) -> Mapping[str, Array]:
        """The controller's gains."""
        return {"Kp": self.law.Kp, "Kd": self.law.Kd}

    def start(self) -> Array:
        """No memory."""
        return np.zeros(0)

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        y = x.parameters["Kp"] * (x.q_ref - x.q) + x.parameters["Kd"] * (x.dq_ref - x.dq)
        if self.law.feedforward:
            y = y + x.ddq_ref
        return model.inverse_dynamics(x.q, x.dq, y, gravity=self.law.gravity), NOTHING

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        law: Any = self.law
        return InverseDynamics(dynamics_of(arm), values["Kp"], values["Kd"], law.feedforward, law.gravity)


@dataclass(frozen=True, slots=True, eq=False)
class MotorSidePDForm:
    """The law of `control.laws.motor_side` as it acts on rigid joints: no spring, no torque feedback."""

    law: MotorSidePD
    takes = MotorSidePD
    name = MotorSidePD.name
    memory = 0

    @classmethod
    def of(cls, law: MotorSidePD, arm: Arm) -> "MotorSidePDForm":
        """The form of a controller."""
        return cls(law)

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """Kp [N m/rad], Kd [N m s/rad]."""
        return {"Kp": self.law.Kp.shape, "Kd": self.law.Kd.shape}

    @property
    def digest(self) -> str:
        """The variant."""
        return f"{self.name} feedforward={self.law.feedforward}"

    def values(self) -> Mapping[str, Array]:
        """The controller's gains."""
        return {"Kp": self.law.Kp, "Kd": self.law.Kd}

    def start(self) -> Array:
        """No memory."""
        return np.zeros(0)

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        p = x.parameters
        if self.law.feedforward:
            carried = model.inverse_dynamics(x.q_ref, x.dq_ref, x.ddq_ref)
        else:
            carried = model.gravity(x.q_ref)
        return carried + p["Kp"] * (x.q_ref - x.q) + p["Kd"] * (x.dq_ref - x.dq), NOTHING

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        law = self.law
        return MotorSidePD(
            dynamics_of(arm), values["Kp"], values["Kd"], law.stiffness, law.rotor, law.feedforward, law.lighter
        )
