"""`rollouts`: many runs of one closed loop at once, with parameters of their own, reduced to metrics on the way."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.bodies_of_runs import arm_of_run
from lwr_dyn.codegen.rollouts.figures import checked_quantiles, figures_of, metrics_of_computed
from lwr_dyn.codegen.rollouts.flagged_runs import settle
from lwr_dyn.codegen.rollouts.kernel import rollout_kernel
from lwr_dyn.codegen.rollouts.laws.forms import law_form
from lwr_dyn.codegen.rollouts.loop_setup import check_smooth_friction, check_starts, loop_setup
from lwr_dyn.codegen.rollouts.replay import simulated_run
from lwr_dyn.codegen.rollouts.result import Rollouts
from lwr_dyn.codegen.rollouts.run_parameters import parameter_shapes, run_parameters
from lwr_dyn.codegen.rollouts.task_of_runs import plan_of, task_of
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, describe
from lwr_dyn.foundation.arrays import Array, arm_argument
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.simulation.arm_friction import SMOOTH_SPEED
from lwr_dyn.simulation.sensors import Encoder
from lwr_dyn.simulation.setup import arm_record

MOST_FIRST_RUN = 2**53


def rollouts(
    arm: Arm,
    controller: Controller | str,
    reference: Reference | Sequence[Reference],
    *,
    runs: int | None = None,
    parameters: Mapping[str, Any] | None = None,
    rate: float = 1000.0,
    substeps: int = 1,
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
        One with a kernel form (`rollout.laws.forms.LAW_FORMS`), or its name as `make_controller` takes it.
    reference : Reference or sequence of them
        Of several, the parameter "reference" (runs,) picks one for each run; shorter ones rest at their end.
    runs : int, optional
        Number of runs; that of the rows of `parameters` if not given.
    parameters : mapping, optional
        Arrays with a row a run. Plant: inertia (10 n) as `codegen.parameters.inertial_parameters(chain).ravel()`;
        payload () [kg], a point mass at payload_com (3,) [m] in the flange; armature (n,) [kg m^2]; friction (5, n) as
        `codegen.parameters.friction_parameters`; effort (n,) [N m]; q0, dq0 (n,); delay () samples; resolution,
        noise () [rad or m] of the encoder; reference (). The law's model: model_inertia, model_payload,
        model_payload_com. The law's gains by the names of its form, such as Kp (n,). (runs,) for (n,): all joints.
    rate, substeps, plant, saturate, position_limits, delay, encoder, seed, duration
        As of `simulate`, with RK4; a delay up to 8. Noise is counted by `seed` and the run's number, not NumPy's.
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
    if tolerance is not None and not (np.isfinite(tolerance) and tolerance > 0.0):
        raise OptionError("tolerance", tolerance, "a length above 0, in m")
    setup = loop_setup(
        arm, law, reference, rate=rate, substeps=substeps, plant=plant, friction=friction, delay=delay,
        friction_width=friction_width, saturate=saturate, position_limits=position_limits, encoder=encoder, seed=seed,
        duration=duration,
    )  # fmt: skip
    form, shares = law_form(law, arm), checked_quantiles(quantiles)
    shapes = parameter_shapes(arm.n, form.parameters)
    count, given = run_parameters(parameters or {}, runs, shapes, len(setup.references))
    check_starts(setup, given)
    check_smooth_friction(setup, given)
    plan = plan_of(setup, form, given)
    kernel = rollout_kernel(plan)
    task = task_of(setup, plan, kernel, given, count, tolerance, shares, record, first_run)
    computed = kernel.run(task, threads)
    metrics, flags = metrics_of_computed(setup, kernel.slots, computed, shares)

    def row(i: int) -> dict[str, Array]:
        return {name: array[i] for name, array in given.items()}

    def again(i: int) -> Run:
        return simulated_run(setup, row(i), first_run + i, form)

    def figures(run: Run, i: int) -> dict[str, Array]:
        return figures_of(run, arm_of_run(setup.plant, row(i)), tolerance, shares)

    simulated = settle(flags, metrics, computed.record, record, again if hand_over else None, figures)
    about = {
        **arm_record(arm), "plant": arm_record(setup.plant), "controller": describe(law), **setup.record(),
        "runs": count, "first_run": first_run, "parameters": list(given), "digest": plan.digest,
    }  # fmt: skip
    kept: Any = [None] * 4 if computed.record is None else [setup.t[::record], *np.split(computed.record, 3, axis=2)]
    t, q, dq, tau = kept
    return Rollouts(metrics, tuple(flags), simulated, t, q, dq, tau, about, plan.digest, again)
