"""`simulate`: an arm, a controller and a reference become a `Run` that records its setup and its audit."""

from typing import Any

import numpy as np

from lwr_dyn.control.protocol import Controller, reset
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.loops import Diverged, Progress, run_continuous, run_sampled
from lwr_dyn.simulation.record import Log, divergence, run_of
from lwr_dyn.simulation.setup import Setup, prepare


def simulate(
    arm: Arm, controller: Controller, reference: Reference, *, progress: Progress | None = None, **options: Any
) -> Run:
    """The closed loop over time: B ddq + C dq + g = sat(tau) - tau_friction, tau = controller(t, state, reference).

    Parameters
    ----------
    arm, controller, reference, **options
        See `lwr_dyn.simulation.setup.prepare`: rate, method, substeps, rtol, continuous, engine, plant, payload,
        payload_com, payload_inertia, friction, encoder, saturate, position_limits, allow_unphysical, seed, delay,
        duration, q0, dq0, meta.
    progress : callable, optional
        Called with the share that is done.

    Returns
    -------
    Run
        As `run_setup` gives it.

    Raises
    ------
    LwrDynError
        As `prepare` and `run_setup`.
    """
    return run_setup(prepare(arm, controller, reference, **options), progress)


def run_setup(setup: Setup, progress: Progress | None = None) -> Run:
    """Run a checked setup; the same setup gives the same run every time.

    Returns
    -------
    Run
        Samples from 0 to the duration. `run.setup` is the setup; `run.meta` its record, with the audit under
        "audit" and how often the accelerations were computed under "evaluations". An event "friction feeds energy in"
        warns of friction that drives.

    Raises
    ------
    DivergenceError
        The motion cannot be followed; its `run` holds what was computed.
    """
    plant, options = setup.plant, setup.options
    flow, log, meta = Flow(plant, options.integrator()), Log.blank(setup), setup.record()
    reset(setup.controller)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            (run_continuous if options.continuous else run_sampled)(setup, flow, log, progress)
    except Diverged as end:
        raise divergence(end.k, end.command, setup, log, flow, meta) from None
    return run_of(setup, log, flow, meta)
