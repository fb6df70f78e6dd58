"""`rollouts`: many runs of one closed loop at once, with parameters of their own, reduced to metrics on the way.

A single run can be had again, whole, by `simulate`, with the plant, the law and the noise that the kernel had.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.kernel_spec import friction_table
from lwr_dyn.codegen.rollouts import loop_setup as inputs
from lwr_dyn.codegen.rollouts.kernel import rollout_kernel
from lwr_dyn.codegen.rollouts.kernel_task import DEFAULT_ENCODER, plan_of, task_of
from lwr_dyn.codegen.rollouts.law_forms import LawForm, law_form
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup, loop_setup
from lwr_dyn.codegen.rollouts.philox_code import CountedEncoder
from lwr_dyn.codegen.rollouts.result import Rollouts, checked_quantiles, figures_of, metrics_of_computed, settle
from lwr_dyn.codegen.rollouts.step import MOST_DELAY
from lwr_dyn.codegen.rollouts.substeps import chosen_steps, with_substeps
from lwr_dyn.codegen.rollouts.symbolic_arm import friction_models
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, describe
from lwr_dyn.foundation.arrays import Array, arm_argument
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import smooth_friction
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, arm_record, check_whole, prepare
from lwr_dyn.simulation.simulate import run_setup


def simulated_run(setup: LoopSetup, row: Mapping[str, Array], number: int, form: LawForm | None = None) -> Run:
    """A run by `simulate`.

    Parameters
    ----------
    setup : LoopSetup
    row : mapping
        One run's parameters by the names of `parameter_shapes`.
    number : int
        Of the run, for the noise.
    form : LawForm, optional
        Where gains or the law's model are among the parameters: it makes the controller. Without it, the setup's
        controller runs, and these parameters are not looked at.

    Raises
    ------
    DivergenceError, OptionError
        As `simulate`.
    """
    loop, plant = setup.loop, inputs.arm_of_run(setup.plant, row)
    friction = loop.friction
    if friction == "smooth":
        table = row.get("friction")
        table = friction_table(setup.plant.friction_models()) if table is None else table.reshape(5, plant.n)
        friction = smooth_friction(friction_models(table), setup.friction_width)
    controller = setup.controller
    if form is not None and any(name in form.parameters or name.startswith("model_") for name in row):
        values = {name: row.get(name, value) for name, value in form.values().items()}
        controller = form.controller(inputs.arm_of_run(setup.arm, row, "model_"), values)
    own = replace(
        loop, plant=plant, friction=friction, encoder=encoder_of_run(setup, row, number), allow_unphysical=True,
        delay=int(row.get("delay", loop.delay)), q0=row.get("q0"), dq0=row.get("dq0"),
    )  # fmt: skip
    return run_setup(prepare(setup.arm, controller, setup.references[int(row.get("reference", 0))], own))


def encoder_of_run(setup: LoopSetup, row: Mapping[str, Array], number: int) -> CountedEncoder | None:
    """The encoder of a run with its noise; None for the true state."""
    if setup.loop.encoder is None and not {"resolution", "noise"} & row.keys():
        return None
    base = setup.loop.encoder or DEFAULT_ENCODER
    resolution, noise = (float(np.asarray(row.get(name, getattr(base, name)))) for name in ("resolution", "noise"))
    return CountedEncoder(resolution, noise, base.cutoff_hz, run=number)


def _again(setup: LoopSetup, given: Mapping[str, Array], first_run: int, form: LawForm, i: int) -> Run:
    """Row `i` of what a call was given, by `simulate`."""
    return simulated_run(setup, _row(given, i), first_run + i, form)


def _row(given: Mapping[str, Array], i: int) -> dict[str, Array]:
    return {name: array[i] for name, array in given.items()}


MOST_FIRST_RUN = 2**53


def rollouts(
    arm: Arm,
    controller: Controller | str,
    reference: Reference | Sequence[Reference],
    *,
    runs: int | None = None,
    parameters: Mapping[str, Any] | None = None,
    rate: float = 1000.0,
    substeps: int | None = None,
    plant: Arm | None = None,
    friction: str = "none",
    friction_width: float = SMOOTH_SPEED,
    saturate: bool = True,
    position_limits: bool = True,
    delay: int = 0,
    encoder: Encoder | None = None,
    seed: int = 0,
    duration: float | None = None,
    tolerance: float | None = None,
    quantiles: Sequence[float] = (),
    record: int = 0,
    threads: int = 1,
    hand_over: bool = True,
    first_run: int = 0,
) -> Rollouts:
    """Many runs of a closed loop by one generated kernel; the plant has neither stick friction nor stops in it.

    The same numbers come for any number of runs, threads and place: bit for bit on one machine and one set of versions.

    Parameters
    ----------
    arm : Arm
        As the law knows it; also the plant unless `plant` is given.
    controller : Controller or str
        One with a kernel form (`law_forms.LAW_FORMS`), or its name as `make_controller` takes it.
    reference : Reference or sequence of them
        Of several, the parameter "reference" (runs,) picks one for each run; shorter ones rest at their end.
    runs : int, optional
        Number of runs; that of the rows of `parameters` if not given.
    parameters : mapping, optional
        Arrays with a row a run. Plant: inertia (10 n) as `kernel_spec.inertial_parameters(chain).ravel()`;
        payload () [kg], a point mass at payload_com (3,) [m] in the flange; armature (n,) [kg m^2]; friction (5, n) as
        `kernel_spec.friction_parameters`; effort (n,) [N m]; q0, dq0 (n,); delay () samples; resolution,
        noise () [rad or m] of the encoder; reference (). The law's model: model_inertia, model_payload,
        model_payload_com. The law's gains by the names of its form, such as Kp (n,). (runs,) for (n,): all joints.
    rate, plant, saturate, position_limits, delay, encoder, seed, duration
        As of `simulate`, with RK4; a delay up to 8. Noise is counted by `seed` and the run's number, not NumPy's.
    substeps : int, optional
        RK4 steps a sample. 1 if not given; with smooth friction, as many as bring its estimated error below 1e-6 rad
        (`substeps.chosen_steps`): `setup` of the result has both. Give it where several calls are to agree bit for
        bit: the estimate is made on up to 64 of a call's own runs.
    friction : {"none", "smooth"}
        "smooth": the arm's own (or the parameter), with tanh(dq / `friction_width` [rad/s]) for the sign.
    tolerance : float, optional
        [m] of the tip error: when it is first passed is a metric.
    quantiles : sequence of float
        Shares of time; the tip error's quantiles become metrics.
    record : int
        Every how many samples q, dq and torque are kept; 0 for none.
    threads : int
    hand_over : bool
        Runs that meet a stop, or that the kernel cannot follow, are computed by `simulate`; else their metrics are NaN.
    first_run : int
        Number of the first run, for the noise.

    Raises
    ------
    OptionError, ShapeError, UnknownNameError
        Options and parameters outside what is allowed; a controller without a kernel form (`NoKernelFormError`);
        friction that is set-valued, or too stiff for the step.
    MissingPackageError
        Without the extra `batch`.
    """
    law: Any = make_controller(controller, arm_argument(arm)) if isinstance(controller, str) else controller
    for name, value, least in (("record", record, 0), ("threads", threads, 1), ("first_run", first_run, 0)):
        if not (isinstance(value, int) and least <= value <= MOST_FIRST_RUN):
            raise OptionError(name, value, f"a whole number from {least} on")
    check_whole("delay", delay, 0, MOST_DELAY)
    if tolerance is not None and not (np.isfinite(tolerance) and tolerance > 0.0):
        raise OptionError("tolerance", tolerance, "a length above 0, in m")
    loop = Loop(
        rate=rate, substeps=1 if substeps is None else substeps, plant=plant, friction=friction, saturate=saturate,
        encoder=encoder, seed=seed, position_limits=position_limits, delay=delay, duration=duration,
    )  # fmt: skip
    setup = loop_setup(arm, law, reference, loop, friction_width)
    form, shares = law_form(law, arm), checked_quantiles(quantiles)
    shapes = inputs.parameter_shapes(arm.n, form.parameters)
    count, given = inputs.run_parameters(parameters or {}, runs, shapes, len(setup.references))
    inputs.check_starts(setup, given)
    chosen = chosen_steps(setup, form, given, count) if substeps is None and friction == "smooth" else None
    setup = setup if chosen is None else with_substeps(setup, chosen.substeps)
    inputs.check_smooth_friction(setup, given)
    plan = plan_of(setup, form, given)
    kernel = rollout_kernel(plan, 1 if count == 1 else None)  # one lane gives the bits of several, in less time
    task = task_of(setup, plan, kernel, given, count, tolerance, shares, record, first_run)
    computed = kernel.run(task, threads)
    metrics, flags = metrics_of_computed(setup, kernel.slots, computed, shares, "effort" in given)

    again = partial(_again, setup, given, first_run, form)

    def figures(run: Run, i: int) -> dict[str, Array]:
        return figures_of(run, inputs.arm_of_run(setup.plant, _row(given, i)), tolerance, shares)

    simulated = settle(flags, metrics, computed.record, record, again if hand_over else None, figures)
    about = {
        **arm_record(arm), "plant": arm_record(setup.plant), "controller": describe(law), **setup.record(),
        "step_error": None if chosen is None else chosen.error, "runs": count, "first_run": first_run,
        "parameters": list(given), "digest": plan.digest,
    }  # fmt: skip
    kept: Any = [None] * 4 if computed.record is None else [setup.t[::record], *np.split(computed.record, 3, axis=2)]
    t, q, dq, tau = kept
    return Rollouts(metrics, tuple(flags), simulated, t, q, dq, tau, about, plan.digest, again)
