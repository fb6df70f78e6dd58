"""The loop "compiled" of `simulate`: one run as a kernel, every sample kept, with the same record and audit.

It repeats the usual loop of rigid joints to rounding; what it lacks (stops, true stick, ...) it refuses by name. Two
loops cannot agree for long where rounding grows: in a free swing, and under an encoder with a resolution, which leaves
the arm alone between two counts.
"""

import warnings
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.codegen.rollouts.laws.forms import law_form
from lwr_dyn.codegen.rollouts.laws.no_form import NoKernelFormError
from lwr_dyn.codegen.rollouts.laws.protocol import LawForm
from lwr_dyn.codegen.rollouts.loop_limits import USUAL, check_setup, refuse_ends
from lwr_dyn.codegen.rollouts.slots import GAIN
from lwr_dyn.codegen.rollouts.smooth_friction import friction_table
from lwr_dyn.codegen.rollouts.step import StepPlan
from lwr_dyn.codegen.rollouts.symbolic_model import armature_of
from lwr_dyn.codegen.rollouts.whole_kernel import whole_kernel
from lwr_dyn.control.protocol import label_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, RatingWarning
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.changed_arm import arm_with_payload
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.loops import Progress
from lwr_dyn.simulation.record import Log, run_of
from lwr_dyn.simulation.setup import Setup


def run_compiled(setup: Setup, progress: Progress | None = None) -> Run:
    """A run by generated code: the samples of the usual loop, to rounding.

    The controller must have a kernel form (`rollout.laws`) for the arm as it knows it; it is not called in the run. The
    plant's engine gives the energies of the audit, not the motion.

    Raises
    ------
    OptionError
        What the kernel does not have: see `loop_limits`; signals that the law's form does not give; a joint that meets
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
    log, flow, meta = _log(setup, kept), Flow(setup.plant, setup.options.integrator()), setup.record()
    refuse_ends(setup, log)
    log.signals |= _signals(setup, form, kept["memory"])
    flow.evaluations = 4 * setup.options.substeps * (log.done - 1)
    return run_of(setup, log, flow, meta)


def _arm_and_form(setup: Setup) -> tuple[Arm, LawForm]:
    """The arm that the controller knows, and its form: the setup's own arm, that with the payload, or the plant."""
    arms, load = [setup.arm], setup.payload
    if load is not None:
        with warnings.catch_warnings(action="ignore", category=RatingWarning):  # said when the plant was made
            arms.append(arm_with_payload(setup.arm, load["mass"], load["com"], load["inertia"]))
    faults = []
    for arm in (*arms, setup.plant.arm):
        try:
            return arm, law_form(setup.controller, arm)
        except NoKernelFormError as fault:
            faults.append(fault)
    raise faults[0]


def _plan(setup: Setup, known: Arm, form: LawForm) -> StepPlan:
    options, encoder, friction = setup.options, setup.encoder, setup.plant.friction
    return StepPlan(
        known, setup.plant.arm, form, options.rate, options.substeps,
        friction_width=None if friction.form == "none" else SMOOTH_SPEED,
        pole=None if encoder is None else encoder.velocity_filter(options.rate).pole,
        noise="none" if encoder is None or encoder.noise == 0.0 else "table", most_delay=options.delay, whole=True,
    )  # fmt: skip


def _common(setup: Setup, plan: StepPlan) -> Array:
    """The numbers of the run, in the kernel's slots."""
    plant, encoder = setup.plant, setup.encoder
    values: Mapping[str, ArrayLike] = {
        "q": setup.start[0], "dq": setup.start[1], "memory": plan.form.start(), "effort": plant.effort,
        "armature": armature_of(plant.arm.chain), "lower": plant.lower, "upper": plant.upper, "delay": plan.most_delay,
        "friction": _friction(setup), "resolution": 0.0 if encoder is None else encoder.resolution, "noise": 1.0,
        "tolerance": np.inf, "last": setup.motion.t.size - 1,
    } | {GAIN + name: value for name, value in plan.form.values().items()}  # fmt: skip
    row = np.zeros(plan.slots.size)
    for name, value in values.items():
        if plan.slots.widths[name]:
            row[plan.slots.places(name)] = np.ravel(value)
    return row


def _friction(setup: Setup) -> Array:
    """The plant's friction, (5, n): the arm's own, or viscous alone."""
    friction, n = setup.plant.friction, setup.plant.n
    if friction.form == "smooth":
        return friction_table(setup.plant.arm.friction_models())
    viscous = np.zeros(n) if friction.smooth is None else friction.smooth(np.ones(n))
    return np.array([np.zeros(n), viscous, np.zeros(n), viscous, np.zeros(n)])


def _table(setup: Setup, plan: StepPlan) -> Array:
    """Rows of the reference, of a tip that no result needs, and of noise."""
    motion, n = setup.motion, setup.plant.n
    parts = [motion.q, motion.dq, motion.ddq, np.zeros((motion.t.size, plan.slots.widths["tip"]))]
    if plan.noise == "table" and setup.encoder is not None:
        parts.append(setup.encoder.noise_of(motion.t.size, n, setup.options.seed))
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
