"""Checks a program, and runs it on a robot's model: motions in time, speeds, torques, and a Run to replay."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.krl.checks.static_checks import static_diagnostics
from lwr_dyn.krl.diagnostics import Diagnostic, ExecutionError, sorted_diagnostics
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.running.cell import RobotCell
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.interpreter import Interpreter
from lwr_dyn.krl.running.program_run import ProgramRun
from lwr_dyn.krl.running.sampling import overspeed, sample_times
from lwr_dyn.krl.running.values import Value
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion

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
    known = {(d.position.file, d.position.line, d.code) for d in static}
    of_run = Interpreter(program, arm, data, _surroundings(cell, inputs), tolerant=True).run()
    return sorted_diagnostics(
        [*static, *(d for d in of_run if (d.position.file, d.position.line, d.code) not in known)]
    )


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
    _refuse_errors([d for d in static if d.code in UNREADABLE])
    interpreter = Interpreter(program, arm, data, _surroundings(cell, inputs))
    diagnostics = interpreter.run()
    _refuse_errors(_as_checked(diagnostics, static))
    timeline, executed, end = interpreter.motions.timeline, interpreter.motions.executed, str(interpreter.log.position)
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
        executed=tuple(executed), still=tuple(interpreter.motions.still),
        diagnostics=(*_only_errors(static), *diagnostics, *overspeed(arm, motion, executed)),
        assumptions=interpreter.controller.assumptions.all(),
        events=tuple(sorted(interpreter.background.clock.events, key=lambda x: x.time)), passes=interpreter.passes,
        static_torque=held, torque=torque,
    )  # fmt: skip


def _only_errors(diagnostics: Sequence[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Those that are errors; what unknown subprograms there are, the run itself notes where it comes to one."""
    return sorted_diagnostics(d for d in diagnostics if d.severity == "error" and d.code != "unknown-call")


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


def _as_checked(diagnostics: Sequence[Diagnostic], static: Sequence[Diagnostic]) -> list[Diagnostic]:
    """What the checks say of the same fault in the same line, in place of what the run says."""
    checked = {(d.position.file, d.position.line, d.code): d for d in static}
    return [checked.get((d.position.file, d.position.line, d.code), d) for d in diagnostics]


def _refuse_errors(diagnostics: Sequence[Diagnostic]) -> None:
    error = next((d for d in diagnostics if d.severity == "error"), None)
    if error is not None:
        raise ProgramError(str(error.position), error.code, error.message, error.hint)
