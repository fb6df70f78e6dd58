"""A program's run on the model: a movement with times, a table of its motions, speeds, torques, a Run to replay."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.errors import LwrDynError
from lwr_dyn.kinematics.kuka_pose import KukaPose, kuka_pose
from lwr_dyn.krl.diagnosis import Diagnosis
from lwr_dyn.krl.machine import Machine
from lwr_dyn.krl.motions import Done
from lwr_dyn.krl.program import Program
from lwr_dyn.krl.settings import INTERPOLATION, Settings
from lwr_dyn.krl.statics import static_diagnoses
from lwr_dyn.krl.timeline import Timeline
from lwr_dyn.krl.values import HaltError, Value
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Event, Motion, Run
from lwr_dyn.simulation.record import origin

OVER = 1e-6
"""How far, relative, an axis may be over its speed: rounding."""


class ProgramError(LwrDynError, RuntimeError):
    """A KRL program cannot start or continue: the `place`, a `code`, the `message` and a `hint`."""

    def __init__(self, place: str, code: str, message: str, hint: str) -> None:
        super().__init__(f"{place}: {message}" + (f"; {hint}" if hint else ""))
        self.place, self.code, self.message, self.hint = place, code, message, hint


@dataclass(frozen=True, slots=True, eq=False)
class ProgramRun:
    """What a program did: `timeline` can be asked at any time, `motion` holds it at the interpolation cycle."""

    program: str
    arm: Arm
    settings: Settings
    timeline: Timeline
    motion: Motion
    done: tuple[Done, ...]
    found: tuple[Diagnosis, ...]
    """Warnings and notes of the run; a bound that was reached; axes over their speed."""
    static_torque: Array
    """What holds the arm at each time (k, n) [N m]."""
    torque: Array
    """What moves it (k, n) [N m]; masses of the KR 30 HA are estimated, so these are too."""

    @property
    def cycle_time(self) -> float:
        """[s]"""
        return self.timeline.duration

    @property
    def peak_speeds(self) -> Array:
        """Of each axis (n,) [rad/s]."""
        return np.asarray(np.abs(self.motion.dq).max(axis=0))

    def poses(self) -> tuple[KukaPose, ...]:
        """The flange where each motion ends, with Status and Turn."""
        return tuple(kuka_pose(self.arm, done.q) for done in self.done)

    def to_run(self) -> Run:
        """As a run that `lwr-dyn replay` shows: the axes are where the program puts them."""
        m, arm = self.motion, self.arm
        zero = np.zeros_like(m.q)
        energy = mechanical_energy(dynamics_of(arm), m.q, m.dq)
        power = np.sum(self.torque * m.dq, axis=1)
        work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(m.t))])
        meta: dict[str, Any] = {
            **origin(arm), "task": f"KRL program {self.program}", "controller": {"name": f"KRL {self.program}"},
            "assumed": self.settings.to_json(), "diagnoses": [d.to_json() for d in self.found],
        }  # fmt: skip
        events = tuple(Event(done.begin, f"line {done.place.line}: {done.kind}") for done in self.done)
        return Run(
            t=m.t, q=m.q, dq=m.dq, q_ref=m.q, dq_ref=m.dq, tau_command=self.torque, tau_applied=self.torque,
            tau_friction=zero, energy=energy, work={"actuator": work}, events=events, meta=meta,
        )  # fmt: skip


def run_program(
    program: Program, arm: Arm, settings: Settings | None = None, given: Mapping[str, Value] | None = None
) -> ProgramRun:
    """Carry a program out on an arm.

    Parameters
    ----------
    program : Program
    arm : Arm
        With KUKA's axes, axis speeds and masses.
    settings : Settings, optional
        Assumed machine data, bounds of steps and time.
    given : mapping, optional
        Inputs and variables the world sets: `$IN[3]` -> value.

    Raises
    ------
    ProgramError
        The program has an error, before or during its run; says where.
    OptionError, MissingDataError
        The arm has no KUKA axes, no axis speeds or no masses.
    """
    used = settings or Settings()
    _refuse([*program.found, *static_diagnoses(program)])
    arm.require_dynamics()
    machine = Machine(program, arm, used, given or {})
    found = machine.run()
    _refuse(found)
    timeline = machine.motions.timeline
    if not timeline.entries:
        hint = "a program with a PTP, LIN or CIRC"
        raise ProgramError(str(machine.findings.place), "no-motion", "the program moves nothing", hint)
    try:
        motion = timeline.sample(_times(timeline))
    except HaltError as fault:
        raise ProgramError(str(machine.findings.place), fault.code, fault.message, fault.hint) from None
    model = dynamics_of(arm)
    return ProgramRun(
        program=program.source.name, arm=arm, settings=used, timeline=timeline, motion=motion,
        done=tuple(machine.motions.done), found=(*found, *_too_fast(arm, motion, machine.motions.done)),
        static_torque=model.gravity_vector(motion.q), torque=model.inverse_dynamics(motion.q, motion.dq, motion.ddq),
    )  # fmt: skip


def _refuse(found: tuple[Diagnosis, ...] | list[Diagnosis]) -> None:
    error = next((d for d in found if d.severity == "error"), None)
    if error is not None:
        raise ProgramError(str(error.place), error.code, error.message, error.hint)


def _times(timeline: Timeline) -> Array:
    """The interpolation cycle, and each moment at which a motion begins or ends."""
    count = int(np.ceil(timeline.duration / INTERPOLATION))
    cycle = np.minimum(np.arange(count + 1) * INTERPOLATION, timeline.duration)
    marks = [x for entry in timeline.entries for x in (entry.begin, entry.end)]
    times = np.unique(np.concatenate([cycle, marks]))
    # two marks that are one up to rounding are one
    return np.asarray(times[np.concatenate([[True], np.diff(times) > 1e-9])])


def _too_fast(arm: Arm, motion: Motion, done: list[Done]) -> list[Diagnosis]:
    found = []
    use = np.abs(motion.dq) / arm.velocity
    for one in done:
        rows = (motion.t >= one.begin) & (motion.t <= one.end)
        if not rows.any():
            continue
        part = use[rows]
        k, i = np.unravel_index(int(np.argmax(part)), part.shape)
        if part[k, i] > 1.0 + OVER:
            name = arm.joint_names[int(i)]
            message = f"{name} turns at {100 * part[k, i]:.4g} % of its speed"
            found.append(Diagnosis(one.place, "error", "axis-speed", message, "a lower velocity, or no blend"))
    return found
