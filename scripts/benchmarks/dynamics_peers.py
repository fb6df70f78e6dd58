"""MuJoCo and robotics-toolbox-python on the same arm: what single calls and the closed loop are compared with."""

from __future__ import annotations

import numpy as np

from benchmarks.timing import Call
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion


def mujoco_calls(arm: Arm, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> dict[str, tuple]:
    """MuJoCo's inverse and forward dynamics at the state, with the difference from ours."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf_text(arm))
    data = mujoco.MjData(model)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(mujoco.mjtDisableBit.mjDSBL_LIMIT)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, dq, ddq

    def inverse() -> np.ndarray:
        data.qacc[:] = ddq
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse

    def forward() -> np.ndarray:
        data.qfrc_applied[:] = ddq
        mujoco.mj_forward(model, data)
        return data.qacc

    return {
        "inverse_dynamics": (inverse, lambda dyn: np.abs(inverse() - dyn.inverse_dynamics(q, dq, ddq)).max()),
        "forward_dynamics": (forward, lambda dyn: np.abs(forward() - dyn.forward_dynamics(q, dq, ddq)).max()),
    }


def mujoco_loop(arm: Arm, motion: Motion, integrator: str) -> Call:
    """The same closed loop in MuJoCo: mj_inverse for the torque, mj_step for the motion."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf_text(arm))
    model.opt.timestep = 1e-3
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = mujoco.MjData(model)

    def loop() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = motion.q[0], motion.dq[0]
        for k in range(14000):
            data.qacc[:] = 2500.0 * (motion.q[k] - data.qpos) + 100.0 * (motion.dq[k] - data.qvel) + motion.ddq[k]
            mujoco.mj_inverse(model, data)
            data.qfrc_applied[:] = data.qfrc_inverse
            mujoco.mj_step(model, data)

    return loop


def toolbox_calls(arm: Arm, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> dict[str, tuple]:
    """robotics-toolbox-python on a DHRobot made from our own table."""
    import roboticstoolbox as rtb

    rows, links = dh_rows(open_paper(arm.name)), []
    for dh, link in zip(rows, arm.chain.links, strict=True):
        body, rotor = link.body, link.rotor
        inertia = {"m": body.mass, "r": body.com, "I": body.inertia_com, "Jm": rotor.inertia, "G": rotor.gear_ratio}
        links.append(rtb.RevoluteDH(d=dh.d, a=dh.a, alpha=dh.alpha, B=0, Tc=[0, 0], **inertia))
    robot = rtb.DHRobot(links, gravity=np.array(arm.chain.gravity))
    calls = {
        "mass_matrix": (lambda: robot.inertia(q), lambda d: d.mass_matrix(q), 200),
        "coriolis_matrix": (lambda: robot.coriolis(q, dq), lambda d: d.coriolis_matrix(q, dq), 50),
        "gravity_vector": (lambda: robot.gravload(q), lambda d: d.gravity_vector(q), 500),
        "inverse_dynamics": (lambda: robot.rne(q, dq, ddq), lambda d: d.inverse_dynamics(q, dq, ddq), 500),
        "forward_dynamics": (lambda: robot.accel(q, dq, ddq), lambda d: d.forward_dynamics(q, dq, ddq), 200),
    }
    out = {}
    for name, (theirs, mine, number) in calls.items():
        # rtb's Coriolis matrix is not the Christoffel one: compare what both mean, C dq
        right = (lambda x: x @ dq) if name == "coriolis_matrix" else (lambda x: x)
        check = lambda d, t=theirs, m=mine, r=right: np.abs(r(np.asarray(t())) - r(m(d))).max()  # noqa: E731
        out[name] = (theirs, check, number)
    return out
