"""An arm under Cartesian impedance with a constant force at its tip, until it has settled: its stiffness, as found."""

import numpy as np

import lwr_dyn
from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.kinematics.forward import frames, jacobian
from tests.control.laws.written_out import ARM, ROAD_B, tip_inertia, tip_offset

FORCE = 20.0
"""[N]"""
QUARTER = np.pi / 2
STRETCHED = {q4: np.array([0.3, 0.6, 0.2, q4, 0.4, 0.7, 0.1]) for q4 in (0.05, 0.2)}
"""Poses whose elbow is nearly stretched, by q4 [rad]."""


def regular_poses(count=14, seed=3):
    """Poses in 70 % of the joint box whose Jacobian has no singular value below 0.08."""
    rng, out = np.random.default_rng(seed), []
    while len(out) < count:
        q = rng.uniform(0.7 * ARM.lower, 0.7 * ARM.upper)
        if np.linalg.svd(jacobian(ARM.chain, q), compute_uv=False)[-1] > 0.08:
            out.append(q)
    return out


SINGULAR = [
    np.array(q)
    for q in (
        [0.3, 0.6, 0.2, 1.2, 0.4, 0.03, 0.1], [0.3, 0.03, 0.2, 1.2, 0.4, 0.7, 0.1],
        [0.3, 0.6, 0.2, 1.2, QUARTER, 0.03, 0.1], [0.3, 0.03, QUARTER, 1.2, 0.4, 0.7, 0.1],
        [0.3, 0.6, 0.2, -1.2, QUARTER, 0.03, 0.1], [0.3, 0.03, QUARTER, 1.2, QUARTER, 0.03, 0.1],
    )
]  # fmt: skip
"""q6 or q2 near 0, which is no singularity by itself; then with q5 or q3 at a quarter turn, which is one."""
SETTLED_S = {"regular": 3.0, "singular": 12.0}
"""[s] The slowest mode of a singular pose has 0.5 rad/s at its start."""


def direction(seed):
    """A random unit vector."""
    n = np.random.default_rng(seed).normal(size=3)
    return n / np.linalg.norm(n)


def pushed(q0, force, seconds, stiffness=2000.0, **options):
    """The run at rest on q0 with a constant force (3,) [N] at the tip, set in within 0.1 s."""
    tip = flange_and_jacobian(ARM)

    def push(t, q, dq):
        ramp = min(t / 0.1, 1.0)
        return tip(q)[1][:3].T @ (ramp * ramp * (3.0 - 2.0 * ramp) * force)

    law = lwr_dyn.controller("cartesian-impedance", ARM, stiffness=stiffness, rotation=stiffness / 10.0)
    hold = lwr_dyn.reference("hold", ARM, q=q0, duration=seconds)
    options = {"rate": 500.0, "friction": "none", "position_limits": False} | options
    return lwr_dyn.simulate(ARM, law, hold, external=push, **options)


def deflection(run):
    """The way of the tip (3,) [m] from its reference to where it ended."""
    return -tip_offset(ARM, run.q_ref[-1], run.q[-1])[:3]


def stiffness_error(q0, seed, seconds, stiffness=2000.0):
    """|way - f/K| as a share of f/K, after so many seconds, with `FORCE` in a random direction."""
    force = FORCE * direction(seed)
    wanted = force / stiffness
    away = deflection(pushed(q0, force, seconds, stiffness)) - wanted
    return float(np.linalg.norm(away) / np.linalg.norm(wanted))


def elbow_stiffness(q0, names=("outward", "inward", "across"), seconds=12.0, stiffness=2000.0):
    """k/K found outward, inward and across, for a force along the line from shoulder to wrist."""
    poses = frames(ARM.chain, q0)
    out = poses[4][:3, 3] - poses[0][:3, 3]
    out /= np.linalg.norm(out)
    across = np.cross(out, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    ways = {"outward": out, "inward": -out, "across": across}
    return {
        name: float(FORCE / stiffness / (ways[name] @ deflection(pushed(q0, FORCE * ways[name], seconds, stiffness))))
        for name in names
    }


def friction_band(q, level):
    """|Jbar|^T level (6,): what joints that stick at `level` [N m] can hold off, [N and N m]."""
    return np.abs(tip_inertia(ARM, ROAD_B, q)[1]).T @ np.full(ARM.n, level)
