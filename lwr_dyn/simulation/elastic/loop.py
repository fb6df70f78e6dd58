"""What the sampled loop of rigid joints needs for elastic ones: its fast step, its flow of events, and its controller.

The loop itself is that of `lwr_dyn.simulation`: it moves 2n coordinates (q, theta) under torques (0, tau).
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.control.protocol import Controller, JointReadings, WithJointSensors, joint_torque
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.contact import ContactMode
from lwr_dyn.simulation.elastic.dynamics import ElasticDynamics
from lwr_dyn.simulation.elastic.exponential import HeldExponential
from lwr_dyn.simulation.fast_step import FastStep
from lwr_dyn.simulation.flow import Drive, Flow
from lwr_dyn.simulation.record import Log


@dataclass(slots=True, eq=False)
class ElasticFlow(Flow):
    """A flow that also sums the work of the dampers, step by step [J]."""

    damped: list[float] = field(default_factory=list)

    def advance(self, drive: Drive, t: float, y: Array, h: float) -> Array:
        """y(t + h), with every event in between."""
        model: Any = self.plant.dynamics

        def with_dampers(t: float, x: Array, dx: Array, memory: Array) -> tuple[Array, Array]:
            return drive(t, x, dx, memory)[0], model.damper_power(dx)[None]

        after = Flow.advance(self, with_dampers, t, np.append(y, 0.0), h)
        self.damped.append(float(after[-1]))
        return after[:-1]


class ElasticStep(FastStep):
    """The usual step by the exponential of the linearised motion.

    Where a link rests, or a motor of the full model, `Flow` takes it.
    """

    def take(self, t: float, now: Array, tau: Array, after: Array) -> bool:
        """As `FastStep.take`; the work of the dampers goes to the flow."""
        flow: Any = self._flow
        n = flow.plant.arm.n
        resting = flow.mode.at_rest if flow.plant.model.rotors == "full" else flow.mode.at_rest[:n]
        if resting.any() or not FastStep.take(self, t, now, tau, after):
            return False
        flow.damped.append(self._held.damped)
        return True

    def _adopt(self, mode: ContactMode) -> None:
        FastStep._adopt(self, mode)
        model: Any = mode.plant.dynamics
        held = self._held = HeldExponential(model, mode, self._h, self._substeps, self._flow.external)
        self._step, self._tangent = held.step, held.slowest


class OneSide:
    """A controller of n joints on 2n coordinates: it is given one side's positions, and senses both."""

    def __init__(self, controller: Controller, model: ElasticDynamics, encoders: str, log: Log) -> None:
        n = model.joints
        self._controller, self._model, self._log = controller, model, log
        self._side = slice(n, None) if encoders == "motor" else slice(0, n)
        self._sense = controller.sense if isinstance(controller, WithJointSensors) else None

    def __call__(self, t: float, x: Array, dx: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """(0, tau), (2n,)."""
        n, k = self._model.joints, self._log.done
        name = f"torque of the controller at sample {k}"
        if self._sense is not None:
            torque = self._model.gear_torque(*self._log.states[k])
            self._sense(JointReadings(x[n:], dx[n:], x[:n], dx[:n], torque))
        out = np.zeros(2 * n)
        out[n:] = joint_torque(name, self._controller(t, x[self._side], dx[self._side], q_ref, dq_ref, ddq_ref), n)
        return out

    def __getattr__(self, name: str) -> Any:
        """The `signals` of the controller, if it has any; what else it has is not for the loop."""
        if name != "signals":
            raise AttributeError(name)
        return self._controller.signals  # type: ignore[attr-defined] # raises where there are none
