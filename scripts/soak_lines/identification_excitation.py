"""Exciting motions of three arms from many starts: each executable, checked by other code than that of the search."""

from __future__ import annotations

import numpy as np

import lwr_dyn

ARMS = (("lwr4plus", "physical"), ("wam7", None), ("kr30ha", None))
SEEDS = 4


def excitations() -> tuple[str, bool]:
    """Two objectives, 10 and 20 s, four seeds of two starts an arm: limits, clearance and torques at 1 kHz."""
    from lwr_dyn.identification.excitation.design import design_excitation
    from lwr_dyn.identification.excitation.motion_limits import MotionLimits
    from lwr_dyn.identification.excitation.room import ExcitationError
    from lwr_dyn.model.friction import friction_torque

    worst = {"position": np.inf, "speed": 0.0, "torque": 0.0, "clear": np.inf, "rest": 0.0}
    refused = count = 0
    for name, reading in ARMS:
        arm = lwr_dyn.load(name, reading)
        limits, dynamics = MotionLimits.of(arm), lwr_dyn.dynamics_of(arm, "newton-euler")
        for seed in range(SEEDS):
            for objective in ("d", "cond"):
                for duration in (10.0, 20.0):
                    count += 1
                    try:
                        m = design_excitation(arm, duration, objective, 2, seed=seed).sampled(1000.0)
                    except ExcitationError:
                        refused += 1
                        continue
                    tau = dynamics.inverse_dynamics(m.q, m.dq, m.ddq) + friction_torque(arm.friction_models(), m.dq)
                    inside = np.minimum(m.q - limits.lower, limits.upper - m.q).min()
                    worst["position"] = min(worst["position"], float(inside))
                    worst["speed"] = max(worst["speed"], float((np.abs(m.dq) / limits.speed).max()))
                    worst["torque"] = max(worst["torque"], float((np.abs(tau) / limits.torque).max()))
                    worst["clear"] = min(worst["clear"], least_distance(arm, m.q[::10]))
                    worst["rest"] = max(worst["rest"], float(np.abs(m.dq[[0, -1]]).max()))
    text = ", ".join(f"{name} {value:.3g}" for name, value in worst.items())
    kept = worst["position"] > -1e-9 and worst["speed"] < 1.0 + 1e-9 and worst["torque"] <= 1.0 + 1e-9
    good = kept and worst["clear"] > 0.05 - 2e-3 and worst["rest"] < 1e-9 and refused == 0
    return f"{count} designs, {refused} refused; worst: {text}", good


def least_distance(arm, q: np.ndarray) -> float:
    """From the floor and of capsules from each other, by points along them: at most 1 mm more than the distance is."""
    from lwr_dyn.identification.excitation.motion_limits import clearance_of
    from lwr_dyn.kinematics.forward import joint_axes

    space = clearance_of(arm, kept=0.0)
    axes = joint_axes(arm.chain, q)
    foot = np.broadcast_to(space.foot, (len(q), 1, 3))
    points = np.concatenate([axes.p, axes.flange[:, None, :3, 3], foot], axis=1)
    share = np.linspace(0.0, 1.0, 41)[:, None]
    lines = [points[:, a, None] * (1.0 - share) + points[:, b, None] * share for a, b in space.capsules]
    found = [
        float((points[:, i] @ space.planes[k].normal - space.planes[k].height - radius).min())
        for i, radius, k in space.low
    ]
    for a, b in space.pairs:
        for one, other in zip(lines[a], lines[b], strict=True):
            gap = np.linalg.norm(one[:, None] - other[None], axis=2).min()
            found.append(float(gap) - space.radii[a] - space.radii[b])
    return min(found)
