"""`simulate`: an arm, a controller and a reference become a `Run` that records its setup and its audit.

`free_swing` is a run without torque: without friction and stops its energy stays constant.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import Controller, reset
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import MissingPackageError, OptionError, UnknownNameError
from lwr_dyn.foundation.progress import progress as shown_progress
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, Reference, Run
from lwr_dyn.model.transmission import JointElasticity
from lwr_dyn.simulation.arm_friction import FrictionOption
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.loops import Diverged, Log, Progress, divergence, run_continuous, run_of, run_sampled
from lwr_dyn.simulation.plant import Encoder, ExternalTorque, checked_external
from lwr_dyn.simulation.setup import Loop, Setup, prepare

LOOPS: Registry[Callable[[Setup, Progress | None], Run]] = Registry(
    "loop",
    {
        "rigid": Row("lwr_dyn.simulation.simulate:run_rigid", "sampled or continuous, rigid joints"),
        "elastic": Row("lwr_dyn.simulation.elastic.run:run_elastic", "sampled, elastic joints"),
        "compiled": Row(
            "lwr_dyn.codegen.rollouts.compiled_loop:run_compiled", "one kernel, neither stops nor stick", "batch"
        ),
        "stiff": Row("lwr_dyn.simulation.stiff:run_stiff", "continuous, implicit; neither stops nor stick"),
    },
)

FASTER: Registry[Callable[[Setup], bool]] = Registry(
    "faster_loop",
    {"compiled": Row("lwr_dyn.codegen.rollouts.compiled_loop:takes", "the usual loop in one kernel", "batch",
                     {"times": 10})},
)  # fmt: skip
"""Loop -> whether it takes a setup that the usual loop would run, and how many times as fast it is: measured in ten
cases of four arms and five laws, 9.5 to 21, with smooth friction 7; with record and audit, without sampling the
reference."""

LONG = 50_000
"""RK4 steps from which on a faster loop is pointed out: the usual one takes about a second for them."""


def faster_loop(setup: Setup) -> str:
    """Which loop would run a long setup at least 5 times as fast as the usual one, in words; empty for none.

    It depends on the setup and on what is installed, not on what is compiled already. Beside engine "kernels" the
    compiled loop is 4.9 times as fast, so nothing is said.
    """
    loop = setup.loop
    if loop.engine_name == "kernels" or (setup.motion.t.size - 1) * loop.substeps < LONG:
        return ""
    for name, row in FASTER.rows.items():
        try:
            if FASTER.load(name)(setup):
                times = row.facts["times"]
                return f"loop: {name} is some {times} times as fast for such a run, apart from sampling its reference"
        except MissingPackageError:
            continue
    return ""


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
    external: ExternalTorque | None = None,
    elasticity: JointElasticity | str | float | None = None,
    encoders: str = "motor",
    encoder: Encoder | None = None,
    saturate: bool = True,
    position_limits: bool = True,
    allow_unphysical: bool = False,
    seed: int = 0,
    delay: int = 0,
    loop: str | None = None,
    duration: float | None = None,
    q0: ArrayLike | None = None,
    dq0: ArrayLike | None = None,
    meta: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> Run:
    """The closed loop over time: B ddq + C dq + g = sat(tau) - tau_friction + tau_external, tau = controller(...).

    Parameters
    ----------
    arm : Arm
        The robot as its controller knows it; also the plant unless `plant` is given.
    controller : Controller
        A function or object `f(t, q, dq, q_ref, dq_ref, ddq_ref) -> tau`.
    reference : Reference
    rate : float
        Samples a second [Hz]: the controller is called at each, and its torque held until the next.
    method : {"rk4", "dop853"}
        RK4 with `substeps` equal steps a sample, or adaptive with relative tolerance `rtol`.
    continuous : bool
        Call the controller at every stage of the integrator; `rate` then only sets the samples of the run.
    engine : str or Dynamics
        The plant's engine: a name, or one already built for exactly this plant with its payload. "kernels" (extra
        `batch`) is about 3 times as fast as the default for any controller whose model has it too.
    plant : Arm, optional
        The arm that is simulated: another reading, other masses.
    payload, payload_com, payload_inertia
        Mass [kg], centre (3,) [m] and inertia about it (3, 3) [kg m^2] of a load in the plant's flange frame. The
        controller knows of it only if its own dynamics were built on `arm_with_payload(arm, ...)`.
    friction : {"set-valued", "smooth", "none"}, sequence of JointFriction, or function
        The plant's own friction, where its file gives any, with true stick; its tanh form (stiff: see `substeps`); or
        none. Friction of one's own, joint by joint, is set-valued; a function tau_friction(dq) must be smooth.
    external : function, optional
        tau_external(t, q, dq) (n,) [N m], on the links, such as a wall or a push (see `ExternalTorque`). A jump in it
        costs the accuracy of the step that it falls in. `run.signals["tau_external"]` holds it at the samples.
    elasticity : JointElasticity, "file" or float, optional
        Springs and dampers between the motors and the links: one's own, the arm's, or the arm's with this largest
        stiffness [N m/rad]; rigid if not given. The run's q and dq are then the link's; friction acts on the motors.
    encoders : {"motor", "link"}
        The side of elastic joints whose positions the controller gets as q and dq.
    encoder : Encoder, optional
        What the controller sees; the true state if not given.
    saturate, position_limits : bool
        Cut torques at the effort limits; stop joints at their position limits, without bounce.
    allow_unphysical : bool
        Simulate inertias that no body can have.
    seed : int
        Of the encoder's noise.
    delay : int
        Samples from a command of the controller to its torque; until it arrives, the first command acts.
    loop : {"rigid", "elastic", "compiled", "stiff"}, optional
        As the joints are, if not given; "compiled" computes the whole loop in generated code, some 10 times
        as fast, see `run_compiled`: a long run that it would take says so in `run.hint`; "stiff" moves a `continuous`
        one by an implicit method, for gains that would need very short steps.
    duration : float, optional
        [s]; the reference's if not given.
    q0, dq0 : (n,) array_like, optional
        The state at the start [rad or m, per s]; on the reference if not given.
    meta : mapping, optional
        JSON values that are kept in `run.meta["note"]`.
    progress : callable, optional
        Called with the share that is done; a bar in a notebook if not given.

    Returns
    -------
    Run
        As `run_setup` gives it.

    Raises
    ------
    OptionError, ShapeError
        An option outside what is allowed, an array of the wrong shape, a start outside the limits.
    MissingDataError, NotPhysicalError, UnknownNameError
        An arm that cannot be simulated, an engine that does not exist.
    DivergenceError
        As `run_setup`.
    """
    closed = Loop(
        rate=rate, method=method, substeps=substeps, rtol=rtol, continuous=continuous, engine=engine, plant=plant,
        payload=payload, payload_com=payload_com, payload_inertia=payload_inertia, friction=friction,
        external=external, elasticity=elasticity, encoders=encoders, encoder=encoder, saturate=saturate,
        position_limits=position_limits, allow_unphysical=allow_unphysical, seed=seed, delay=delay, loop=loop,
        duration=duration, q0=q0, dq0=dq0, meta=meta,
    )  # fmt: skip
    setup = prepare(arm, controller, reference, closed)
    with shown_progress("simulating", terminal=False) as report:
        return run_setup(setup, report if progress is None else progress)


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
    OptionError, UnknownNameError
        A loop that does not fit the setup, or that does not exist.
    """
    usual = "rigid" if setup.elasticity is None else "elastic"
    asked = setup.loop.loop
    if {asked, usual} == {"rigid", "elastic"}:
        raise OptionError("loop", repr(asked), f"{usual}, as the joints are, compiled, or stiff")
    return LOOPS.load(asked or usual)(setup, progress)


