"""`Loop`: what closes a loop; `prepare`: arm, controller, reference and loop, checked, as a `Setup` that can be run."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass
from enum import Enum
from math import ceil, isfinite
from pathlib import Path
from typing import Annotated, Any, NotRequired, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import Controller, WithMemory, describe
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, arm_argument, joint_array, read_only
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.foundation.version import VERSION, package_version
from lwr_dyn.model.arm import Arm, arm_with_payload
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Motion, Reference, reference_argument, short_repr
from lwr_dyn.model.transmission import JointElasticity, chosen_elasticity
from lwr_dyn.simulation.arm_friction import FrictionOption, braking_rate, chosen_friction
from lwr_dyn.simulation.audit import AuditRecord
from lwr_dyn.simulation.integrators import Integrator, dop853, rk4
from lwr_dyn.simulation.plant import Encoder, ExternalTorque, Plant, Sensor, checked_external, plant_of

MOST_SUBSTEPS = 1000

MOST_DELAY = 100

MOST_SAMPLES = 1e7
"""A run of more does not fit a common memory: 7 joints take 0.5 kB a sample."""

METHODS = ("rk4", "dop853", "radau")

ENCODERS = ("motor", "link")
"""Sides of elastic joints."""

GRID = 1e-9
"""Share of a step by which a duration may miss the grid of samples."""

STABLE = 2.7
"""Product of rate and step up to which RK4 is stable on the negative real axis (2.785)."""


def check_whole(name: str, value: Any, least: int, most: int | None = None) -> None:
    """Raise `OptionError` unless `value` is a whole number in the range."""
    if not (isinstance(value, int) and value >= least and (most is None or value <= most)):
        raise OptionError(name, value, f"a whole number from {least} {'on' if most is None else f'to {most}'}")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Loop:
    """What closes a loop around an arm, a controller and a reference; each field as `lwr_dyn.simulate` explains it.

    Raises `OptionError`: a field outside what is allowed, or that would do nothing beside the others.
    """

    rate: float = 1000.0
    method: str = "rk4"
    substeps: int = 1
    rtol: float = 1e-12
    continuous: bool = False
    engine: str | Dynamics = "pinocchio"
    plant: Arm | None = None
    payload: float = 0.0
    payload_com: ArrayLike = (0.0, 0.0, 0.0)
    payload_inertia: ArrayLike | None = None
    friction: FrictionOption = "set-valued"
    external: ExternalTorque | None = None
    elasticity: JointElasticity | str | float | None = None
    encoders: str = "motor"
    encoder: Encoder | None = None
    saturate: bool = True
    position_limits: bool = True
    allow_unphysical: bool = False
    seed: int = 0
    delay: int = 0
    loop: str | None = None
    duration: float | None = None
    q0: ArrayLike | None = None
    dq0: ArrayLike | None = None
    meta: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        for name in ("rate", "rtol"):
            value = getattr(self, name)
            if not (isinstance(value, float | int) and isfinite(value) and value > 0.0):
                raise OptionError(name, value, "a number above 0")
        for name, rows in (("method", METHODS), ("encoders", ENCODERS)):
            if getattr(self, name) not in rows:
                raise OptionError(name, repr(getattr(self, name)), ", ".join(rows))
        for name, least, most in (("substeps", 1, MOST_SUBSTEPS), ("seed", 0, None), ("delay", 0, MOST_DELAY)):
            check_whole(name, getattr(self, name), least, most)
        for name, is_given in (("method", self.method == "radau"), ("encoders", self.encoders != ENCODERS[0])):
            if is_given and self.elasticity is None:
                raise OptionError(name, "would do nothing with rigid joints", "with elastic joints")

    def check(self, controller: Controller) -> None:
        """A continuous run needs a controller without hidden memory, the true state, no delay; raises `OptionError`."""
        if not self.continuous:
            if self.encoder is not None:
                self.encoder.velocity_filter(self.rate)  # raises where it is too slow for the rate
            return
        if self.delay:
            raise OptionError("delay", f"{self.delay} samples in a continuous run", "0, or a sampled run")
        if self.encoder is not None:
            raise OptionError("encoder", "given for a continuous run", "a sampled run: an encoder is read at instants")
        if hasattr(controller, "reset") and not isinstance(controller, WithMemory):
            raise OptionError(
                "continuous", "with a controller that remembers between calls",
                "a sampled run, or a controller with `torque_and_rate` and `memory_size`",
            )  # fmt: skip

    def integrator(self) -> Integrator:
        """The method."""
        return rk4(self.substeps) if self.method == "rk4" else dop853(self.rtol, self.rtol / 10)

    def times(self, duration: float) -> Array:
        """Samples from 0 to the first one not before `duration` [s]; raises `OptionError` unless it is above 0."""
        if not (isfinite(duration) and duration > 0.0):
            raise OptionError("duration", duration, "a number above 0, in s")
        if duration * self.rate > MOST_SAMPLES:
            samples = f"{self.rate:g} samples a second over {duration:g} s"
            raise OptionError("rate, duration", samples, f"at most {MOST_SAMPLES:.0e} samples in all")
        steps = max(1, int(np.ceil(duration * self.rate - GRID)))
        if self.delay > steps:
            raise OptionError("delay", f"{self.delay} samples in a run of {steps}", "a delay shorter than the run")
        return np.arange(steps + 1) / self.rate

    def loaded(self, arm: Arm) -> Arm:
        """An arm with the payload, if there is any."""
        if self.payload == 0.0:
            return arm
        return arm_with_payload(arm, self.payload, self.payload_com, self.payload_inertia)

    @property
    def load(self) -> dict[str, Any] | None:
        """The payload as JSON values."""
        if self.payload == 0.0:
            return None
        com, inertia = (
            None if x is None else np.asarray(x, dtype=float).tolist() for x in (self.payload_com, self.payload_inertia)
        )
        return {"mass": float(self.payload), "com": com, "inertia": inertia}

    @property
    def engine_name(self) -> str:
        """The plant's engine."""
        own: Any = self.engine
        return own if isinstance(own, str) else str(getattr(own, "name", type(own).__name__))


