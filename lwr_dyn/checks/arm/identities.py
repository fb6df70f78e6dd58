"""Identities that hold for every arm's equations of motion, over random states, to machine precision.

Derivatives are complex steps of the hand-written recursion (it takes complex numbers), so they are exact: no tolerance
hides the error of a difference quotient.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from lwr_dyn.checks.arm.verdict import Verdict
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.protocol import Dynamics, mechanical_energy, singular_joint
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import ShapeError, SingularMassError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.vectors import Vector

SPEED, ACCELERATION = 2.0, 10.0
"""Half-widths of the random joint speeds and accelerations [rad/s, rad/s^2]."""
EXACT = 1e-12
"""Relative: a few hundred roundings of 1e-16 in a recursion over a handful of links."""
FLOOR = 1e-3
"""Smallest scale of a comparison of g or C, as a share of the arm's largest torque (or B times speed): some arms have
no gravity torque or no Coriolis terms, only roundings of zero."""
LEVER = 1e-2
"""The same as a share of the whole mass on the whole length: the recursion carries each force along the links, and
where its moment cancels (a wheel that turns about its own centre), the rounding of the force stays."""
STEP = 1e-30
"""Complex step: there is no subtraction, so it may be as small as floats allow."""
SECONDS, RTOL = 2.0, 1e-12
DRIFT = 1e-8
"""[J] A swing exchanges tens of joules, of which DOP853 at rtol 1e-12 loses about 1e-10."""
EVALUATIONS = 50_000
"""Of forward dynamics in one swing, some seconds of computing: light links on stiff ratios would take minutes."""
SLIDE = 2.0
"""[m] Half width of the range from which positions of a sliding joint are drawn: a mobile base may go a kilometre, and
differences of positions then round at 1e-13 m."""


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """q, dq, ddq, (count, n) each."""

    q: Array
    dq: Array
    ddq: Array


def random_states(arm: Arm, count: int, seed: int) -> States:
    """Joint positions uniform inside `sampled_box`, speeds and accelerations uniform."""
    rng = np.random.default_rng(seed)
    lower, upper = sampled_box(arm)
    q = rng.uniform(lower, upper, (count, arm.n))
    dq = rng.uniform(-SPEED, SPEED, (count, arm.n))
    return States(q, dq, rng.uniform(-ACCELERATION, ACCELERATION, (count, arm.n)))


def sampled_box(arm: Arm) -> tuple[Array, Array]:
    """Lower and upper ends (n,) [rad, m] between which positions are drawn.

    The limits; +-pi [rad or m] where they are unknown. A range wider than four turns or 2 `SLIDE` is cut to that width
    about 0, or about its own point nearest to 0.
    """
    lower = np.where(np.isfinite(arm.lower), arm.lower, np.minimum(-np.pi, arm.upper - np.pi))
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.maximum(np.pi, lower + np.pi))
    slides = np.array([link.kind is JointKind.PRISMATIC for link in arm.chain.links])
    half = np.where(slides, SLIDE, 4.0 * np.pi)
    wide = upper - lower > 2.0 * half
    middle = np.clip(0.0, np.where(wide, lower + half, lower), np.where(wide, upper - half, upper))
    return np.where(wide, middle - half, lower), np.where(wide, middle + half, upper)


def box_note(arm: Arm) -> str:
    """What `sampled_box` cut; empty where it is the box of the limits."""
    lower, upper = sampled_box(arm)
    cut = np.isfinite(arm.lower) & np.isfinite(arm.upper) & ((lower > arm.lower) | (upper < arm.upper))
    ranges = zip(arm.joint_names, lower, upper, strict=True)
    parts = [f"{name} {low:g} to {up:g}" for (name, low, up), x in zip(ranges, cut, strict=True) if x]
    return f"states are drawn from a part of the limits: {', '.join(parts)} (rad, m)" if parts else ""


def mass_matrix_identities(dynamics: Dynamics, states: States) -> list[Verdict]:
    """B is symmetric and positive definite; its columns are inverse dynamics of unit accelerations."""
    B = dynamics.mass_matrix(states.q)
    joint = singular_joint(B)
    smallest = float(np.linalg.eigvalsh(B).min()) if joint is None else 0.0
    g = dynamics.gravity_vector(states.q)
    unit = np.eye(dynamics.n)
    columns = dynamics.inverse_dynamics(states.q[:, None, :], np.zeros(dynamics.n), unit) - g[:, None, :]
    return [
        Verdict("mass matrix: symmetric", relative(B, np.swapaxes(B, -1, -2)), EXACT, "relative"),
        Verdict("mass matrix: smallest eigenvalue", smallest, 0.0, "kg m^2", "above"),
        Verdict(
            "mass matrix: columns against unit accelerations",
            relative(B, np.swapaxes(columns, -1, -2)),
            EXACT,
            "relative",
        ),
    ]


def velocity_identities(dynamics: Dynamics, recursion: Recursion, states: States) -> list[Verdict]:
    """dB/dt = C + C^T, and C dq + g is the bias torque."""
    C = dynamics.coriolis_matrix(states.q, states.dq)
    dB = mass_matrix_rate(recursion, states.q, states.dq)
    floor, torque = coriolis_floor(recursion, states), torque_floor(recursion, states)
    h = dynamics.bias_torque(states.q, states.dq)
    bias = np.einsum("kij,kj->ki", C, states.dq) + dynamics.gravity_vector(states.q)
    return [
        Verdict("power balance: dB/dt = C + C^T", relative(dB, C + np.swapaxes(C, -1, -2), floor), EXACT, "relative"),
        Verdict("bias torque: C dq + g", relative(h, bias, torque), EXACT, "relative"),
    ]


def gravity_identity(dynamics: Dynamics, recursion: Recursion, states: States) -> Verdict:
    """g = dU/dq, with U from the positions of the centres of mass."""
    g, gradient = dynamics.gravity_vector(states.q), potential_gradient(recursion, states.q)
    return Verdict(
        "gravity torque: g = dU/dq", relative(g, gradient, torque_floor(recursion, states)), EXACT, "relative"
    )


def torque_floor(recursion: Recursion, states: States) -> float:
    """`FLOOR` of the largest torque of these states, or `LEVER` of the weight at the arm's whole length [N m]."""
    largest = float(np.abs(recursion.inverse_dynamics(states.q, states.dq, states.ddq)).max())
    mass, length = _size(recursion)
    weight = mass * _norm(recursion.gravity)
    return max(FLOOR * largest, LEVER * weight * length)