def run_rigid(setup: Setup, progress: Progress | None = None) -> Run:
    """As `run_setup`, of rigid joints."""
    plant, loop = setup.plant, setup.loop
    external = None if loop.external is None else checked_external(loop.external, plant.n)
    flow, log, meta = Flow(plant, loop.integrator(), external), Log.blank(setup), setup.record()
    hint = faster_loop(setup)  # before the run: it may call the controller
    reset(setup.controller)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            (run_continuous if loop.continuous else run_sampled)(setup, flow, log, progress)
    except Diverged as end:
        raise divergence(end, setup, log, meta, lambda meta: run_of(setup, log, flow, meta)) from None
    if hint and not flow.events:  # no other loop has stops
        meta["hint"] = hint
    return run_of(setup, log, flow, meta)


EQUILIBRIUM = 1e-3
"""[rad/s^2] A pose with less acceleration at rest counts as an equilibrium: centres of mass are printed to 1e-8 m, so
the LWR's upright pose is exact to 1e-4 rad/s^2."""


@dataclass(frozen=True, slots=True)
class SwingCase:
    """The start of a swing: upright q = 0 with this offset [rad] and this speed [rad/s] at every joint."""

    offset: float
    speed: float
    title: str


CASES: Mapping[str, SwingCase] = {
    "rest": SwingCase(0.0, 0.0, "upright at rest: an equilibrium to the printed digits"),
    "speed": SwingCase(0.0, 0.5, "upright with initial velocities"),
    "offset": SwingCase(1e-3, 0.0, "upright, every joint offset by 1e-3 rad: the equilibrium is unstable"),
}