OPTIONS = (
    "rate", "method", "substeps", "rtol", "continuous", "saturate", "position_limits", "allow_unphysical", "seed",
    "delay",
)  # fmt: skip
"""Fields of a `Loop` that stand under "options" in the record of a run."""


_KEPT, LONGEST = 16, 50_000
"""Motions that are kept, and samples of the longest: 150 MB at most."""

_motions: dict[tuple[Any, int, float], Motion] = {}


def known_motion(reference: Reference, t: Array) -> Motion:
    """The reference at times from 0 on in equal steps, (k,) [s]: following a path in space takes longer than a run.

    A motion is kept where nothing here changes it: the reference is made of this package's frozen records, numbers and
    read-only arrays alone, and of lists and mappings of them, which are taken as they were. A user's own, or one that
    calls a function of a user, is sampled at every call.
    """
    key = reference, len(t), float(t[-1])
    try:
        known = _motions.get(key)
    except TypeError:  # it cannot be hashed
        return reference.sample(t)
    if known is not None:
        return known
    motion = reference.sample(t)
    if len(t) <= LONGEST and _is_fixed(reference):
        for old in list(_motions)[: max(0, 1 + len(_motions) - _KEPT)]:
            _motions.pop(old, None)
        _motions[key] = motion
    return motion


def _is_fixed(x: Any) -> bool:
    """Whether an object and all that it holds are of those kinds."""
    if isinstance(x, str | float | int | Enum | Path | None):
        return True
    if isinstance(x, np.ndarray):
        return not x.flags.writeable
    if isinstance(x, tuple | frozenset | list | Mapping):
        return all(map(_is_fixed, [*x.keys(), *x.values()] if isinstance(x, Mapping) else x))
    own: Any = type(x)
    if not (is_dataclass(x) and own.__module__.startswith("lwr_dyn.") and own.__dataclass_params__.frozen):
        return False
    return all(_is_fixed(getattr(x, each.name)) for each in fields(x))


def sampled_reference(reference: Reference, t: Array, n: int) -> Motion:
    """The reference at every sample in one call; raises `ShapeError` when it is for another number of joints."""
    motion = known_motion(reference, t)
    for name in ("q", "dq", "ddq"):
        shape = getattr(motion, name).shape
        if shape != (t.size, n):
            raise ShapeError(f"reference {name}", f"shape {shape}", f"({t.size}, {n})")
    return motion


