"""The loop "stiff" of `simulate`: a controller at every moment and a plant that moves smoothly, by an implicit method.

Gains that are strong for a light joint make a loop stiff: explicit steps, and samples, must then be far shorter than
anything that is seen in the motion. LSODA changes to backward differences there and takes steps as long as the motion
allows. It knows neither stops nor stick, and refuses them by name.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import LSODA

from lwr_dyn.control.protocol import reset, saturate
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Motion, Run
from lwr_dyn.simulation.arm_friction import FORMS
from lwr_dyn.simulation.contact import followable
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.loops import At, Diverged, Log, Progress, continuous_controller, divergence, run_of
from lwr_dyn.simulation.setup import Setup

RTOL, ATOL = 1e-6, 1e-9
"""Of LSODA, relative and in the units of the state. With 1e-8 errors of the tip differ by at most 2e-5 of their size,
as tried on the Panda's sets."""


def refused(setup: Setup) -> str:
    """What the loop does not have, in words; nothing where it can run the setup."""
    loop = setup.loop
    lacking = {
        "elastic joints": setup.elasticity is not None, "external torques": loop.external is not None,
        "true stick (friction set-valued)": setup.plant.friction.form == FORMS[0],
        "a controller that is sampled": not loop.continuous,
    }  # fmt: skip
    return next((what for what, asked in lacking.items() if asked), "")


def between_samples(motion: Motion) -> At:
    """The reference as a function of time: the polynomials of order 5 that meet q, dq, ddq of all samples.

    Where the reference is smooth they are its own to h^6; a jump of its acceleration between samples is smoothed over
    one step.
    """
    h, ends = float(motion.t[1] - motion.t[0]), []
    for name, power in (("q", 0), ("dq", 1), ("ddq", 2)):
        x = np.asarray(getattr(motion, name)) * h**power
        ends += [x[:-1], x[1:]]
    q0, q1, v0, v1, a0, a1 = ends
    gap, speed, bend = q1 - q0 - v0 - a0 / 2, v1 - v0 - a0, a1 - a0  # of the cubic and higher part, at the end
    higher = [10 * gap - 4 * speed + bend / 2, -15 * gap + 7 * speed - bend, 6 * gap - 3 * speed + bend / 2]
    table = np.stack([q0, v0, a0 / 2, *higher], axis=1)  # (k, 6, n), of powers of the share of the step
    last, scale = len(table) - 1, np.array([1.0, 1 / h, 1 / h**2])[:, None]

    def at(t: float) -> tuple[Array, Array, Array]:
        k = min(int(t / h), last)
        u = t / h - k
        w = u * u
        powers = [
            [1.0, u, w, w * u, w * w, w * w * u], [0.0, 1.0, 2 * u, 3 * w, 4 * w * u, 5 * w * w],
            [0.0, 0.0, 2.0, 6 * u, 12 * w, 20 * w * u],
        ]  # fmt: skip
        q, dq, ddq = scale * np.dot(powers, table[k])
        return q, dq, ddq

    return at


def run_stiff(setup: Setup, progress: Progress | None = None) -> Run:
    """A run whose samples are read from one solution over the whole time.

    Raises
    ------
    OptionError
        What the loop does not have; a joint that reaches its stop, with the time.
    DivergenceError
        A motion that the method cannot follow.
    """
    if what := refused(setup):
        raise OptionError("loop", f"stiff, which does not have {what}", "a smooth plant, and continuous")
    plant, log, flow = setup.plant, Log.blank(setup), Flow(setup.plant, setup.loop.integrator())
    unlimited, memory_size = continuous_controller(setup.controller, between_samples(setup.motion))
    n, brake, forward = plant.n, plant.friction.smooth or np.zeros_like, plant.ungated.forward_dynamics

    def rates(t: float, y: Array) -> Array:
        q, dq = y[:n], y[n : 2 * n]
        tau, memory_rate = unlimited(t, q, dq, y[2 * n + 2 :])
        if not np.isfinite(tau).all():  # the method would try shorter steps for ever
            raise Diverged(0, tau)
        tau, friction = saturate(tau, plant.effort), brake(dq)
        return np.concatenate([dq, forward(q, dq, tau - friction), [tau.dot(dq), -friction.dot(dq)], memory_rate])

    start = np.concatenate([log.states[0].ravel(), np.zeros(2 + memory_size)])
    reset(setup.controller)
    solver = LSODA(rates, 0.0, start, float(log.t[-1]), rtol=RTOL, atol=ATOL)
    y, command = _followed(solver, log.t, lambda y: followable(y, n, 1.0 / setup.loop.rate))
    flow.evaluations, log.done = int(solver.nfev), len(y)
    for k, row in enumerate(y):
        log.states[k] = row[: 2 * n].reshape(2, n)
        log.command[k] = unlimited(float(log.t[k]), row[:n], row[n : 2 * n], row[2 * n + 2 :])[0]
    saturate(log.command, plant.effort, log.applied)
    log.works[1 : log.done] = np.diff(y[:, 2 * n : 2 * n + 2], axis=0)
    if log.friction is not None:
        log.friction[:] = np.array([brake(dq) for dq in log.states[:, 1]])
    if log.done < log.t.size:
        end = Diverged(log.done - 1, log.command[log.done - 1] if command is None else command)
        raise divergence(end, setup, log, setup.record(), lambda meta: run_of(setup, log, flow, meta))
    _refuse_stops(setup, log)
    if progress is not None:
        progress(1.0)
    return run_of(setup, log, flow, setup.record())


def _followed(solver: LSODA, t: Array, follows: Callable[[Array], bool]) -> tuple[Array, Array | None]:
    """The states at the times t (k,) as far as they can be followed, and the torque that ended them, if one did."""
    rows: list[Array] = [solver.y.copy()]  # at t[0]: a first step that fails leaves what the run began with
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            while solver.status == "running":
                failed = solver.step() is not None or solver.t == solver.t_old  # a message, or too short for the clock
                if failed or not follows(solver.y):
                    break
                rows.extend(solver.dense_output()(t[len(rows) : np.searchsorted(t, solver.t, "right")]).T)
    except Diverged as end:
        return np.array(rows), end.command
    return np.array(rows), None


def _refuse_stops(setup: Setup, log: Log) -> None:
    beyond = setup.plant.beyond(log.states[:, 0])
    if beyond.any():
        k, joint = (int(x) for x in np.argwhere(beyond)[0])
        fault = f"stiff, which has no stops, and {setup.plant.arm.joint_names[joint]} reaches its own before"
        raise OptionError("loop", f"{fault} {log.t[k]:.6g} s", "position_limits=False, or the usual loop (the default)")
