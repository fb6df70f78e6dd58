"""Arms with elastic joints as matrices: near rest, and frozen at a moving state; continuous poles of their loops.

    M(q) ddq + C dq + g = tau_J,   B_m ddtheta + tau_J = u,   tau_J = K (theta - q) + D (dtheta - dq)

with M the inertia of the links alone (B(q) less the rotors' B_m). Deviations z = (q, theta, dq, dtheta) from a state
of the links (q, dq, ddq), with the motors at theta = q + tau_J / K, follow dz/dt = A z + B u. At rest this is exact to
first order; frozen where the arm moves, the matrices of one moment are taken as constant: an indication, no proof. This
is Spong's reduced model: the rotors turn about axes that rest. Dry friction, torque limits and stops are left out, so a
loop that is unstable here may swing on within its torque limits.

References
----------
Spong, ASME J. Dynamic Systems, Measurement, and Control 109 (1987) 310.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.control.gains import Linearised
from lwr_dyn.control.protocol import Controller, JointReadings, WithJointSensors, describe, reset
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, RestingPlant, Sampling
from lwr_dyn.design.sampled_stability import joint_box, wilson_interval
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, Reference
from lwr_dyn.model.transmission import JointElasticity, chosen_elasticity
from lwr_dyn.simulation.setup import ENCODERS

STEP = 1e-4
"""[rad, rad/s] of the central differences of inverse dynamics."""

LAW_STEP = 1e-5
"""[rad, rad/s] of the central differences of a law, which springs of 1e4 N m/rad turn into 0.1 N m."""

Poles = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class ElasticArm:
    """An arm with elastic joints: `dynamics` of the rigid arm, springs and dampers, rotors B_m (n,) [kg m^2], encoders.

    Raises `OptionError`: encoders on no side of "motor" and "link"; a joint without rotor inertia.
    """

    dynamics: Dynamics
    elasticity: JointElasticity
    rotor: Array
    encoders: str = "motor"

    def __post_init__(self) -> None:
        if self.encoders not in ENCODERS:
            raise OptionError("encoders", repr(self.encoders), " or ".join(ENCODERS))
        light = np.flatnonzero(~(self.rotor > 0.0))
        if light.size:
            name, value = f"rotor inertia of joint {light[0] + 1}", self.rotor[light[0]]
            raise OptionError(name, f"{value:g} kg m^2", "above 0 where the joint is elastic")

    @classmethod
    def of(cls, arm: Arm, elasticity: JointElasticity | str | float = "file", encoders: str = "motor") -> Self:
        """The arm with the stiffness of its file, or another; see `chosen_elasticity`, which says what it raises."""
        chosen = chosen_elasticity(arm, elasticity)
        if chosen is None:
            raise MissingDataError(arm.name, "joint stiffness", "elastic joints")
        return cls(dynamics_of(arm), chosen, arm.armature, encoders)

    def spring_side(self, motion: Motion) -> Array:
        """theta (k, n) [rad] of the motors where the links move so, to within the speed of the deflection."""
        torque = self.dynamics.inverse_dynamics(motion.q, motion.dq, motion.ddq) - self.rotor * motion.ddq
        return np.asarray(motion.q + torque / self.elasticity.stiffness)

    def plant(self, motion: Motion) -> RestingPlant:
        """A and B frozen at k states of the links, with torque sensors.

        Raises `OptionError` where the mass matrix of the links is singular.
        """
        (k, n), one = motion.q.shape, np.eye(self.dynamics.n)
        try:
            inverse = np.linalg.inv(self.dynamics.mass_matrix(motion.q) - np.diag(self.rotor))
        except np.linalg.LinAlgError:
            raise OptionError("mass matrix of the links", "singular", "links with inertia at every joint") from None
        by_q, by_dq = self._slopes(motion)
        K, D = np.diag(self.elasticity.stiffness), np.diag(self.elasticity.damping)
        gear = np.hstack([-K, K, -D, D])  # tau_J = gear z
        A, B = np.zeros((k, 4 * n, 4 * n)), np.zeros((k, 4 * n, n))
        A[:, : 2 * n, 2 * n :] = np.eye(2 * n)
        A[:, 2 * n : 3 * n] = inverse @ gear
        A[:, 2 * n : 3 * n, :n] -= inverse @ by_q
        A[:, 2 * n : 3 * n, 2 * n : 3 * n] -= inverse @ by_dq
        A[:, 3 * n :], B[:, 3 * n :] = -gear / self.rotor[:, None], one / self.rotor[:, None]
        read = self._read(self.encoders == "motor")
        return RestingPlant(A, B, *read, np.broadcast_to(gear, (k, n, 4 * n)))

    def loop(self, controller: Linearised, q: Array) -> RestingLoop:
        """The loop at rest at the link poses q (k, n), the law linearised at what it reads there; raises as `plant`."""
        rest = at_rest(q)
        motor = self.encoders == "motor" or controller.linear_feedback(q[:1]).motor
        seen = self.spring_side(rest) if motor else q
        plant, (position, velocity) = self.plant(rest), self._read(motor)
        plant = RestingPlant(plant.A, plant.B, position, velocity, plant.torque)
        return RestingLoop.of_plant(plant, controller.linear_feedback(seen), seen)

    def frozen_poles(self, controller: Controller, motion: Motion) -> Poles:
        """Poles (k, 4n) [1/s] frozen at k samples of a motion that the links follow exactly, largest real part first.

        The law, with the motion as its reference, acts continuously with its memory held; it is differentiated by
        central differences of its torque, so it needs no linear form. Raises as `plant`.
        """
        plant, n = self.plant(motion), self.dynamics.n
        states = np.concatenate([motion.q, self.spring_side(motion), motion.dq, motion.dq], axis=1)
        steps = LAW_STEP * np.eye(4 * n)
        for k, z in enumerate(states):
            ahead, behind = (
                np.array([self._torque(controller, motion, k, z + s * step) for step in steps]) for s in (1.0, -1.0)
            )
            plant.A[k] += plant.B[k] @ (ahead - behind).T / (2 * LAW_STEP)
        return by_growth(plant.A)

    def _torque(self, controller: Controller, motion: Motion, k: int, z: Array) -> Array:
        """What the law commands at sample k of its reference in the state z (4n,)."""
        q, theta, dq, dtheta = z.reshape(4, -1)
        if isinstance(controller, WithJointSensors):
            gear = self.elasticity.stiffness * (theta - q) + self.elasticity.damping * (dtheta - dq)
            controller.sense(JointReadings(theta, dtheta, q, dq, gear))
        seen = (theta, dtheta) if self.encoders == "motor" else (q, dq)
        return controller(float(motion.t[k]), *seen, motion.q[k], motion.dq[k], motion.ddq[k])

    def _read(self, motor: bool) -> tuple[Array, Array]:
        """Position and speed of a side in z, (n, 4n) each."""
        n = self.dynamics.n
        return np.eye(n, 4 * n, n * motor), np.eye(n, 4 * n, n * (2 + motor))

    def _slopes(self, motion: Motion) -> tuple[Array, Array]:
        """Derivatives (k, n, n) of inverse dynamics by q and by dq: column j is by joint j."""
        step, torque = STEP * np.eye(self.dynamics.n), self.dynamics.inverse_dynamics
        q, dq, ddq = motion.q[:, None], motion.dq[:, None], motion.ddq[:, None]
        by_q = torque(q + step, dq, ddq) - torque(q - step, dq, ddq)
        by_dq = torque(q, dq + step, ddq) - torque(q, dq - step, ddq)
        return np.swapaxes(by_q, -1, -2) / (2 * STEP), np.swapaxes(by_dq, -1, -2) / (2 * STEP)


def at_rest(q: Array) -> Motion:
    """Poses q (k, n) as samples of a motion at rest."""
    none = np.zeros_like(q)
    return Motion(np.zeros(len(q)), q, none, none)


def continuous_poles(loop: RestingLoop) -> Poles:
    """Poles (k, N) [1/s] of a loop at rest whose law acts continuously, the largest real part first.

    With an integral N is n more than the plant's. Where no torque sensors stand, a law that asks for them reads its own
    torque.
    """
    plant, law = loop.plant, loop.feedback
    k, N, n = plant.B.shape
    back = law.position @ plant.position + law.velocity @ plant.velocity
    if law.torque is not None and plant.torque is not None:
        back = back + law.torque @ plant.torque
    elif law.torque is not None:
        back = np.asarray(np.linalg.solve(np.eye(n) + law.torque, back), dtype=np.float64)
    closed = np.asarray(plant.A - plant.B @ back, dtype=np.float64)
    if law.integral is not None:
        augmented = np.zeros((k, N + n, N + n))
        augmented[:, :N, :N], augmented[:, :N, N:] = closed, plant.B
        integral = np.diag(law.integral) if law.integral.ndim == 1 else law.integral
        augmented[:, N:, :N] = -integral @ plant.position
        closed = augmented
    return by_growth(closed)


def by_growth(A: Array) -> Poles:
    """Eigenvalues (k, N) of matrices (k, N, N), those with the largest real part first."""
    poles = np.asarray(np.linalg.eigvals(A), dtype=np.complex128)
    return np.take_along_axis(poles, np.argsort(-poles.real, axis=-1, kind="stable"), axis=-1)


POSES, SEED = 2000, 0

GROWTH = 1e-6
"""[1/s] A pole with a larger real part counts as unstable."""


class LinearisedController(Controller, Linearised, Protocol):
    """A controller with a linear form."""


Law = tuple[LinearisedController, str]
"""A controller, and the side that the encoders read."""


@dataclass(frozen=True, slots=True)
class ElasticShares:
    """Of `poses` at rest, how many are unstable where the law acts continuously, and sampled; the worst of each."""

    poses: int
    continuous: int
    sampled: int
    growth: float
    """The largest real part of all continuous poles [1/s]."""
    radius: float
    """The largest spectral radius of the sampled loop."""

    @property
    def intervals(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The shares of the whole box at 95 %, continuous and sampled."""
        return wilson_interval(self.continuous, self.poses), wilson_interval(self.sampled, self.poses)


