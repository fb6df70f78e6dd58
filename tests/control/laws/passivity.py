"""An arm under an impedance law, pushed by a hand against a wall, with the energy that each of the three gives.

The state holds the works of law, wall and hand beside q and dq. With a constant reference the storages are the law's
S = e^T K e / 2, the wall's spring, and the arm's kinetic energy; gravity is the law's. What law and wall have taken
out, `law_loss` and `wall_loss`, may not fall where both are passive.
"""

from dataclasses import dataclass

import numpy as np

import lwr_dyn
from lwr_dyn.control.laws.impedance import CartesianImpedance, JointImpedance
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.simulation.walls_and_pushes import Wall
from tests.control.laws.written_out import ARM, ROAD_A, tip_offset

HELD_POSE = np.array([0.0, 0.7, 0.0, -1.5, 0.0, 0.9, 0.0])
GAP = 5e-3
"""[m] From the tip at rest down to the table."""
JOINT_STIFFNESS = np.array([900.0, 800.0, 500.0, 400.0, 90.0, 60.0, 40.0])
TIP_STIFFNESS = np.array([2000.0] * 3 + [200.0] * 3)


@dataclass(frozen=True)
class Pushed:
    """Energies [J] at every sample, (k,) each, and the motion q, dq (k, n)."""

    t: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    law_loss: np.ndarray
    wall_loss: np.ndarray
    stored: np.ndarray
    hand_work: np.ndarray
    depth: np.ndarray

    @property
    def excess(self):
        """What the hand's work must be at least, less what it was: at most 0 where law and wall are passive."""
        return self.stored - self.stored[0] - self.hand_work


def pushed(dynamics, law, storage, wall, hand, q0, seconds, rate=1000, held=False, substeps=1):
    """The run from rest at q0, its reference; `hand(t)` (3,) [N] acts at the tip; the law continuous or held."""
    raw, n, rest, h = ungated(dynamics), q0.size, np.zeros(q0.size), 1.0 / (rate * substeps)
    steps = round(seconds * rate)

    def rates(t, y, tau):
        q, dq = y[:n], y[n : 2 * n]
        J = wall.touched(q)[1]
        tau = law(t, q, dq, q0, rest, rest) if tau is None else tau
        pressed, by_hand = wall(t, q, dq), J.T @ hand(t)
        works = (tau @ dq, pressed @ dq, by_hand @ dq)
        return np.concatenate([dq, raw.forward_dynamics(q, dq, tau + pressed + by_hand), works])

    y, rows = np.concatenate([q0, np.zeros(n + 3)]), []
    for k in range(steps * substeps + 1):
        t = k * h
        if k % substeps == 0:
            rows.append(y)
            tau = law(t, y[:n], y[n : 2 * n], q0, rest, rest) if held else None
        k1 = rates(t, y, tau)
        k2 = rates(t + h / 2, y + h / 2 * k1, tau)
        k3 = rates(t + h / 2, y + h / 2 * k2, tau)
        k4 = rates(t + h, y + h * k3, tau)
        y = y + h / 6 * (k1 + 2 * (k2 + k3) + k4)
        if not np.abs(y).max() < 1e3:
            break
    rows = np.array(rows)
    q, dq, (law_work, wall_work, hand_work) = rows[:, :n], rows[:, n : 2 * n], rows[:, 2 * n :].T
    spring = np.array([storage(x) for x in q])
    pressed = np.array([wall.energy(x) for x in q])
    height = dynamics.potential_energy(q) - dynamics.potential_energy(q0)
    kinetic = np.einsum("ki,kij,kj->k", dq, dynamics.mass_matrix(q), dq) / 2
    law_loss = height - law_work - (spring - spring[0])
    wall_loss = -wall_work - (pressed - pressed[0])
    return Pushed(
        np.arange(len(q)) / rate, q, dq, law_loss, wall_loss, kinetic + spring + pressed, hand_work, wall.depth(q)
    )


def table():
    """A table with friction below the tip."""
    height = lwr_dyn.forward_kinematics(ARM, HELD_POSE)[2, 3] - GAP
    return Wall(ARM, [0.0, 0.0, height], [0.0, 0.0, 1.0], friction=0.3)


def restless_hand(seed=1, level=8.0):
    """A force (3,) [N] of six frequencies up to 25 rad/s, that presses down with 10 N on average."""
    rng = np.random.default_rng(seed)
    size, omega, phase = rng.normal(size=(6, 3)), rng.uniform(1.0, 25.0, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
    return lambda t: level * (np.sin(omega * t + phase) @ size) + np.array([0.0, 0.0, -10.0])


def cartesian(xi=1.0, slip=None, **options):
    """The run of a Cartesian impedance without posture spring."""
    law = CartesianImpedance(ARM, ROAD_A, TIP_STIFFNESS[0], TIP_STIFFNESS[3], xi, posture=0.0)
    chosen = law if slip is None else lambda t, q, dq, *rest: slip(law(t, q, dq, *rest), dq)

    def storage(q):
        e = tip_offset(ARM, HELD_POSE, q)
        return e @ (TIP_STIFFNESS * e) / 2.0

    return pushed(ROAD_A, chosen, storage, table(), restless_hand(), HELD_POSE, **options)


def jointly(**options):
    """The run of a joint impedance."""

    def storage(q):
        return (HELD_POSE - q) @ (JOINT_STIFFNESS * (HELD_POSE - q)) / 2.0

    law = JointImpedance(ROAD_A, JOINT_STIFFNESS)
    return pushed(ROAD_A, law, storage, table(), restless_hand(), HELD_POSE, **options)
