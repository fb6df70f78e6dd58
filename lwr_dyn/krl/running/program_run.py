"""Checks a program, and runs it on a robot's model: motions in time, speeds, poses, torques, and a Run to replay."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.krl.checks.static_checks import static_diagnostics
from lwr_dyn.krl.diagnostics import (
    Diagnostic,
    ExecutionError,
    ResumedError,
    RunEndedError,
    SourcePosition,
    sorted_diagnostics,
)
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.motion.cycle_times import CycleTimes, cycle_times, pass_times
from lwr_dyn.krl.motion.timeline import Timeline
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.robot.kuka_pose import KukaPose, kuka_pose, pose_of_matrix
from lwr_dyn.krl.running.background import give_arguments, give_cell, note_unread, settle_rest, watch_for_replies
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.controller import Assumption, MachineData
from lwr_dyn.krl.running.execute import end_at_bound, start_submits, step
from lwr_dyn.krl.running.functions import called_routine, empty_value, value_of_call
from lwr_dyn.krl.running.motions import ExecutedMotion
from lwr_dyn.krl.running.running_program import LoopPasses, RunningProgram
from lwr_dyn.krl.running.triggers import ProgramEvent
from lwr_dyn.krl.running.values import Value
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
        """The flange in the world at the end of each motion, with Status and Turn."""
        return tuple(kuka_pose(self.arm, motion.q) for motion in self.executed)

    def tcp_poses(self) -> tuple[KukaPose, ...]:
        """The tool centre point in the active base at the end of each motion, as the pendant shows it."""
        return tuple(
            replace(pose_of_matrix(x.tcp), s=p.s, t=p.t) for x, p in zip(self.executed, self.poses(), strict=True)
        )

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
            "assumptions": [asdict(x) for x in self.assumptions],
            "diagnoses": [d.to_json() for d in self.diagnostics],
            **({} if known else {"unknown": ["torques", "energy", "work"]}),
        }  # fmt: skip
        events = tuple(Event(x.begin, f"line {x.position.line}: {x.kind}") for x in self.executed)
        return Run(
            t=m.t, q=m.q, dq=m.dq, q_ref=m.q, dq_ref=m.dq, tau_command=torque, tau_applied=torque,
            tau_friction=zero, energy=energy, work={"actuator": work}, events=events, meta=meta,
        )  # fmt: skip


INTERPOLATION = 0.012
"""[s] KUKA's interpolation cycle: the sampling period of a run."""
OVER = 1e-6
"""Relative excess of an axis speed that is rounding."""


def sample_times(timeline: Timeline, longest: float) -> Array:
    """The interpolation cycle, and each time at which a motion begins or ends, up to `longest` [s]."""
    end = min(timeline.duration, longest)
    cycle = np.minimum(np.arange(int(np.ceil(end / INTERPOLATION)) + 1) * INTERPOLATION, end)
    marks = [x for item in timeline.items for x in (item.begin, item.end) if x <= end]
    times = np.unique(np.concatenate([cycle, marks]))
    # times that are equal up to rounding count once
    return np.asarray(times[np.concatenate([[True], np.diff(times) > 1e-9])])


def overspeed(arm: Arm, motion: Motion, executed: Sequence[ExecutedMotion]) -> list[Diagnostic]:
    """An error for each motion in which an axis is over its rated speed."""
    diagnostics = []
    use = np.abs(motion.dq) / arm.velocity
    for x in executed:
        part = use[(motion.t >= x.begin) & (motion.t <= x.end)]
        if not part.size:
            continue
        k, i = np.unravel_index(int(np.argmax(part)), part.shape)
        if part[k, i] > 1.0 + OVER:
            message = f"{arm.joint_names[int(i)]} turns at {100 * part[k, i]:.4g} % of its speed"
            diagnostics.append(Diagnostic(x.position, "error", "axis-speed", message, "a lower velocity, or no blend"))
    return diagnostics


CHECKED_MOTIONS = 1000
"""Motions of a program that a check plans at most; a run plans all."""