def start_state(plant: Plant, motion: Motion, q0: ArrayLike | None, dq0: ArrayLike | None) -> Array:
    """The state (q, dq) in which the run begins, (2, n): on the reference if not given.

    Raises `ShapeError`, or `OptionError` for a start outside the position limits.
    """
    q = joint_array("q0", motion.q[0] if q0 is None else q0, plant.n)
    dq = joint_array("dq0", motion.dq[0] if dq0 is None else dq0, plant.n)
    outside = np.flatnonzero(plant.beyond(q))
    if outside.size:
        j = int(outside[0])
        allowed = f"{plant.lower[j]:.6g} to {plant.upper[j]:.6g}, or position_limits=False"
        raise OptionError(f"q0 of {plant.arm.joint_names[j]}", f"{q[j]:.6g}", allowed)
    return np.array([q, dq])


def friction_rate(plant: Plant, q: Array, loop: Loop) -> float:
    """Fastest rate at which friction brakes [1/s], the largest eigenvalue of B(q)^-1 diag(slope), where a run begins.

    Raises `OptionError` where RK4's step is too long for it: the motion would grow instead of coming to rest.
    """
    form, slope = plant.friction.form, plant.friction.slope
    if not slope.any():
        return 0.0
    rate = float(braking_rate(plant.ungated.mass_matrix(q), slope))
    step = 1.0 / (loop.rate * loop.substeps)
    if loop.method == "rk4" and rate * step > STABLE:
        need = ceil(rate / loop.rate / STABLE)
        other = ", or friction set-valued" if form == "smooth" else ""
        fault = f"{form}, brakes at up to {rate:.4g} 1/s, too fast for RK4 steps of {step:.3g} s"
        raise OptionError("friction", fault, f"substeps from {need} on, method dop853{other}")
    return rate


def arm_record(arm: Arm) -> dict[str, Any]:
    """Which robot it is, as JSON values."""
    about = {"robot": arm.name, "reading": arm.reading, "digest": arm.digest, "errata": list(arm.errata)}
    units = ["rad" if link.kind is JointKind.REVOLUTE else "m" for link in arm.chain.links]
    return {**about, "joint_units": units, "file": arm.file or None, "loaded_with": dict(arm.loaded_with)}


def versions() -> dict[str, str]:
    """Versions of the packages that compute a run."""
    return {"lwr_dyn": VERSION, **{name: package_version(name) for name in ("numpy", "scipy", "pin")}}


class ArmRecord(TypedDict):
    """`arm_record`."""

    robot: Annotated[str, "Name of the robot."]
    reading: Annotated[str, "Its reading."]
    digest: Annotated[str, "Of its file."]
    errata: Annotated[list[str], "Slips of the print that are proven or read otherwise."]
    joint_units: Annotated[list[str], "Of the positions: rad, or m of a sliding joint."]
    file: Annotated[str | None, "Of the user's own; null of a robot of the data room."]
    loaded_with: Annotated[dict[str, Any], "Options of loading: mount, tool, tip, locked joints."]


class ReferenceRecord(TypedDict):
    """The reference of a run."""

    name: Annotated[str, "Of its kind."]
    duration: Annotated[float, "s."]
    about: Annotated[dict[str, Any], "What makes the motion again."]


class DescribedLaw(TypedDict):
    """`describe` of a controller."""

    name: Annotated[str, "Of its kind."]
    label: Annotated[str, "For people."]
    parameters: Annotated[dict[str, Any], "By their names."]


