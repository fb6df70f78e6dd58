"""The impedance laws written out with B, C, g, J and their inverses by the second road, and states to compare at."""

import numpy as np
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

import lwr_dyn
from lwr_dyn.kinematics.forward import jacobian

ARM = lwr_dyn.load("lwr4plus", reading="physical")
ROAD_A, ROAD_B = (lwr_dyn.dynamics_of(ARM, engine) for engine in ("pinocchio", "newton-euler"))
REGULAR = np.array([0.3, 0.6, 0.2, 1.2, 0.4, 0.7, 0.1])


def states(arm, count=5, seed=4):
    """States (q, dq, q_ref, dq_ref, ddq_ref) with tips less than a third of a turn apart."""
    rng = np.random.default_rng(seed)
    inner = 0.6 * np.clip(arm.upper, 0.0, 3.0)
    for _ in range(count):
        q_ref = rng.uniform(-inner, inner)
        yield (
            q_ref + rng.uniform(-0.2, 0.2, arm.n),
            *rng.uniform(-1.0, 1.0, (1, arm.n)),
            q_ref,
            *rng.uniform(-1.0, 1.0, (2, arm.n)),
        )


def designed_damping(inertia, K, xi):
    """D = 2 xi Q sqrt(B0) Q^T with inertia = Q Q^T, K = Q B0 Q^T, by the generalised eigenvalues."""
    b, V = eigh(K, inertia)
    Q = inertia @ V
    return 2.0 * xi * (Q * np.sqrt(b)) @ Q.T


def carried(dynamics, q, dq, dq_ref, ddq_ref):
    """B ddq_ref + C dq_ref + g."""
    moving = dynamics.mass_matrix(q) @ ddq_ref + dynamics.coriolis_matrix(q, dq) @ dq_ref
    return moving + dynamics.gravity_vector(q)


def joint_impedance(dynamics, state, K, xi):
    """The joint law; K (n,)."""
    q, dq, q_ref, dq_ref, ddq_ref = state
    D = designed_damping(dynamics.mass_matrix(q), np.diag(K), xi)
    return carried(dynamics, q, dq, dq_ref, ddq_ref) + K * (q_ref - q) + D @ (dq_ref - dq)


def tip_offset(arm, q_ref, q):
    """e (6,): by SciPy's rotations."""
    T_ref, T = (lwr_dyn.forward_kinematics(arm, x) for x in (q_ref, q))
    turn = Rotation.from_matrix(T_ref[:3, :3] @ T[:3, :3].T).as_rotvec()
    return np.concatenate([T_ref[:3, 3] - T[:3, 3], turn])


def tip_inertia(arm, dynamics, q):
    """Lambda (6, 6), Jbar (n, 6) and J (6, n)."""
    J, softness = jacobian(arm.chain, q), np.linalg.inv(dynamics.mass_matrix(q))
    Lambda = np.linalg.inv(J @ softness @ J.T)
    return Lambda, softness @ J.T @ Lambda, J


def cartesian_impedance(arm, dynamics, state, K, xi, w, d):
    """The Cartesian law; K (6,), posture spring w and its damping d."""
    q, dq, q_ref, dq_ref, ddq_ref = state
    Lambda, Jbar, J = tip_inertia(arm, dynamics, q)
    D = designed_damping(Lambda, np.diag(K), xi)
    late = jacobian(arm.chain, q_ref) @ dq_ref - J @ dq
    posture = dynamics.mass_matrix(q) @ (w**2 * (q_ref - q) + d * (dq_ref - dq))
    tau = carried(dynamics, q, dq, dq_ref, ddq_ref) + J.T @ (K * tip_offset(arm, q_ref, q) + D @ late)
    return tau + posture - J.T @ (Jbar.T @ posture)


def slope(controller, pose, which):
    """-d(tau - g)/dq or -d tau/d dq at rest at a pose, by central differences."""
    step, rest = 1e-5, np.zeros(pose.size)

    def torque(x):
        q, dq = (pose + x, rest) if which == 0 else (pose, x)
        return controller(0.0, q, dq, pose, rest, rest) - ROAD_A.gravity_vector(q)

    columns = [(torque(-step * e) - torque(step * e)) / (2.0 * step) for e in np.eye(pose.size)]
    return np.array(columns).T