UNREADABLE = frozenset({
    "syntax", "unknown-keyword", "open-bracket", "open-string", "bad-literal", "bad-character", "long-line",
    "missing-end", "stray-end", "wrong-end", "missing-def", "outside-routine", "encoding", "deep-nesting",
})  # fmt: skip
"""After one of these errors it is not clear what would run, so a check does not plan motions."""


class ProgramError(LwrDynError, RuntimeError):
    """A KRL program cannot start or continue: the `position`, a `code`, the `message` and a `hint`."""

    def __init__(self, position: str, code: str, message: str, hint: str) -> None:
        super().__init__(f"{position}: {message}" + (f"; {hint}" if hint else ""))
        self.position, self.code, self.message, self.hint = position, code, message, hint


def check_program(
    program: Program,
    arm: Arm | None = None,
    machine: MachineData | None = None,
    inputs: Mapping[str, Value] | None = None,
    cell: RobotCell | None = None,
) -> tuple[Diagnostic, ...]:
    """All diagnostics of a program, in order of position.

    Parameters
    ----------
    program : Program
    arm : Arm, optional
        Plans the motions on this arm; without it only language and types are checked.
    machine : MachineData, optional
    inputs : mapping, optional
        Inputs and variables set from outside: `$IN[3]` -> value.
    cell : RobotCell, optional
        What stands around the program: states, stubs, tools ...; see `with_cell` for its names.

    Raises
    ------
    OptionError, MissingDataError
        The arm has no KUKA axes, or no axis speeds.

    >>> from lwr_dyn.krl.project.program import parse_program
    >>> for d in check_program(parse_program("DEF a( )\\nWAIT SEC x\\nEND\\n", name="a")): print(d)
    a.src:2:10: error undeclared: x is not declared (declare it in the .dat or with DECL; no .dat is there)
    """
    static = [*program.diagnostics, *static_diagnostics(program)]
    if arm is None or any(d.severity == "error" and d.code in UNREADABLE for d in static):
        return sorted_diagnostics(static)
    data = machine or MachineData()
    data = replace(data, motions=min(CHECKED_MOTIONS, data.motions))
    known = set(map(_place, static))
    of_run = interpreted(program, arm, data, _surroundings(cell, inputs), tolerant=True).log.diagnostics
    return sorted_diagnostics([*static, *(d for d in of_run if _place(d) not in known)])


def run_program(
    program: Program,
    arm: Arm,
    machine: MachineData | None = None,
    inputs: Mapping[str, Value] | None = None,
    cell: RobotCell | None = None,
) -> ProgramRun:
    """Run a program on an arm.

    Parameters
    ----------
    program : Program
    arm : Arm
        With KUKA's axes and axis speeds; without masses the run has no torques.
    machine : MachineData, optional
        Assumed machine data, bounds of steps and time.
    inputs : mapping, optional
        Inputs and variables set from outside: `$IN[3]` -> value.
    cell : RobotCell, optional
        What stands around the program: states, stubs, tools ...; see `with_cell` for its names.

    Raises
    ------
    ProgramError
        The program cannot be read, or comes to an error. Errors in statements it does not come to are diagnoses of
        the run, as a controller would refuse to start it.
    OptionError, MissingDataError
        The arm has no KUKA axes, or no axis speeds.
    """
    data = machine or MachineData()
    static = [*program.diagnostics, *static_diagnostics(program)]
    # what unknown subprograms there are, the run itself notes where it comes to one
    errors = sorted_diagnostics(d for d in static if d.severity == "error" and d.code != "unknown-call")
    _refuse_errors([d for d in static if d.code in UNREADABLE])
    m = interpreted(program, arm, data, _surroundings(cell, inputs))
    diagnostics, end = m.log.diagnostics, str(m.log.position)
    timeline, executed = m.motions.timeline, m.motions.executed
    # of one fault in one line, what the checks say stands in place of what the run says
    checked = {_place(d): d for d in static if d.severity == "error"}
    _refuse_errors([checked.get(_place(d), d) for d in diagnostics])
    if not executed:
        _refuse_errors([replace(d, severity="error") for d in diagnostics if d.code == "endless"])
        raise ProgramError(end, "no-motion", "the program moves nothing", "a program with a PTP, LIN or CIRC")
    try:
        motion = timeline.sample(sample_times(timeline, data.seconds))
    except ExecutionError as fault:
        raise ProgramError(end, fault.code, fault.message, fault.hint) from None
    held, torque = _torques(arm, motion)
    return ProgramRun(
        program=program.source.name, arm=arm, machine=data, timeline=timeline, motion=motion,
        executed=tuple(executed), still=tuple(m.motions.still),
        diagnostics=(*errors, *diagnostics, *overspeed(arm, motion, executed)),
        assumptions=tuple(m.controller.assumptions.values()),
        events=tuple(sorted(m.clock.events, key=lambda x: x.time)), passes=m.passes,
        static_torque=held, torque=torque,
    )  # fmt: skip


