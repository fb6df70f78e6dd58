"""Logs of arms that MuJoCo moves, through the whole of `identify motion`: what its plus-minus says of their truth.

The arm is MuJoCo's own: its friction is a constraint, its torques are held for a step of its own, and its positions are
logged with the steps of an encoder, without speeds or accelerations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.fitted import fitted_arm, fitted_values, rotor_of
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.payload.identify_load import body_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion
from tests.identification import cover_truths as of
from tests.identification.cover_study import case
from tests.identification.cover_truths import BIG_ROTORS
from tests.identification.plants import inside, rms

STEP, ROWS = 5e-4, 8
"""[s] A step of MuJoCo, and how many of them there are to a row of the log."""
TORQUE, ENCODER = 0.1, 1e-5
"""[N m], [rad] Standard deviation of noise."""
KP, KD = 400.0, 40.0
"""[1/s^2], [1/s] Of the loop that moves the arm, per unit of its mass matrix."""
COULOMB, VISCOUS = (3.0, 3.0, 2.0, 2.0, 1.0, 0.6, 0.5), (2.0, 2.0, 1.0, 1.0, 0.5, 0.3, 0.2)
"""[N m], [N m s/rad] The same in both directions, as MuJoCo has it."""


@dataclass(frozen=True, slots=True, eq=False)
class MujocoFit:
    """Of one log: misses in standard errors of bodies (10 n,) and rotors (n,), the rotors and their errors, and the
    largest inertia of each joint over the true one's."""

    base: Array
    bodies: Array
    rotors: Array
    armature: Array
    sigma: Array
    gains: Array
    refused: bool


def true_arm(name: str, truth: str, run: int) -> tuple[Arm, Array]:
    """An arm of `cover_truths` about its table, and its parameters (p,)."""
    columns, table = case(name)
    arm = of.cover_arm(name)
    parameters = of.cover_truth(arm, columns, table, truth, of.cover_seed(name, truth, "mujoco", run))
    if truth == "rotors":
        parameters[columns.rotor_indices] = BIG_ROTORS[: arm.n]
    links, limits = [], []
    for i, link in enumerate(arm.chain.links):
        body = body_of(parameters[10 * i : 10 * i + 10])
        links.append(replace(link, body=body, rotor=rotor_of(link.rotor, parameters[columns.rotor_indices[i]])))
        limits.append(replace(arm.limits[i], coulomb=COULOMB[i], viscous=VISCOUS[i]))
    chain = replace(arm.chain, links=tuple(links))
    arm = replace(arm, chain=chain, limits=tuple(limits), friction=())
    return arm, columns.own(arm)


def mujoco_log(arm: Arm, motion: Motion, rng: np.random.Generator) -> JointLog:
    """What MuJoCo's arm logs along a motion: at an instant the mean of the torques held before and after it."""
    unlimited = replace(arm, limits=tuple(replace(x, lower=None, upper=None, effort=None) for x in arm.limits))
    model = mujoco.MjModel.from_xml_string(mjcf_text(unlimited))
    model.opt.timestep, model.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    t = np.arange(motion.t[0], motion.t[-1], STEP)
    wanted = [np.column_stack([np.interp(t, motion.t, x) for x in y.T]) for y in (motion.q, motion.dq, motion.ddq)]
    data.qpos[:], data.qvel[:] = wanted[0][0], wanted[1][0]
    M, rows = np.zeros((model.nv, model.nv)), []
    for k, (q, dq, ddq) in enumerate(zip(*wanted, strict=True)):
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, M)
        error = KP * (q - data.qpos) + KD * (dq - data.qvel)
        losses = np.array(COULOMB[: arm.n]) * np.tanh(dq / 0.05) + np.array(VISCOUS[: arm.n]) * dq
        before, now = data.ctrl.copy(), M @ (ddq + error) + data.qfrc_bias + losses
        if k % ROWS == 0:
            rows.append((t[k], *data.qpos, *(0.5 * (before + now) if k else now)))
        data.ctrl[:] = now
        mujoco.mj_step(model, data)
    log = np.array(rows)
    q, tau = log[:, 1 : arm.n + 1], log[:, arm.n + 1 :]
    q, tau = q + rng.normal(0.0, ENCODER, q.shape), tau + rng.normal(0.0, TORQUE, tau.shape)
    return JointLog("mujoco", tuple(range(1, arm.n + 1)), log[:, 0], q, tau)


def mujoco_fit(name: str, truth: str, run: int) -> MujocoFit:
    """`identify motion` of one log, from the arm's table, by its defaults."""
    arm, true = true_arm(name, truth, run)
    log = mujoco_log(arm, of.cover_motion(name, run % of.MOTIONS), np.random.default_rng([run, 7]))
    result = identify_motion([log], of.cover_arm(name))
    fit = result.consistent
    assert fit is not None
    columns = result.columns
    rotors = columns.rotor_indices
    away = (fit.parameters - true) / fit.sigma
    fitted = fitted_arm(of.cover_arm(name), fitted_values(result))
    largest = [np.array([w.value for w in worst_case_inertias(x)]) for x in (fitted, arm)]
    said = result.information
    base = (said.values - columns.base().of(true)) / said.sigma
    return MujocoFit(
        base[np.isfinite(base)],
        away[: columns.bodies], away[rotors], fit.parameters[rotors], fit.sigma[rotors], largest[0] / largest[1],
        bool(result.contradiction),
    )  # fmt: skip


def spread(fits: Sequence[MujocoFit]) -> tuple[float, float, float]:
    """RMS miss, share inside 3 sigma, largest miss of bodies and rotors together."""
    z = np.array([np.concatenate([fit.bodies, fit.rotors]) for fit in fits])
    return rms(z), inside(z), float(np.abs(z).max())
