"""The loop "compiled" of `simulate`: one run as a scalar kernel that keeps every sample, with record and audit.

It repeats the usual loop of rigid joints to rounding; what it lacks (stops, true stick, ...) it refuses by name, before
the run or where the run comes to it. Two loops cannot agree for long where rounding grows: in a free swing, and under
an encoder with a resolution, which leaves the arm alone between two counts.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel import address, require_packages
from lwr_dyn.codegen.kernels.kernel_spec import friction_table
from lwr_dyn.codegen.rollouts.kernel import PlanLoop, loop_of, plan_code
from lwr_dyn.codegen.rollouts.law_forms import LawForm, NoKernelFormError, law_form
from lwr_dyn.codegen.rollouts.loop_setup import joint_rows
from lwr_dyn.codegen.rollouts.step import GAIN, MOST_DELAY, WHOLE, Slots, StepPlan
from lwr_dyn.codegen.rollouts.symbolic_arm import LARGEST
from lwr_dyn.control.protocol import label_of
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, RatingWarning
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED, Mask
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.loops import Log, Progress, run_of
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Setup

USUAL, STICK = "the usual loop (the default)", "true stick (friction set-valued)"

SAME = 1e-9
"""Share of the largest torque by which the plant's engine may differ from the plant with rotors as armature."""


def check_setup(setup: Setup) -> None:
    """Raise `OptionError` for what the loop does not have, and name it."""
    loop, friction = setup.loop, setup.plant.friction.form
    own_encoder = loop.encoder is not None and type(loop.encoder).sensor is not Encoder.sensor
    lacking = {
        "elastic joints": setup.elasticity is not None, "external torques": loop.external is not None,
        "a controller at every moment": loop.continuous, f"method {loop.method}": loop.method != "rk4",
        STICK: friction == "set-valued", "friction by a function": friction == "given",
        f"a delay of {loop.delay} samples (at most {MOST_DELAY})": loop.delay > MOST_DELAY,
        "an encoder with a sensor of its own": own_encoder,
    }  # fmt: skip
    for what in (name for name, is_asked in lacking.items() if is_asked):
        smooth = "friction smooth or none, or " if what == STICK else ""
        raise OptionError("loop", f"compiled, which does not have {what}", smooth + USUAL)
    _check_engine(setup)


def _check_engine(setup: Setup) -> None:
    """Raise `OptionError` where the plant's engine is not of the plant with rotors as armature."""
    plant, state = setup.plant, (*setup.start, np.ones(setup.plant.n))
    own = plant.ungated.inverse_dynamics(*state)
    other = ungated(dynamics_of(plant.arm)).inverse_dynamics(*state)
    if not np.abs(own - other).max() <= SAME * max(1.0, float(np.abs(other).max())):
        fault = "compiled, which does not have an engine other than that of the plant with rotors as armature"
        raise OptionError("loop", fault, USUAL)


_FOLDS = 64


def _extremes(states: Array) -> Array:
    """The least and the largest of each column, (2, 2, n) of (k, 2, n), NaN where one is NaN.

    Rows are laid side by side first: NumPy takes long for many short rows.
    """
    rows = states.reshape(len(states), -1)
    folded = len(rows) // _FOLDS * _FOLDS
    out = []
    for most in (np.minimum, np.maximum):
        first = most.reduce(rows[:folded].reshape(_FOLDS, -1)).reshape(-1, rows.shape[1])
        out.append(most.reduce(np.concatenate([first, rows[folded:]])))
    return np.reshape(out, (2, *states.shape[1:]))


def _ends(setup: Setup, states: Array, commands: Mask | np.bool_) -> Mask:
    """Where joints cannot be followed, and where they are past a limit, (2, k, n), of states (k, 2, n).

    `commands` (k, n) says which are numbers.
    """
    step = 1.0 / (setup.loop.rate * setup.loop.substeps)
    most = (sincos("float64").most_half_turns - 1) * np.pi
    q, dq = np.moveaxis(states, 1, 0)
    with np.errstate(invalid="ignore"):
        followed = (np.abs(dq) * step <= LARGEST) & (np.abs(q) <= most) & commands
    return np.stack([~followed, setup.plant.beyond(q)])


