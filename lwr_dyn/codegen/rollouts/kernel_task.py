"""What a kernel is made from, and what it computes: plan and task of a call of `rollouts`, from its arguments."""

from collections.abc import Mapping

import numpy as np

from lwr_dyn.codegen.kernels.kernel_spec import friction_table
from lwr_dyn.codegen.rollouts.kernel import RolloutKernel, Task
from lwr_dyn.codegen.rollouts.law_forms import LawForm, finite_limits
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup, kept_values
from lwr_dyn.codegen.rollouts.step import GAIN, MOST_DELAY, STARTS, Slots, StepPlan
from lwr_dyn.codegen.rollouts.symbolic_arm import KeptParameters
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.plant import Encoder

DEFAULT_ENCODER = Encoder()
"""What resolution and noise a run are put into where no encoder was given: its cut-off counts."""

DIRECT = {
    "armature": "armature", "friction": "friction", "effort": "effort", "q0": "q", "dq0": "dq", "delay": "delay",
    "resolution": "resolution", "noise": "noise",
}  # fmt: skip
"""Parameters whose numbers are those of a slot."""


def plan_of(setup: LoopSetup, form: LawForm, given: Mapping[str, Array]) -> StepPlan:
    """The plan: it depends on which parameters are given, not on their values."""
    loop, encoder = setup.loop, setup.loop.encoder or DEFAULT_ENCODER
    has_encoder = loop.encoder is not None or "resolution" in given or "noise" in given
    is_noisy = has_encoder and (encoder.noise > 0.0 or "noise" in given)
    return StepPlan(
        setup.arm, setup.plant, form, float(loop.rate), loop.substeps,
        varies_plant="inertia" in given or "payload" in given,
        varies_model="model_inertia" in given or "model_payload" in given,
        friction_width=setup.friction_width if loop.friction == "smooth" else None,
        pole=encoder.velocity_filter(loop.rate).pole if has_encoder else None,
        noise="philox" if is_noisy else "none",
        most_delay=MOST_DELAY if loop.delay or "delay" in given else 0,
    )  # fmt: skip


def common_row(setup: LoopSetup, plan: StepPlan, slots: Slots, tolerance: float | None) -> Array:
    """The numbers of a run without parameters of its own, (slots,)."""
    plant, form, motion = setup.plant, plan.form, setup.motions[0]
    encoder = setup.loop.encoder or DEFAULT_ENCODER
    values = {
        **STARTS, "q": motion.q[0], "dq": motion.dq[0], "memory": form.start(), "armature": plant.armature,
        "effort": _cut(setup, plant.effort), "rating": finite_limits(plant.effort), "lower": plant.lower,
        "upper": plant.upper,
        "tolerance": np.inf if tolerance is None else tolerance**2, "last": setup.samples - 1.0,
        "delay": float(setup.loop.delay), "resolution": encoder.resolution, "noise": encoder.noise,
        **{GAIN + name: value for name, value in form.values().items()},
    }  # fmt: skip
    if plan.friction_width is not None:
        values["friction"] = friction_table(plant.friction_models())
    if plan.varies_model:
        values["model"] = KeptParameters.of(setup.arm.chain).own
    return slots.filled(values)


def _cut(setup: LoopSetup, effort: Array) -> Array:
    """The torques at which commands are cut."""
    return finite_limits(effort if setup.loop.saturate else np.full_like(effort, np.inf))


def task_of(
    setup: LoopSetup, plan: StepPlan, kernel: RolloutKernel, given: Mapping[str, Array], runs: int,
    tolerance: float | None, quantiles: tuple[float, ...], stride: int, first_run: int,
) -> Task:  # fmt: skip
    """The task of a kernel; `given` as `run_parameters` gives it."""
    slots, which = kernel.slots, given.get("reference", np.zeros(runs))
    columns: dict[str, Array] = {}
    if len(setup.motions) > 1:
        starts = np.array([[motion.q[0], motion.dq[0]] for motion in setup.motions])[which.astype(int)]
        columns |= {"q": starts[:, 0], "dq": starts[:, 1]}
    columns |= {slot: given[name] for name, slot in DIRECT.items() if name in given}
    columns |= {GAIN + name: given[name] for name in plan.form.parameters if name in given}
    if "effort" in given:
        columns |= {"effort": _cut(setup, given["effort"]), "rating": finite_limits(given["effort"])}
    for slot, varies, arm, prefix in (
        ("plant", plan.varies_plant, setup.plant, ""), ("model", plan.varies_model, setup.arm, "model_")
    ):  # fmt: skip
        if varies:
            bodies = (given.get(prefix + name) for name in ("inertia", "payload", "payload_com"))
            columns[slot] = kept_values(arm.chain, *bodies)
    rows = [np.reshape(column, (runs, -1)) for column in columns.values()]
    places = [place for slot in columns for place in slots.places(slot)]
    return Task(
        common_row(setup, plan, slots, tolerance),
        np.ascontiguousarray(np.hstack(rows)) if rows else np.zeros((runs, 0)),
        np.array(places, dtype=np.float64), setup.table(), np.ascontiguousarray(which, dtype=np.float64),
        setup.loop.seed, first_run, stride, quantiles,
    )  # fmt: skip
