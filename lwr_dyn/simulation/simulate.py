"""`simulate`: an arm, a controller and a reference become a `Run` that says how it was made and audits itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import Controller, describe, reset
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.friction_choice import Choice, FrictionOption, check_rate, chosen_friction
from lwr_dyn.simulation.log import Log
from lwr_dyn.simulation.loops import Blowup, Progress, Sampling, run_continuous, run_sampled
from lwr_dyn.simulation.plant import Plant, loaded, plant_of
from lwr_dyn.simulation.record import divergence, origin, run_of, versions
from lwr_dyn.simulation.sensors import Encoder
from lwr_dyn.simulation.settings import Settings, check_continuous, sampled_reference, start_state
from lwr_dyn.simulation.stick_flow import StickFlow


def simulate(
    arm: Arm,
    controller: Controller,
    reference: Reference,
    *,
    rate: float = 1000.0,
    method: str = "rk4",
    substeps: int = 1,
    rtol: float = 1e-12,
    continuous: bool = False,
    engine: str | Dynamics = "pinocchio",
    plant: Arm | None = None,
    payload: float = 0.0,
    payload_com: ArrayLike = (0.0, 0.0, 0.0),
    payload_inertia: ArrayLike | None = None,
    friction: FrictionOption = "set-valued",
    encoder: Encoder | None = None,
    saturate: bool = True,
    position_limits: bool = True,
    allow_unphysical: bool = False,
    seed: int = 0,
    duration: float | None = None,
    q0: ArrayLike | None = None,
    dq0: ArrayLike | None = None,
    progress: Progress | None = None,
    meta: Mapping[str, Any] | None = None,
) -> Run:
    """The closed loop over time: B ddq + C dq + g = sat(tau) - tau_friction, tau = controller(t, state, reference).

    Parameters
    ----------
    arm : Arm
        The robot as its controller knows it; also the plant unless `plant` is given.
    controller : Controller
        A function or object `f(t, q, dq, q_ref, dq_ref, ddq_ref) -> tau`.
    reference : Reference
    rate : float
        Samples a second [Hz]: the controller is asked at them and its torque held between them.
    method : {"rk4", "dop853"}
        RK4 with `substeps` equal steps a sample, or adaptive with relative tolerance `rtol`.
    continuous : bool
        Ask the controller at every moment the integrator looks at; `rate` then only sets the samples of the run.
    engine : str or Dynamics
        The plant's engine: a name, or one already built for exactly this plant with its payload.
    plant : Arm, optional
        What is really moved: another reading, other masses.
    payload, payload_com, payload_inertia
        Mass [kg], centre (3,) [m] and inertia about it (3, 3) [kg m^2] of a load in the plant's flange frame. The
        controller knows of it only if its own dynamics were built on `loaded(arm, ...)`.
    friction : {"set-valued", "smooth", "none"}, sequence of JointFriction, or FrictionLaw
        The plant's own friction, where its file gives any, with true stick; its tanh form (stiff: see `substeps`); or
        none. Friction of one's own, joint by joint, is set-valued; a function tau_friction(dq) must be smooth.
    encoder : Encoder, optional
        What the controller sees; the true state if not given.
    saturate, position_limits : bool
        Cut torques at the effort limits; stop joints at their position limits, without bounce.
    seed : int
        Of the encoder's noise.
    duration : float, optional
        [s]; the reference's if not given.
    q0, dq0 : (n,) array_like, optional
        Where the run begins; on the reference if not given.
    progress : callable, optional
        Called with the share that is done.
    meta : mapping, optional
        JSON values that travel along in `run.meta["note"]`.

    Returns
    -------
    Run
        Samples from 0 to the duration; `run.meta["audit"]` holds the energy audit, `run.meta["evaluations"]` how often
        the accelerations were computed. An event "friction feeds energy in" warns of friction that drives.

    Raises
    ------
    OptionError, ShapeError
        An option outside what is allowed, an array of the wrong shape, a start outside the limits.
    MissingDataError, NotPhysicalError, UnknownNameError
        An arm that cannot be simulated, an engine that does not exist.
    DivergenceError
        The motion cannot be followed; its `run` holds what was computed.
    """
    settings = Settings(rate, method, substeps, rtol, continuous, saturate, position_limits, allow_unphysical, seed)
    if not callable(controller):
        raise OptionError("controller", repr(controller), "a function f(t, q, dq, q_ref, dq_ref, ddq_ref) -> tau")
    if not hasattr(reference, "sample"):
        raise OptionError("reference", repr(reference), "a Reference, such as tasks and Motion are")
    moved = arm if plant is None else plant
    if payload != 0.0:
        moved = loaded(moved, payload, payload_com, payload_inertia)
    choice = chosen_friction(moved, friction)
    body = _plant(moved, engine, choice, settings)
    if continuous:
        check_continuous(controller, encoder)
    motion = sampled_reference(reference, settings.times(reference.duration if duration is None else duration), body.n)
    start = start_state(body, motion, q0, dq0)
    friction_rate = check_rate(body, choice, start[0], settings)
    sensor = None if encoder is None else encoder.sensor(start[0], start[1], motion.t.size, rate, seed)
    log, flow = Log.blank(motion, start, continuous, sticks=body.dry is not None), _flow(body, settings)
    engine_name = engine if isinstance(engine, str) else getattr(engine, "name", type(engine).__name__)
    story = {
        **origin(arm), "plant": origin(moved), "payload": _payload(payload, payload_com, payload_inertia),
        "controller": describe(controller), "engine": engine_name,
        "reference": {
            "name": getattr(reference, "name", type(reference).__name__), "duration": float(reference.duration),
            "about": dict(getattr(reference, "about", {})),
        },
        "options": asdict(settings), "encoder": None if encoder is None else asdict(encoder),
        "friction": choice.form != "none", "friction_law": {**choice.about(), "rate": friction_rate}, "seed": seed,
        "versions": versions(), "note": dict(meta or {}),
    }  # fmt: skip
    reset(controller)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            if continuous:
                run_continuous(flow, controller, reference, log, progress)
            else:
                fast = method == "rk4" and body.friction is None
                run_sampled(flow, controller, log, Sampling(1 / rate, substeps, fast, sensor, progress))
    except Blowup as end:
        raise divergence(end.k, end.command, body, log, flow, story) from None
    return run_of(body, log, flow, story)


def _plant(arm: Arm, engine: str | Dynamics, choice: Choice, settings: Settings) -> Plant:
    arm.require_dynamics()
    dynamics = dynamics_of(arm, engine) if isinstance(engine, str) else engine
    if dynamics.n != arm.n:
        raise ShapeError("engine", f"{dynamics.n} joints", f"{arm.n} joints, as the plant has")
    return plant_of(
        arm, dynamics, choice.law, settings.saturate, settings.position_limits, settings.allow_unphysical, choice.dry
    )


def _flow(body: Plant, settings: Settings) -> Flow | StickFlow:
    if body.dry is not None:
        return StickFlow(body, settings.integrator(), body.dry)
    return Flow(body, settings.integrator())


def _payload(mass: float, com: ArrayLike, inertia: ArrayLike | None) -> dict[str, Any] | None:
    if mass == 0.0:
        return None
    tensor = None if inertia is None else np.asarray(inertia, dtype=np.float64).tolist()
    return {"mass": float(mass), "com": np.asarray(com, dtype=np.float64).tolist(), "inertia": tensor}
