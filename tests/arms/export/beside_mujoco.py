"""An MJCF read as an arm, beside MuJoCo's own computation with the compiled file."""

import numpy as np

import lwr_dyn


def differences(path, arm, tip=None, count=20):
    """The largest differences of mass matrix and bias torque, relative, and of the position of the tip [m]."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    data, engine, rng = mujoco.MjData(model), lwr_dyn.dynamics_of(arm, "newton-euler"), np.random.default_rng(1)
    names = [model.joint(j).name or f"joint_{j}" for j in range(model.njnt)]
    ids = [names.index(name) for name in arm.joint_names]
    places, dofs = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
    rest = np.array(model.qpos0)
    for j in np.flatnonzero(model.jnt_type >= 2):  # hinges and slides are held at 0 or the limit next to it
        low, up = model.jnt_range[j] if model.jnt_limited[j] else (-np.inf, np.inf)
        rest[model.jnt_qposadr[j]] = min(max(0.0, low), up)
    worst = np.zeros(3)
    for _ in range(count):
        q, dq = rng.uniform(-1.0, 1.0, (2, arm.n))
        data.qpos[:], data.qvel[:] = rest, 0.0
        data.qpos[places], data.qvel[dofs] = q, dq
        mujoco.mj_forward(model, data)
        mass, bias = np.zeros((model.nv, model.nv)), np.array(data.qfrc_bias[dofs])
        for row, unit in zip(mass, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        own = (engine.mass_matrix(q), engine.bias_torque(q, dq))
        for k, (a, b) in enumerate(zip(own, (mass[np.ix_(dofs, dofs)], bias), strict=True)):
            worst[k] = max(worst[k], np.abs(a - b).max() / max(np.abs(b).max(), 1e-3))
        there = lwr_dyn.forward_kinematics(arm, q)[:3, 3]
        ends = np.vstack([data.xpos, data.site_xpos]) if tip is None else data.body(tip).xpos[None]
        worst[2] = max(worst[2], np.linalg.norm(ends - there, axis=1).min())
    return worst