def elastic_shares(
    arm: ElasticArm, controller: Linearised, q: Array, sampling: Sampling | None = None
) -> ElasticShares:
    """How many of the link poses q (k, n) are unstable at rest; raises as `ElasticArm.loop`."""
    loop = arm.loop(controller, q)
    growth, radius = continuous_poles(loop)[:, 0].real, loop.radius(sampling or Sampling())
    unstable = int((growth > GROWTH).sum()), int((radius > GROWS).sum())
    return ElasticShares(len(q), *unstable, float(growth.max()), float(radius.max()))


def elastic_table(
    arm: Arm,
    laws: Sequence[Law],
    stiffness: Sequence[JointElasticity | str | float],
    reference: Reference,
    t: float,
    sampling: Sampling | None = None,
    poses: int = POSES,
    seed: int = SEED,
) -> Table:
    """Every law on every stiffness: its largest pole frozen at t [s] of a reference, and unstable shares of the box.

    Parameters
    ----------
    arm : Arm
        Its limits are the box.
    laws : sequence of (controller, "motor" or "link")
        Controllers with a linear form, and the side that the encoders read.
    stiffness : sequence of "file", float or JointElasticity
        The largest stiffness [N m/rad] of each case.
    reference : Reference
    t : float
        [s]
    sampling : Sampling, optional
        1 kHz without delay if not given.
    poses, seed : int
        Number of poses drawn evenly, and the seed of the drawing.

    Raises
    ------
    OptionError, MissingDataError
        As `ElasticArm.of` and its `plant`.
    """
    sampling, motion = sampling or Sampling(), reference.sample(np.array([t]))
    lower, upper, _ = joint_box(arm)
    q = np.random.default_rng(seed).uniform(lower, upper, (poses, arm.n))
    rows = []
    for case in stiffness:
        for controller, side in laws:
            plant = ElasticArm.of(arm, case, side)
            reset(controller)
            pole = plant.frozen_poles(controller, motion)[0, 0]
            found = elastic_shares(plant, controller, q, sampling)
            shares = [_share(count, poses) for count in (found.continuous, found.sampled)]
            rows.append(
                (float(plant.elasticity.stiffness.max()), describe(controller)["name"], side, pole.real, *shares)
            )
    late = {0: "", 1: ", late by 1 sample"}.get(sampling.delay, f", late by {sampling.delay} samples")
    headings = (
        Heading("K", "N m/rad", "g"), "law", "reads", Heading(f"pole at {t:g} s", "1/s", "+.1f"),
        "unstable, continuous", f"unstable, {sampling.rate:g} Hz{late}",
    )  # fmt: skip
    title = f"{arm.name}, reading {arm.reading}, elastic joints: largest real part of the poles, and unstable at rest"
    note = f"of {poses} poses drawn evenly from the joint box (seed {seed}), with the share of the box at 95 %"
    return Table(title, headings, rows, note)


def _share(found: int, poses: int) -> str:
    """A share with its interval at 95 %.

    >>> _share(0, 2000), _share(209, 2000)
    ('0 (below 0.2 %)', '10.4 % (9.2 to 11.9 %)')
    """
    low, high = (100 * x for x in wilson_interval(found, poses))
    if found in (0, poses):
        return f"0 (below {high:.1f} %)" if found == 0 else f"all (above {low:.1f} %)"
    return f"{100 * found / poses:.1f} % ({low:.1f} to {high:.1f} %)"