def interpreted(
    program: Program, arm: Arm, machine: MachineData, cell: RobotCell | None = None, tolerant: bool = False
) -> RunningProgram:
    """A program executed to its end, or to the fault or bound that ends it; `log` has its diagnostics.

    With `tolerant` a faulty statement is skipped and the run goes on.
    """
    m = RunningProgram(program, arm, machine, cell, tolerant, _evaluate_call)
    try:
        _execute(m)
    except RunEndedError as end:
        if end.diagnostic is not None:
            m.log.diagnostics.append(end.diagnostic)
    except RecursionError:
        deep = ("recursion", "functions call one another without end", "use a loop")
        m.log.diagnostics.append(Diagnostic(m.log.position, "error", *deep))
    note_unread(m.controller)
    return m


def _execute(m: RunningProgram) -> None:
    """Execute the main routine to its end; raises `RunEndedError` at the fault or bound that ends it before."""
    for file in m.program.module.files:
        m.variables_of(file.file.name)
    give_cell(m)
    start_submits(m)
    watch_for_replies(m)
    if m.program.routines:
        m.enter(m.program.routines[0])
        give_arguments(m)
    while m.stack:
        try:
            step(m)
        except ResumedError:
            continue
    settle_rest(m)
    if m.motions.now > m.machine.seconds:
        end_at_bound(m, f"{m.machine.seconds:g} s of simulated time")


def _evaluate_call(m: RunningProgram, x: e.FunctionCall) -> Value:
    """The value of a call in an expression; a function of the program is executed to its end."""
    routine = called_routine(m, x.name.upper())
    if routine is None:
        value = value_of_call(m, x)
        if value is None and (value := empty_value(m, x)) is None:
            hint = "define it in the program, or give it a stub in the cell file"
            raise ExecutionError("not-modelled", f"the function {x.name} is not modelled", hint)
        return value
    depth, position = len(m.stack), m.log.position
    m.enter(routine, x.arguments)
    result: list[Value] = []
    while len(m.stack) > depth:
        step(m, result)
    m.log.position = position  # the statement that calls goes on
    if not result:
        raise ExecutionError("no-value", f"{x.name} ended without RETURN", "RETURN a value on every way")
    return result[-1]


def _torques(arm: Arm, motion: Motion) -> tuple[Array | None, Array | None]:
    """The torques that hold and move the arm; None where its masses are unknown."""
    if arm.chain.bodies is None:
        return None, None
    model = dynamics_of(arm)
    return model.gravity_vector(motion.q), model.inverse_dynamics(motion.q, motion.dq, motion.ddq)


def _surroundings(cell: RobotCell | None, inputs: Mapping[str, Value] | None) -> RobotCell:
    """The cell with inputs and variables that are given one by one."""
    whole = cell or RobotCell()
    return replace(whole, values={**whole.values, **(inputs or {})})


def _place(d: Diagnostic) -> tuple[str, int, str]:
    return d.position.file, d.position.line, d.code


def _refuse_errors(diagnostics: Sequence[Diagnostic]) -> None:
    error = next((d for d in diagnostics if d.severity == "error"), None)
    if error is not None:
        raise ProgramError(str(error.position), error.code, error.message, error.hint)