@dataclass(frozen=True, slots=True, eq=False)
class Standstill:
    """The reference of a swing, which no controller follows: the pose q (n,) [rad or m] for `duration` [s]."""

    q: Array
    duration: float

    def sample(self, t: Array) -> Motion:
        """The pose, without speed or acceleration, at times t (k,) [s]."""
        times = np.atleast_1d(t)
        still = np.zeros((times.size, self.q.size))
        return Motion(times, still + self.q, still, still)


def no_torque(t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
    """The controller without torque, tau = 0."""
    return np.zeros_like(q)


def free_swing(
    arm: Arm,
    case: str = "offset",
    *,
    duration: float = 2.0,
    method: str = "dop853",
    position_limits: bool = False,
    q0: ArrayLike | None = None,
    dq0: ArrayLike | None = None,
    **options: Any,
) -> Run:
    """A free swing from one of `CASES`; `run.meta["note"]` says whether it began at an equilibrium.

    Parameters
    ----------
    arm : Arm
    case : {"rest", "speed", "offset"}
    duration : float
        [s]
    position_limits : bool
        Off by default, so that the energy stays constant; with stops their losses are a channel.
    q0, dq0 : (n,) array_like, optional
        The start [rad or m, per s], in place of the case's own.
    **options
        Further options of `simulate`.

    Raises
    ------
    UnknownNameError
        No such case; otherwise as `simulate`.
    """
    if case not in CASES:
        raise UnknownNameError("swing", case, CASES)
    start = CASES[case]
    pose = joint_array("q0", np.full(arm.n, start.offset) if q0 is None else q0, arm.n)
    speed = np.full(arm.n, start.speed) if dq0 is None else dq0
    stay = Standstill(pose, float(duration))
    loop = Loop(q0=pose, dq0=speed, method=method, position_limits=position_limits, **options)
    setup = prepare(arm, no_torque, stay, loop)
    none = np.zeros(arm.n)
    largest = float(np.abs(setup.plant.dynamics.forward_dynamics(pose, none, none)).max())
    equilibrium = largest <= EQUILIBRIUM and not setup.start[1].any()
    note = {"case": case, "title": start.title, "acceleration_at_rest": largest, "equilibrium": bool(equilibrium)}
    return run_setup(replace(setup, loop=replace(loop, meta=note)))
