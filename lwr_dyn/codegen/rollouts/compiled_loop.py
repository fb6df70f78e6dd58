"""The loop "compiled" of `simulate`: one run as a scalar kernel that keeps every sample, with record and audit.

It repeats the usual loop of rigid joints to rounding; what it lacks (stops, true stick, ...) it refuses by name, before
the run or where the run comes to it. Two loops cannot agree for long where rounding grows: in a free swing, and under
an encoder with a resolution, which leaves the arm alone between two counts.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel import address, kept_code, require_packages
from lwr_dyn.codegen.kernels.kernel_spec import friction_table
from lwr_dyn.codegen.rollouts.kernel import PlanLoop, loop_of, plan_key
from lwr_dyn.codegen.rollouts.law_forms import LawForm, NoKernelFormError, law_form
from lwr_dyn.codegen.rollouts.step import GAIN, MOST_DELAY, Slots, StepPlan
from lwr_dyn.codegen.rollouts.symbolic_arm import LARGEST
from lwr_dyn.control.protocol import label_of
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, RatingWarning
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
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


def refuse_ends(setup: Setup, log: Log) -> None:
    """Raise `OptionError` where a joint came to its stop, or the kernel could not follow the motion; with the time."""
    step = 1.0 / (setup.loop.rate * setup.loop.substeps)
    most = (sincos("float64").most_half_turns - 1) * np.pi
    q, dq = np.moveaxis(log.states, 1, 0)
    with np.errstate(invalid="ignore"):
        lost = ~((np.abs(dq) * step <= LARGEST) & (np.abs(q) <= most) & np.isfinite(log.command))
    beyond = setup.plant.beyond(q)
    rows = np.flatnonzero((lost | beyond).any(axis=1))
    if not rows.size:
        return
    k = int(rows[0])
    joint = setup.plant.arm.joint_names[int(np.flatnonzero((lost | beyond)[k])[0])]
    if lost[k].any():
        fault = f"compiled, which cannot follow {joint} at {log.t[k]:.6g} s: above {LARGEST:g} rad a step, or no number"
        raise OptionError("loop", fault, f"a higher rate or more substeps, or {USUAL}")
    fault = f"compiled, which has no stops, and {joint} reaches its own before {log.t[k]:.6g} s"
    raise OptionError("loop", fault, f"position_limits=False, or {USUAL}")


INPUTS = ("common", "reference")

BEFORE, AFTER = ("q", "dq", "memory"), ("command", "applied", "friction_torque", "friction_work")
"""What is kept of a sample, in this order: before the step, and what the step made of it."""


def kept_columns(slots: Slots) -> dict[str, slice]:
    """Where each kept name stands in a row."""
    out, first = {}, 0
    for name in (*BEFORE, *AFTER):
        out[name] = slice(first, first + slots.widths[name])
        first += slots.widths[name]
    return out


_KEPT = """
/* copies from the block to a row */
static void {name}(const double *b, double *out, int at)
{{{lines}
}}
"""

_COPY = """
    for (int j = 0; j < {width}; j++) {{
        out[at + {to} + j] = b[{start} + j];
    }}"""


def whole_loop(plan: StepPlan) -> PlanLoop:
    """The loop of one run of a plan with `whole`."""
    columns = kept_columns(plan.slots)
    kept = _kept("before", plan.slots, columns, BEFORE) + _kept("after", plan.slots, columns, AFTER)
    text = (files("lwr_dyn.codegen.rollouts") / "compiled_loop.c").read_text(encoding="utf-8")
    places = {"SAMPLE": plan.slots.first("sample"), "KEPT": columns[AFTER[-1]].stop}
    return loop_of(plan, kept + text, "run", 1, places)


def _kept(name: str, slots: Slots, columns: dict[str, slice], names: Sequence[str]) -> str:
    """A function that copies what is kept of these names."""
    copies = (
        _COPY.format(width=slots.widths[x], to=columns[x].start, start=slots.first(x)) for x in names if slots.widths[x]
    )
    return _KEPT.format(name=name, lines="".join(copies))


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
        columns, samples = kept_columns(self.slots), len(reference)
        out = np.empty((samples, columns[AFTER[-1]].stop))
        block = np.empty(self.slots.size + 1)
        size = samples if report is None else max(1, samples // REPORTS)
        arguments = [address(common), 0, address(reference), samples, address(out), address(block)]
        for first in range(0, samples, size):
            last = min(first + size, samples)
            self.code.call(*arguments, first, last)
            if report is not None:
                report(last / samples)
        return {name: out[:, place] for name, place in columns.items()}


def whole_kernel(plan: StepPlan) -> WholeKernel:
    """The kernel of a plan with `whole`; raises `MissingPackageError` without the extra `batch`."""
    require_packages()
    key = plan_key("rollout-whole", plan, "whole")
    return WholeKernel(plan.slots, kept_code(key, lambda: whole_loop(plan).loop.machine_code(), len(INPUTS)))


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
    """Rows of the reference, of a tip that no result needs, and of noise."""
    motion, n, encoder = setup.motion, setup.plant.n, setup.loop.encoder
    parts = [motion.q, motion.dq, motion.ddq, np.zeros((motion.t.size, plan.slots.widths["tip"]))]
    if plan.noise == "table" and encoder is not None:
        parts.append(encoder.noise_of(motion.t.size, n, setup.loop.seed))
    return np.ascontiguousarray(np.concatenate(parts, axis=1))


def _log(setup: Setup, kept: Mapping[str, Array]) -> Log:
    log = Log.blank(setup)
    log.states[:] = np.stack([kept["q"], kept["dq"]], axis=1)
    log.command[:], log.applied[:] = kept["command"], kept["applied"]
    if log.friction is not None:
        log.friction[:] = kept["friction_torque"]
        log.works[1:, 1] = kept["friction_work"][:-1, 0]
    log.done = len(log.t)
    return log


def _signals(setup: Setup, form: LawForm, memory: Array) -> Mapping[str, Array]:
    """What the controller says of itself; raises `OptionError` where its form cannot say it."""
    if not hasattr(setup.controller, "signals"):
        return {}
    if not hasattr(form, "signals"):
        fault = f"compiled, of {label_of(setup.controller)}, whose signals its kernel form does not give"
        raise OptionError("loop", fault, USUAL)
    signals: Mapping[str, Array] = form.signals(memory)
    return signals
