"""`prepare`: the arguments of `simulate`, checked, as a `Setup` that can be shown, kept and run."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import Controller, describe
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, arm_argument, read_only
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.changed_arm import arm_with_payload
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.elasticity import JointElasticity, chosen_elasticity
from lwr_dyn.model.run import Motion, Reference
from lwr_dyn.model.shown import short_repr
from lwr_dyn.simulation.arm_friction import FrictionOption, chosen_friction
from lwr_dyn.simulation.external import ExternalTorque, checked_external
from lwr_dyn.simulation.options import (
    SimulationOptions,
    check_continuous,
    friction_rate,
    sampled_reference,
    start_state,
)
from lwr_dyn.simulation.plant import Plant, plant_of
from lwr_dyn.simulation.sensors import Encoder, Sensor

ENCODERS = ("motor", "link")


def arm_record(arm: Arm) -> dict[str, Any]:
    """Which robot it is, as JSON values."""
    about = {"robot": arm.name, "reading": arm.reading, "digest": arm.digest, "errata": list(arm.errata)}
    units = ["rad" if link.kind is JointKind.REVOLUTE else "m" for link in arm.chain.links]
    return {**about, "joint_units": units, "file": arm.file or None, "loaded_with": dict(arm.loaded_with)}


def versions() -> dict[str, str]:
    """Versions of the packages that compute a run."""
    return {"lwr_dyn": VERSION, **{name: version(name) for name in ("numpy", "scipy", "pin")}}


@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """A simulation whose options are all checked: `run_setup` runs it; its record is kept in `run.meta`."""

    arm: Arm  # as its controller knows it
    plant: Plant
    controller: Controller
    reference: Reference
    motion: Motion  # the reference at every sample
    start: Array  # (2, n), q and dq at t = 0
    options: SimulationOptions
    encoder: Encoder | None
    engine: str
    payload: Mapping[str, Any] | None
    friction_rate: float  # fastest rate at which friction brakes at the start [1/s]
    note: Mapping[str, Any]
    external: ExternalTorque | None = None
    elasticity: JointElasticity | None = None  # of the plant; None for rigid joints
    encoders: str = ENCODERS[0]  # the side of elastic joints that the controller's q and dq are of
    loop: str | None = None  # the row of `LOOPS` that was asked for
    __repr__ = short_repr

    def sensor(self) -> Sensor:
        """A fresh sensor for one run."""
        if self.encoder is None:
            return lambda q, dq: (q, dq)
        q0, dq0 = self.start
        return self.encoder.sensor(q0, dq0, self.motion.t.size, self.options.rate, self.options.seed)

    def record(self) -> dict[str, Any]:
        """The setup as JSON values."""
        friction, reference = self.plant.friction, self.reference
        return {
            **arm_record(self.arm), "plant": arm_record(self.plant.arm), "payload": self.payload,
            "controller": describe(self.controller), "engine": self.engine,
            "reference": {
                "name": getattr(reference, "name", type(reference).__name__), "duration": float(reference.duration),
                "about": dict(getattr(reference, "about", {})),
            },
            "options": asdict(self.options), "encoder": None if self.encoder is None else asdict(self.encoder),
            "friction": friction.form != "none", "friction_law": {**friction.record(), "rate": self.friction_rate},
            "external": None if self.external is None else describe(self.external),
            "elasticity": None if self.elasticity is None else {
                "stiffness": self.elasticity.stiffness.tolist(), "damping": self.elasticity.damping.tolist(),
                "source": self.elasticity.source, "encoders": self.encoders,
            },
            "seed": self.options.seed, "loop": self.loop, "versions": versions(), "note": dict(self.note),
        }  # fmt: skip

    def __str__(self) -> str:
        return json_text(self.record())


def _elastic(
    arm: Arm, option: JointElasticity | str | float | None, encoders: str, method: str
) -> JointElasticity | None:
    if encoders not in ENCODERS:
        raise OptionError("encoders", repr(encoders), ", ".join(ENCODERS))
    for name, given in (("method", method == "radau"), ("encoders", encoders != ENCODERS[0])):
        if given and option is None:
            raise OptionError(name, "would do nothing with rigid joints", "with elastic joints")
    return chosen_elasticity(arm, option)


def prepare(
    arm: Arm,
    controller: Controller,
    reference: Reference,
    *,
    rate: float = 1000.0,
    method: str = "rk4",
    substeps: int = 1,
    rtol: float = 1e-12,
    continuous: bool = False,
    engine: str | Dynamics = "pinocchio",
    plant: Arm | None = None,
    payload: float = 0.0,
    payload_com: ArrayLike = (0.0, 0.0, 0.0),
    payload_inertia: ArrayLike | None = None,
    friction: FrictionOption = "set-valued",
    external: ExternalTorque | None = None,
    elasticity: JointElasticity | str | float | None = None,
    encoders: str = "motor",
    encoder: Encoder | None = None,
    saturate: bool = True,
    position_limits: bool = True,
    allow_unphysical: bool = False,
    seed: int = 0,
    delay: int = 0,
    loop: str | None = None,
    duration: float | None = None,
    q0: ArrayLike | None = None,
    dq0: ArrayLike | None = None,
    meta: Mapping[str, Any] | None = None,
) -> Setup:
    """The setup of a run, checked; parameters and errors as of `lwr_dyn.simulation.simulate.simulate`."""
    arm_argument(arm)
    options = SimulationOptions(
        rate, method, substeps, rtol, continuous, saturate, position_limits, allow_unphysical, seed, delay
    )
    if not callable(controller):
        raise OptionError("controller", repr(controller), "a function f(t, q, dq, q_ref, dq_ref, ddq_ref) -> tau")
    if not hasattr(reference, "sample"):
        raise OptionError("reference", repr(reference), "a Reference, with `sample(t)` and `duration`")
    simulated, load = arm if plant is None else plant, None
    if payload != 0.0:
        simulated = arm_with_payload(simulated, payload, payload_com, payload_inertia)
        com = np.asarray(payload_com, dtype=float).tolist()
        inertia = None if payload_inertia is None else np.asarray(payload_inertia, dtype=float).tolist()
        load = {"mass": float(payload), "com": com, "inertia": inertia}
    chosen, elastic = chosen_friction(simulated, friction), _elastic(simulated, elasticity, encoders, method)
    simulated_plant = plant_of(simulated, engine, chosen, saturate, position_limits, allow_unphysical)
    if continuous:
        check_continuous(controller, encoder, delay)
    times = options.times(reference.duration if duration is None else duration)
    motion = sampled_reference(reference, times, simulated_plant.n)
    start = read_only(start_state(simulated_plant, motion, q0, dq0))
    if external is not None:
        checked_external(external, simulated_plant.n)(0.0, start[0], start[1])
    if encoder is not None:
        encoder.velocity_filter(rate)  # raises where it is too slow for the rate
    return Setup(
        arm, simulated_plant, controller, reference, motion, start, options, encoder,
        engine if isinstance(engine, str) else getattr(engine, "name", type(engine).__name__),
        load, 0.0 if elastic else friction_rate(simulated_plant, start[0], options), dict(meta or {}),
        external, elastic, encoders, loop,
    )  # fmt: skip