def refuse_ends(setup: Setup, log: Log) -> None:
    """Raise `OptionError` where a joint came to its stop, or the kernel could not follow the motion; with the time."""
    commands = np.isfinite(log.command)
    if not _ends(setup, _extremes(log.states), np.all(commands, keepdims=True)).any():
        return
    lost, beyond = _ends(setup, log.states, commands)
    rows = np.flatnonzero((lost | beyond).any(axis=1))
    k = int(rows[0])
    joint = setup.plant.arm.joint_names[int(np.flatnonzero((lost | beyond)[k])[0])]
    if lost[k].any():
        fault = f"compiled, which cannot follow {joint} at {log.t[k]:.6g} s: above {LARGEST:g} rad a step, or no number"
        raise OptionError("loop", fault, f"a higher rate or more substeps, or {USUAL}")
    fault = f"compiled, which has no stops, and {joint} reaches its own before {log.t[k]:.6g} s"
    raise OptionError("loop", fault, f"position_limits=False, or {USUAL}")


INPUTS = ("common", "reference")

BEFORE = {"states": ("q", "dq"), "memory": ("memory",)}
AFTER = {name: (name,) for name in WHOLE}
"""What is kept of a sample, in this order, and the slots that it is read from, which are neighbours: before the step,
and what the step made of it."""


def kept_widths(slots: Slots) -> dict[str, int]:
    """How many numbers of a sample are kept under each name; each name has a table of its own, one after the other."""
    return {name: sum(slots.widths[slot] for slot in names) for name, names in (BEFORE | AFTER).items()}


_KEPT = """
/* copies from the block to the row of a sample in each table */
static void {name}(const double *b, double *out, int samples, int sample)
{{{lines}
}}
"""

_COPY = """
    for (int j = 0; j < {width}; j++) {{
        out[{before} * samples + {width} * sample + j] = b[{slot} + j];
    }}"""


def whole_loop(plan: StepPlan) -> PlanLoop:
    """The loop of one run of a plan with `whole`."""
    kept = _kept("before", plan.slots, BEFORE) + _kept("after", plan.slots, AFTER)
    text = (files("lwr_dyn.codegen.rollouts") / "compiled_loop.c").read_text(encoding="utf-8")
    return loop_of(plan, kept + text, "run", 1, {"SAMPLE": plan.slots.first("sample")})


def _kept(name: str, slots: Slots, tables: Mapping[str, tuple[str, ...]]) -> str:
    """A function that copies what is kept in these tables."""
    lines, before = [], 0
    for table, width in kept_widths(slots).items():
        if table in tables and width:
            lines.append(_COPY.format(width=width, before=before, slot=slots.first(tables[table][0])))
        before += width
    return _KEPT.format(name=name, lines="".join(lines))


REPORTS = 100


