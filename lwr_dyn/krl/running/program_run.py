"""A run of a program: its motions and how they are sampled, its times, poses and torques."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from lwr_dyn.krl.motion.cycle_times import CycleTimes, cycle_times, pass_times
from lwr_dyn.krl.motion.timeline import Timeline
from lwr_dyn.krl.robot.kuka_pose import KukaPose, kuka_pose
from lwr_dyn.krl.running.assumptions import Assumption
from lwr_dyn.krl.running.clock import ProgramEvent
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.motions import ExecutedMotion
from lwr_dyn.krl.running.passes import LoopPasses
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Event, Motion, Run
from lwr_dyn.simulation.setup import arm_record

LOST = ("endless", "warning")
"""Code and severity of the diagnosis of a loop that only watches, for ever."""


@dataclass(frozen=True, slots=True, eq=False)
class ProgramRun:
    """A run: `timeline` gives the motion at any time, `motion` at the interpolation cycle."""

    program: str
    arm: Arm
    machine: MachineData
    timeline: Timeline
    motion: Motion
    executed: tuple[ExecutedMotion, ...]
    still: tuple[SourcePosition, ...]
    """Statements of motions to where the arm stood, which have no row."""
    diagnostics: tuple[Diagnostic, ...]
    """Warnings and notes of the run; a bound that was reached; axes over their speed."""
    assumptions: tuple[Assumption, ...]
    """Values and rules that neither the program nor its files give."""
    events: tuple[ProgramEvent, ...]
    """Outputs, triggers, interrupts, answers of the cell, in order of time."""
    passes: LoopPasses | None
    """Of the endless loop at which the run has ended."""
    static_torque: Array | None
    """(k, n) [N m] The torque that holds the arm; None where masses are unknown."""
    torque: Array | None
    """(k, n) [N m] The torque of the motion; masses of the KR 30 HA are estimated, so this is too."""

    @property
    def duration(self) -> float:
        """[s] Of all that was simulated."""
        return float(self.motion.t[-1])

    @property
    def cut(self) -> Diagnostic | None:
        """Why it ended before the program did: a bound, or a loop that only watches; None where it was not cut."""
        return next((d for d in self.diagnostics if d.code == "bound" or (d.code, d.severity) == LOST), None)

    @property
    def cycle_time(self) -> float | None:
        """[s] Of a pass of the endless loop at which it ended, else of the whole program; None where it is cut."""
        if self.cut is not None:
            return None
        return self.duration if self.passes is None else self.passes.cycle_time

    def times(self) -> CycleTimes:
        """The duration by three laws of look-ahead; `duration` and `motion` are by the first, overlap."""
        return cycle_times(self.timeline)

    def pass_times(self) -> CycleTimes | None:
        """One pass of the endless loop at which it ended by the same laws; None without one."""
        x = self.passes
        return None if x is None else pass_times(self.timeline, x.cycle_time * x.counted, x.counted)

    @property
    def peak_speeds(self) -> Array:
        """Of each axis (n,) [rad/s]."""
        return np.asarray(np.abs(self.motion.dq).max(axis=0))

    def poses(self) -> tuple[KukaPose, ...]:
        """The flange at the end of each motion, with Status and Turn."""
        return tuple(kuka_pose(self.arm, motion.q) for motion in self.executed)

    def to_run(self) -> Run:
        """As a `Run` for `lwr-dyn replay`, in which the axes follow the program exactly.

        Where masses are unknown its torques and energy are zeros, and `meta["unknown"]` names them.
        """
        m, arm = self.motion, self.arm
        zero, known = np.zeros_like(m.q), self.torque is not None
        torque = zero if self.torque is None else self.torque
        energy = mechanical_energy(dynamics_of(arm), m.q, m.dq) if known else zero[:, 0]
        power = np.sum(torque * m.dq, axis=1)
        work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(m.t))])
        meta: dict[str, Any] = {
            **arm_record(arm), "task": f"KRL program {self.program}", "controller": {"name": f"KRL {self.program}"},
            "assumed": self.machine.to_json(),
            "assumptions": [x.to_json() for x in self.assumptions],
            "diagnoses": [d.to_json() for d in self.diagnostics],
            **({} if known else {"unknown": ["torques", "energy", "work"]}),
        }  # fmt: skip
        events = tuple(Event(x.begin, f"line {x.position.line}: {x.kind}") for x in self.executed)
        return Run(
            t=m.t, q=m.q, dq=m.dq, q_ref=m.q, dq_ref=m.dq, tau_command=torque, tau_applied=torque,
            tau_friction=zero, energy=energy, work={"actuator": work}, events=events, meta=meta,
        )  # fmt: skip