def coriolis_floor(recursion: Recursion, states: States) -> float:
    """`FLOOR` of the largest B, or `LEVER` of the mass at the arm's whole length, times the speed [N m s/rad]."""
    mass, length = _size(recursion)
    largest = float(np.abs(recursion.mass_matrix(states.q)).max())
    return max(FLOOR * largest, LEVER * mass * length**2) * float(np.abs(states.dq).max())


def _size(recursion: Recursion) -> tuple[float, float]:
    """Mass [kg] and length [m] of a chain: joint to joint, and the farthest centre of mass."""
    length = sum(_norm(link.shift_before) + _norm(link.shift) for link in recursion.links)
    beyond = max(_norm(link.com) for link in recursion.links)
    return float(sum(link.mass for link in recursion.links)), length + beyond


def _norm(vector: Vector) -> float:
    return float(np.linalg.norm([vector.x, vector.y, vector.z]))


def mass_matrix_rate(recursion: Recursion, q: Array, dq: Array) -> Array:
    """dB/dt along dq, exact, (..., n, n)."""
    rate: Any = recursion.mass_matrix(q + 1j * STEP * dq)
    return np.asarray(rate.imag / STEP, dtype=np.float64)


def potential_gradient(recursion: Recursion, q: Array) -> Array:
    """dU/dq, exact, (..., n)."""
    steps: Any = q[..., None, :] + 1j * STEP * np.eye(q.shape[-1])
    return np.asarray(recursion.potential_energy(steps).imag / STEP, dtype=np.float64)


def relative(a: Array, b: Array, floor: float = 0.0) -> float:
    """Largest difference over the largest entry of both, or over `floor` if that is more; 0 when all vanish.

    >>> relative(np.array([1.0, 2.0]), np.array([1.0, 2.5]))
    0.2
    """
    scale = max(float(np.abs(a).max(initial=0.0)), float(np.abs(b).max(initial=0.0)), floor)
    return 0.0 if scale == 0.0 else float(np.abs(a - b).max()) / scale


def energy_drift(dynamics: Dynamics, q: Array, dq: Array, seconds: float = SECONDS) -> float:
    """Largest |E(t) - E(0)| [J] of a free swing from (q, dq), adaptive DOP853 at rtol 1e-12."""
    return _swing(dynamics, q, dq, seconds)[0]


def _swing(dynamics: Dynamics, q: Array, dq: Array, seconds: float) -> tuple[float, float]:
    """The energy drift [J] and the time that the swing came to [s]: `EVALUATIONS` end it."""
    n, none = dynamics.n, np.zeros(dynamics.n)

    def rates(_: float, x: Array) -> Array:
        return np.concatenate([x[n:], dynamics.forward_dynamics(x[:n], x[n:], none)])

    solver = DOP853(rates, 0.0, np.concatenate([q, dq]), seconds, rtol=RTOL, atol=RTOL)
    states = [solver.y]
    try:
        while solver.status == "running" and solver.nfev < EVALUATIONS:
            solver.step()
            states.append(solver.y)
    except (ShapeError, SingularMassError):  # a state that is not finite
        return float("nan"), float(solver.t)
    if solver.status == "failed":
        return float("nan"), float(solver.t)
    x = np.array(states)
    energies = mechanical_energy(dynamics, x[:, :n], x[:, n:])
    return float(np.abs(energies - energies[0]).max()), float(solver.t)


def swing_verdict(dynamics: Dynamics, q: Array, dq: Array) -> Verdict:
    """The energy drift: nothing drives or brakes the arm, so kinetic plus potential energy is constant."""
    drift, seconds = _swing(dynamics, q, dq, SECONDS)
    return Verdict(f"energy drift of a free swing, {seconds:.3g} s", drift, DRIFT, "J")
