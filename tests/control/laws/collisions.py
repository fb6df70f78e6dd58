"""Pushes that a momentum observer should find, and hours without one: what tests sample and `scripts/soak.py` counts.

The LWR 4+ runs the path IST clear of its stops under inverse dynamics (50 rad/s) at 1 kHz, its encoders with noise of
1e-5 rad and a velocity filter of 30 Hz. It knows of a load of 1 kg at the flange; the true load has up to 0.3 kg more
or less, and what there is more or less has its centre anywhere within 5 cm. The levels are those of this motion: bias
bound and 7 sigma.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import payload_parameters
from lwr_dyn.control.laws.observer import OFFSET, PAYLOAD, MomentumObserver, motion_threshold, observed
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.model.arm import Arm, arm_with_payload
from lwr_dyn.model.run import Motion, Run
from lwr_dyn.simulation.plant import Encoder, FilteredDifference
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.simulation.walls_and_pushes import Push
from lwr_dyn.trajectory.references.ist import ist_clear_reference

KNOWN, GAIN, RATE = 1.0, 50.0, 1000.0
ENCODER = Encoder(noise=1e-5, cutoff_hz=30.0)
KP, KD = 2500.0, 100.0
ONSET, LENGTH, RISE = 0.15, 0.2, 0.005
"""[s] A push begins after the observer has settled, lasts, and rises as the blow of a hard body does."""
FORCES = ((5.0, 15.0), (15.0, 30.0), (30.0, 60.0))
"""[N] Bands in which pushes are counted."""
PLACES = ("flange", "link_3")
"""The frame of link 3 stands in the elbow."""


@cache
def model() -> Arm:
    """The arm as controller and observer know it."""
    return arm_with_payload(lwr_dyn.load("lwr4plus"), KNOWN)


@cache
def path() -> object:
    return ist_clear_reference(lwr_dyn.load("lwr4plus"))


@cache
def levels() -> object:
    motion = path().sample(np.arange(1400) / 100.0)
    arm = model()
    return motion_threshold(arm, lwr_dyn.dynamics_of(arm), motion, PAYLOAD, ENCODER.noise, ENCODER.cutoff_hz)


def true_load(rng: np.random.Generator) -> tuple[float, np.ndarray]:
    """Mass [kg] and centre (3,) [m]: KNOWN, and up to PAYLOAD more or less within OFFSET of the flange's centre."""
    direction, error = rng.normal(size=3), rng.uniform(-PAYLOAD, PAYLOAD)
    centre = direction * (OFFSET * rng.uniform() ** (1 / 3) / np.linalg.norm(direction))
    return KNOWN + error, error * centre / (KNOWN + error)


@dataclass(frozen=True)
class Later:
    """A reference from `start` on."""

    whole: object
    start: float
    duration: float

    def sample(self, t):
        motion = self.whole.sample(t + self.start)
        return Motion(t, motion.q, motion.dq, motion.ddq)


@dataclass(frozen=True)
class Found:
    """One push: its force [N], where, after how long it was found [s] (None: not), and whether an alarm came before."""

    force: float
    at: str
    delay: float | None
    early: bool