@dataclass(frozen=True, slots=True, eq=False)
class WholeKernel:
    """The machine code of one plan, for one run at a time."""

    slots: Slots
    code: Any

    def run(self, common: Array, reference: Array, report: Callable[[float], None] | None = None) -> dict[str, Array]:
        """What is kept of each sample, by name: (samples, width) each.

        Parameters
        ----------
        common : (slots,) array
            The numbers of the run, its first state among them.
        reference : (samples, width) array
            As `kernel.row_width` says.
        report : callable, optional
            Called with the share that is done, about a hundred times.
        """
        widths, samples = kept_widths(self.slots), len(reference)
        out = np.empty(samples * sum(widths.values()))
        block = np.empty(self.slots.size + 1)
        size = samples if report is None else max(1, samples // REPORTS)
        arguments = [address(common), 0, address(reference), samples, address(out), address(block)]
        for first in range(0, samples, size):
            last = min(first + size, samples)
            self.code.call(*arguments, first, last)
            if report is not None:
                report(last / samples)
        tables = np.split(out, samples * np.cumsum(list(widths.values())))
        return {name: x.reshape(samples, width) for (name, width), x in zip(widths.items(), tables, strict=False)}


def whole_kernel(plan: StepPlan) -> WholeKernel:
    """The kernel of a plan with `whole`; raises `MissingPackageError` without the extra `batch`."""
    code = plan_code("rollout-whole", plan, "tables", lambda: whole_loop(plan), len(INPUTS))
    return WholeKernel(plan.slots, code)


def takes(setup: Setup) -> bool:
    """Whether `run_compiled` would begin the run of a setup; the controller is called, and reset after.

    Raises `MissingPackageError`: the extra `batch` is not installed.
    """
    require_packages()
    try:
        check_setup(setup)
        _, form = _arm_and_form(setup)
    except OptionError:
        return False
    return hasattr(form, "signals") or not hasattr(setup.controller, "signals")


def run_compiled(setup: Setup, progress: Progress | None = None) -> Run:
    """A run by generated code: the samples of the usual loop, to rounding.

    The controller must have a kernel form (`law_forms`) for the arm as it knows it; it is not called in the run. The
    plant's engine gives the energies of the audit, not the motion.

    Raises
    ------
    OptionError
        What the kernel does not have: see `check_setup`; signals that the law's form does not give; a joint that meets
        its stop, or a motion that cannot be followed, with the time.
    NoKernelFormError
        A controller without a kernel form.
    MissingPackageError
        The extra `batch` is not installed.
    """
    check_setup(setup)
    known, form = _arm_and_form(setup)
    plan = _plan(setup, known, form)
    kept = whole_kernel(plan).run(_common(setup, plan), _table(setup, plan), progress)
    log, flow, meta = _log(setup, kept), Flow(setup.plant, setup.loop.integrator()), setup.record()
    refuse_ends(setup, log)
    log.signals |= _signals(setup, form, kept["memory"])
    flow.evaluations = 4 * setup.loop.substeps * (log.done - 1)
    return run_of(setup, log, flow, meta)


def _arm_and_form(setup: Setup) -> tuple[Arm, LawForm]:
    """The arm that the controller knows, and its form: the setup's own arm, that with the payload, or the plant."""
    with warnings.catch_warnings(action="ignore", category=RatingWarning):  # said when the plant was made
        loaded = setup.loop.loaded(setup.arm)
    faults = []
    for arm in dict.fromkeys((setup.arm, loaded, setup.plant.arm)):
        try:
            return arm, law_form(setup.controller, arm)
        except NoKernelFormError as fault:
            faults.append(fault)
    raise faults[0]


def _plan(setup: Setup, known: Arm, form: LawForm) -> StepPlan:
    loop, encoder, friction = setup.loop, setup.loop.encoder, setup.plant.friction
    return StepPlan(
        known, setup.plant.arm, form, loop.rate, loop.substeps,
        friction_width=None if friction.form == "none" else SMOOTH_SPEED,
        pole=None if encoder is None else encoder.velocity_filter(loop.rate).pole,
        noise="none" if encoder is None or encoder.noise == 0.0 else "table", most_delay=loop.delay, whole=True,
    )  # fmt: skip


def _common(setup: Setup, plan: StepPlan) -> Array:
    """The numbers of the run, in the kernel's slots."""
    plant, encoder = setup.plant, setup.loop.encoder
    return plan.slots.filled({
        "q": setup.start[0], "dq": setup.start[1], "memory": plan.form.start(), "effort": plant.effort,
        "armature": plant.arm.armature, "lower": plant.lower, "upper": plant.upper, "delay": plan.most_delay,
        "friction": _friction(setup), "resolution": 0.0 if encoder is None else encoder.resolution, "noise": 1.0,
        "tolerance": np.inf, "last": setup.motion.t.size - 1,
    } | {GAIN + name: value for name, value in plan.form.values().items()})  # fmt: skip


def _friction(setup: Setup) -> Array:
    """The plant's friction, (5, n): the arm's own, or viscous alone."""
    friction, n = setup.plant.friction, setup.plant.n
    if friction.form == "smooth":
        return friction_table(setup.plant.arm.friction_models())
    viscous = np.zeros(n) if friction.smooth is None else friction.smooth(np.ones(n))
    return np.array([np.zeros(n), viscous, np.zeros(n), viscous, np.zeros(n)])


def _table(setup: Setup, plan: StepPlan) -> Array:
    """Rows of the reference and of noise."""
    motion, n, encoder = setup.motion, setup.plant.n, setup.loop.encoder
    if plan.noise != "table" or encoder is None:
        return joint_rows(motion)
    return np.hstack([joint_rows(motion), encoder.noise_of(motion.t.size, n, setup.loop.seed)])


def _log(setup: Setup, kept: Mapping[str, Array]) -> Log:
    samples, n = setup.motion.t.size, setup.plant.n
    friction = None if setup.plant.friction.form == "none" else kept["friction_torque"]
    works = np.zeros((samples, 2))
    if friction is not None:
        works[1:, 1] = kept["friction_work"][:-1, 0]
    return Log(
        setup.motion, kept["states"].reshape(samples, 2, n), kept["command"], kept["applied"], friction,
        np.zeros(samples), works, continuous=False, done=samples,
    )  # fmt: skip


def _signals(setup: Setup, form: LawForm, memory: Array) -> Mapping[str, Array]:
    """What the controller says of itself; raises `OptionError` where its form cannot say it."""
    if not hasattr(setup.controller, "signals"):
        return {}
    if not hasattr(form, "signals"):
        fault = f"compiled, of {label_of(setup.controller)}, whose signals its kernel form does not give"
        raise OptionError("loop", fault, USUAL)
    signals: Mapping[str, Array] = form.signals(memory)
    return signals