class RunRecord(ArmRecord):
    """`Run.meta` of a simulated run: the setup, then what was counted and judged; the arm is the controller's."""

    plant: Annotated[ArmRecord, "The arm that moves."]
    payload: Annotated[dict[str, Any] | None, "That the plant carries; null without."]
    controller: Annotated[DescribedLaw, "Of the run."]
    engine: Annotated[str, "Of the plant's dynamics."]
    reference: Annotated[ReferenceRecord, "What the arm had to follow."]
    options: Annotated[dict[str, Any], "Sampling, integration and limits."]
    encoder: Annotated[dict[str, Any] | None, "Resolution, noise and velocity filter; null of exact readings."]
    friction: Annotated[bool, "Whether the plant has any."]
    friction_law: Annotated[dict[str, Any], "Its form and levels; `rate`: how fast it brakes at the start, 1/s."]
    external: Annotated[DescribedLaw | None, "External torque; null without."]
    elasticity: Annotated[dict[str, Any] | None, "Springs and dampers of the joints; null where they are rigid."]
    seed: Annotated[int, "Of the encoder's noise."]
    loop: Annotated[str | None, "Kind of the loop, where it was asked for."]
    versions: Annotated[dict[str, str], "Of the packages that compute a run."]
    note: Annotated[dict[str, Any], "What the caller says of the run: task, plant in words."]
    evaluations: Annotated[int, "How often accelerations were computed."]
    at_stop_s: Annotated[list[float], "Seconds on the stop."]
    cut_share: NotRequired[
        Annotated[list[float], "Share of the samples in which each joint's torque was cut; elastic joints only."]
    ]
    audit: Annotated[AuditRecord, "Energy and inverse dynamics judged again."]
    hint: NotRequired[Annotated[str, "Which option would make such a long run at least 5 times as fast."]]


@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """A simulation whose options are all checked: `run_setup` runs it; its record is kept in `run.meta`."""

    arm: Arm  # as its controller knows it
    plant: Plant
    controller: Controller
    reference: Reference
    motion: Motion  # the reference at every sample
    start: Array  # (2, n), q and dq at t = 0
    loop: Loop
    elasticity: JointElasticity | None  # of the plant; None for rigid joints
    friction_rate: float  # fastest rate at which friction brakes at the start [1/s]
    __repr__ = short_repr

    def sensor(self) -> Sensor:
        """A fresh sensor for one run."""
        loop = self.loop
        if loop.encoder is None:
            return lambda q, dq: (q, dq)
        q0, dq0 = self.start
        return loop.encoder.sensor(q0, dq0, self.motion.t.size, loop.rate, loop.seed)

    def record(self) -> dict[str, Any]:
        """The setup as JSON values."""
        loop, friction, reference, elasticity = self.loop, self.plant.friction, self.reference, self.elasticity
        left_out = {"left_out": words} if (words := self.plant.arm.friction_with_load) else {}
        return {
            **arm_record(self.arm), "plant": arm_record(self.plant.arm), "payload": loop.load,
            "controller": describe(self.controller), "engine": loop.engine_name,
            "reference": {
                "name": getattr(reference, "name", type(reference).__name__), "duration": float(reference.duration),
                "about": dict(getattr(reference, "about", {})),
            },
            "options": {name: getattr(loop, name) for name in OPTIONS},
            "encoder": None if loop.encoder is None else asdict(loop.encoder),
            "friction": friction.form != "none",
            "friction_law": {**friction.record(), "rate": self.friction_rate, **left_out},
            "external": None if loop.external is None else describe(loop.external),
            "elasticity": None if elasticity is None else {
                "stiffness": elasticity.stiffness.tolist(), "damping": elasticity.damping.tolist(),
                "source": elasticity.source, "encoders": loop.encoders,
            },
            "seed": loop.seed, "loop": loop.loop, "versions": versions(), "note": dict(loop.meta or {}),
        }  # fmt: skip

    def __str__(self) -> str:
        return json_text(self.record())


def prepare(arm: Arm, controller: Controller, reference: Reference, loop: Loop) -> Setup:
    """The setup of a run, checked; errors as of `lwr_dyn.simulate`."""
    arm_argument(arm)
    if not callable(controller):
        raise OptionError("controller", repr(controller), "a function f(t, q, dq, q_ref, dq_ref, ddq_ref) -> tau")
    reference_argument(reference)
    simulated = loop.loaded(arm if loop.plant is None else loop.plant)
    friction, elasticity = chosen_friction(simulated, loop.friction), chosen_elasticity(simulated, loop.elasticity)
    plant = plant_of(simulated, loop.engine, friction, loop.saturate, loop.position_limits, loop.allow_unphysical)
    loop.check(controller)
    times = loop.times(reference.duration if loop.duration is None else loop.duration)
    motion = sampled_reference(reference, times, plant.n)
    start = read_only(start_state(plant, motion, loop.q0, loop.dq0))
    if loop.external is not None:
        checked_external(loop.external, plant.n)(0.0, start[0], start[1])
    rate = 0.0 if elasticity else friction_rate(plant, start[0], loop)
    return Setup(arm, plant, controller, reference, motion, start, loop, elasticity, rate)