def pushes(count: int, seed: int = 0) -> Iterator[Found]:
    """Pushes of random size, direction, moment and place, each in a run of its own."""
    rng, arm = np.random.default_rng(seed), model()
    for k in range(count):
        low, high = FORCES[k % len(FORCES)]
        force, at, direction = rng.uniform(low, high), PLACES[k // len(FORCES) % 2], rng.normal(size=3)
        mass, centre = true_load(rng)
        push = Push(arm, direction * (force / np.linalg.norm(direction)), ONSET, LENGTH, RISE, at)
        reference = Later(path(), rng.uniform(0.0, 13.0), ONSET + LENGTH)
        run = watched(reference, mass, centre, external=push, encoder=ENCODER, seed=int(rng.integers(2**31)))
        alarm = run.t[run.signals["collision"][:, 0] > 0.0]
        later = alarm[alarm > ONSET]
        yield Found(force, at, float(later[0] - ONSET) if later.size else None, bool((alarm <= ONSET).any()))


def watched(reference: object, mass: float, centre: np.ndarray, **options: object) -> Run:
    """A run of the arm with a load, under the law with its observer."""
    arm, dynamics = model(), lwr_dyn.dynamics_of(model())
    law = observed(InverseDynamics(dynamics, KP, KD), arm, dynamics, observer_gain=GAIN, observer_threshold=levels())
    plant = lwr_dyn.load("lwr4plus")
    return simulate(arm, law, reference, plant=plant, payload=mass, payload_com=centre, **options)


def table(found: Iterable[Found]) -> list[tuple[str, str, int, int, float, float]]:
    """Place, band, pushes, found, median and 95 % delay [ms] of those found."""
    rows, found = [], list(found)
    for at in PLACES:
        for low, high in FORCES:
            part = [f for f in found if f.at == at and low <= f.force < high]
            delays = [1e3 * f.delay for f in part if f.delay is not None] or [np.nan]
            rows.append((at, f"{low:g} to {high:g} N", len(part), sum(f.delay is not None for f in part),
                         float(np.median(delays)), float(np.percentile(delays, 95))))  # fmt: skip
    return rows


@dataclass(frozen=True)
class Quiet:
    """A time without a push: [h] in all, alarms, the largest estimate of each joint as a share of its level (n,)."""

    hours: float
    alarms: int
    worst: np.ndarray


def quiet(lanes: int, seconds: float = 14.0, seed: int = 0, noise: float = ENCODER.noise) -> Quiet:
    """Many runs at once without a push, each with its own load error and noise, by compiled kernels.

    Torque limits and stops are left out; the path keeps far from both.
    """
    rng, arm, h = np.random.default_rng(seed), model(), 1 / RATE
    bare = lwr_dyn.load("lwr4plus")
    knows, plant = lwr_dyn.batch_dynamics(arm), lwr_dyn.batch_dynamics(bare, inputs=["payload"])
    load = np.array([payload_parameters(*true_load(rng)) for _ in range(lanes)])
    t = np.arange(round(seconds * RATE) + 1) * h
    motion = path().sample(t)
    q, dq = np.tile(motion.q[0], (lanes, 1)), np.tile(motion.dq[0], (lanes, 1))
    velocity, observer = FilteredDifference(ENCODER.cutoff_hz, RATE), MomentumObserver(lwr_dyn.dynamics_of(arm), GAIN)
    observer.sample_every(h)
    level, worst = levels().level(observer.gain, h), np.zeros((lanes, arm.n))
    velocity._last, velocity._value = q + rng.normal(0.0, noise, q.shape), dq
    tau = np.zeros_like(q)

    def forward(x, v):
        return plant.forward_dynamics(x, v, tau, payload=load)

    for k in range(len(t)):
        seen = velocity._last if k == 0 else q + rng.normal(0.0, noise, q.shape)
        speed = dq.copy() if k == 0 else velocity(seen)
        p = np.einsum("kij,kj->ki", knows.mass_matrix(seen), speed)
        b = np.einsum("kij,ki->kj", knows.coriolis_matrix(seen, speed), speed) - knows.gravity_vector(seen)
        r = observer.advance(p, b, tau)
        np.maximum(worst, np.abs(r), out=worst)
        y = KP * (motion.q[k] - seen) + KD * (motion.dq[k] - speed) + motion.ddq[k]
        tau = knows.inverse_dynamics(seen, speed, y)
        k1 = forward(q, dq)
        k2 = forward(q + h / 2 * dq, dq + h / 2 * k1)
        k3 = forward(q + h / 2 * dq + h * h / 4 * k1, dq + h / 2 * k2)
        k4 = forward(q + h * dq + h * h / 2 * k2, dq + h * k3)
        q, dq = q + h * dq + h * h / 6 * (k1 + k2 + k3), dq + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    share = worst / level
    return Quiet(lanes * seconds / 3600.0, int((share > 1.0).any(axis=1).sum()), share.max(axis=0))


def alone(seconds: float, seed: int = 0) -> np.ndarray:
    """`quiet` of one lane without noise by `simulate`: the largest estimate of each joint as a share of its level."""
    load, encoder = true_load(np.random.default_rng(seed)), Encoder(cutoff_hz=ENCODER.cutoff_hz)
    run = watched(path(), *load, duration=seconds, encoder=encoder)
    return np.abs(run.signals["external_torque"]).max(axis=0) / levels().level(np.full(model().n, GAIN), 1 / RATE)
