"""One sample of a closed loop on symbols, as one straight line: reading, law, delay, saturation, figures, RK4 substeps.

The state before the sample is judged (figures, trouble), then moved to the next; a driver calls the step k + 1 times,
the last only for its figures. The laws of `simulate` are repeated in its order: encoder (`simulation.plant.Encoder`
with its `FilteredDifference`, number for number), controller, delay (`simulation.loops`), saturation. The
numbers of one run stand by name in rows of lanes of a kernel's block (`Slots`).
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from itertools import accumulate
from math import prod
from typing import Any, NamedTuple

import casadi
import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.codegen.rollouts.law_forms import LawForm, LawInputs
from lwr_dyn.codegen.rollouts.philox_code import words_of
from lwr_dyn.codegen.rollouts.symbolic_arm import Column, KeptParameters, SymbolicModel, SymbolicPlant
from lwr_dyn.control.protocol import saturate
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import Vector

STATE = ("q", "dq", "memory", "encoder", "commands")
"""State, memory of the law, of the encoder, and commands on their way: the body replaces them."""

FIGURES = (
    "tip_squares", "tip_worst", "tip_square", "position_squares", "position_worst", "torque_worst", "command_worst",
    "torque_squares", "speed_worst", "saturated", "margin", "violation", "angle_worst", "trouble",
)  # fmt: skip
"""Sums, largest values and counts over the samples, which the body replaces; `margin` and `violation` are smallest.
`tip_square` is that of the last sample; `trouble` turns NaN where a state or torque is not finite."""

WHOLE = ("command", "applied", "friction_torque", "friction_work")
"""What a log of every sample needs beside the state at it: torques there, and the work of friction until the next."""

OF_JOINTS = (
    "q", "dq", "position_squares", "position_worst", "torque_worst", "command_worst", "torque_squares", "speed_worst",
    "saturated", "margin", "command", "applied", "friction_torque", "armature", "effort", "rating", "lower", "upper",
)  # fmt: skip
"""Those with a number a joint."""

CONSTANTS = (
    "plant", "armature", "effort", "rating", "lower", "upper", "friction", "model", "resolution", "noise", "delay",
    "tolerance", "last", "nothing",
)  # fmt: skip
"""Of a run: kept parameters of plant and model, limits, friction, encoder, delay, tip error^2, last sample.

Commands are cut at `effort`, and judged by `rating`, which is the same where torques saturate. `nothing` is a 0 that no
compiler knows: 0 x is NaN where x is not finite."""

SAMPLE = ("sample", "reference", "tip", "chance")
"""Of a sample: its number, q_ref, dq_ref, ddq_ref, the tip's place, uniform numbers or noise."""

GAIN = "gain "
"""Stands before the name of a parameter of the law."""


@dataclass(frozen=True)
class Slots:
    """Names with their widths, in the order in which they stand."""

    widths: Mapping[str, int]

    def first(self, name: str) -> int:
        """The row at which a name begins."""
        return self._ranges[name].start

    def places(self, name: str) -> range:
        """The rows of a name."""
        return self._ranges[name]

    def all_places(self, names: Iterable[str]) -> list[int]:
        """The rows of several names."""
        return [place for name in names for place in self._ranges[name]]

    @cached_property
    def _ranges(self) -> Mapping[str, range]:
        ends = accumulate(self.widths.values())
        return {name: range(end - width, end) for (name, width), end in zip(self.widths.items(), ends, strict=True)}

    @cached_property
    def size(self) -> int:
        """Rows in all."""
        return sum(self.widths.values())

    def filled(self, values: Mapping[str, ArrayLike]) -> Array:
        """The numbers of a run, (size,), from values by their names; zeros elsewhere."""
        row, ranges = np.zeros(self.size), self._ranges
        for name, value in values.items():
            place = ranges[name]
            if place:
                row[place.start : place.stop] = np.ravel(value)
        return row


STARTS = dict.fromkeys(FIGURES, 0.0) | {"margin": float("inf"), "violation": float("inf")}
"""The figures before the first sample."""


def figures(x: Mapping[str, Any], tip: Vector, command: Any, applied: Any) -> dict[str, Any]:
    """The figures after a sample, from those before it (in `x`, by `FIGURES`) and the sample's numbers.

    Largest values keep their first argument where a number is NaN, and `trouble` says so.
    """
    q, dq = x["q"], x["dq"]
    n = q.numel()
    error = x["reference"][:n] - q
    away = casadi.vertcat(tip.x, tip.y, tip.z) - x["tip"]
    square = casadi.dot(away, away)
    margin = casadi.fmin(q - x["lower"], x["upper"] - q)
    cut = casadi.fabs(command) > x["rating"]
    moves = x["sample"] < x["last"]  # the last sample has no duration
    late = casadi.if_else(square > x["tolerance"], x["sample"], 1e300)
    return {
        "tip_squares": x["tip_squares"] + square,
        "tip_worst": casadi.fmax(x["tip_worst"], square),
        "tip_square": square,
        "position_squares": x["position_squares"] + error * error,
        "position_worst": casadi.fmax(x["position_worst"], casadi.fabs(error)),
        "torque_worst": casadi.fmax(x["torque_worst"], casadi.fabs(applied)),
        "command_worst": casadi.fmax(x["command_worst"], casadi.fabs(command)),
        "torque_squares": x["torque_squares"] + applied * applied,
        "speed_worst": casadi.fmax(x["speed_worst"], casadi.fabs(dq)),
        "saturated": x["saturated"] + cut * moves,
        "margin": casadi.fmin(x["margin"], margin),
        "violation": casadi.fmin(x["violation"], late),
        "angle_worst": casadi.fmax(x["angle_worst"], casadi.dot(q, q)),
        "trouble": x["trouble"] + x["nothing"] * (casadi.sum1(q) + casadi.sum1(dq) + casadi.sum1(command)),
    }


class EncoderReading(NamedTuple):
    """What the controller sees, columns (n,), and the memory (2 n,) of the next sample: reading, filtered velocity."""

    q: Column
    dq: Column
    memory: Column


class LateCommand(NamedTuple):
    """The command (n,) that acts now, and the memory of the next sample: the commands before it, latest first."""

    command: Column
    memory: Column


def normals(uniform: Column, n: int) -> Column:
    """n numbers of the standard normal distribution from uniform ones, as `philox_code.normal_numbers`."""
    out: list[Any] = []
    for i in range(0, n, 2):
        radius, angle = casadi.sqrt(-2.0 * casadi.log(uniform[i])), 2.0 * casadi.pi * uniform[i + 1]
        out += [radius * casadi.cos(angle), radius * casadi.sin(angle)]
    return casadi.vertcat(*out[:n])


def rounded(x: Column) -> Column:
    """The nearest whole numbers, halves to the even one, as `numpy.round`."""
    return x - casadi.remainder(x, 1.0)


def encoder_reading(
    q: Column, dq: Column, memory: Column, noise: Column | None, resolution: Any, pole: float, rate: float, first: Any
) -> EncoderReading:
    """A sample of an encoder.

    Parameters
    ----------
    q, dq : columns (n,)
        The true state.
    memory : column (2 n,)
        Of the sample before; finite numbers at the first.
    noise : column (n,), optional
        What is added to q before rounding.
    resolution : number or symbol
        One count; 0 for no rounding. A symbol may be 0 in some runs; a number folds.
    pole, rate : float
        Of the velocity filter, and samples a second [Hz].
    first : symbol
        1 at the first sample, which starts the filter with the true speed, else 0.
    """
    n = q.numel()
    reading = q if noise is None else q + noise
    if not isinstance(resolution, float | int):
        rounds = resolution > 0.0
        count = casadi.if_else(rounds, resolution, 1.0)
        reading = casadi.if_else(rounds, rounded(reading / count) * count, reading)
    elif resolution > 0.0:
        reading = rounded(reading / resolution) * resolution
    last, value = memory[:n], memory[n:]
    difference = (reading - last) * rate
    filtered = difference + pole * (value - difference)
    seen = casadi.if_else(first > 0.5, dq, filtered)
    return EncoderReading(reading, seen, casadi.vertcat(reading, seen))


def late_command(command: Column, memory: Column, delay: Any, sample: Any) -> LateCommand:
    """The command of `delay` samples ago; until the first arrives, it acts already.

    Parameters
    ----------
    command : column (n,)
        The command of this sample.
    memory : column (m n,)
        The m commands before it, latest first; finite numbers where there were none yet.
    delay : number or symbol
        Whole samples from 0 to m.
    sample : symbol
        Number of this sample, from 0.
    """
    n, most = command.numel(), memory.numel() // command.numel()
    behind = casadi.fmin(delay, sample)
    out = command
    for i in range(1, most + 1):
        out = casadi.if_else(behind > i - 0.5, memory[n * (i - 1) : n * i], out)
    kept = memory[: n * (most - 1), 0]  # [:0] of a single number would be a row, which counts
    return LateCommand(out, casadi.vertcat(command, kept) if most else memory)


GENERATOR = 5
"""Version of the step and its driver: raised when they compute otherwise, so that cached kernels are not used."""

MOST_DELAY = 8
"""[samples] Longest delay of a kernel that has one."""


@dataclass(frozen=True, eq=False)
class StepPlan:
    """Everything on which the code of a step depends. What differs from run to run is a slot, not part of the plan."""

    arm: Arm
    """As the law knows it."""
    plant: Arm
    form: LawForm
    rate: float = 1000.0
    substeps: int = 1
    varies_plant: bool = False
    """Whether the plant's kept parameters are slots; else constants, and faster."""
    varies_model: bool = False
    """The same of the law's model."""
    friction_width: float | None = None
    """[rad/s] of smooth friction; None without friction."""
    pole: float | None = None
    """Of the encoder's velocity filter; None without an encoder."""
    noise: str = "none"
    """Or "philox": uniform numbers that the driver makes; or "table": standard normal numbers from rows."""
    most_delay: int = 0
    """Longest delay of any run [samples]; 0 for no ring."""
    whole: bool = False
    """Whether the torques of each sample and the work of friction are results, in place of the figures."""

    @cached_property
    def slots(self) -> Slots:
        """The numbers of one run."""
        n = self.plant.n
        widths = dict.fromkeys((*STATE, *FIGURES, *WHOLE, *CONSTANTS, *SAMPLE), 1) | dict.fromkeys(OF_JOINTS, n)
        widths |= {
            "memory": self.form.memory, "encoder": 0 if self.pole is None else 2 * n, "commands": n * self.most_delay,
            "friction": 0 if self.friction_width is None else 5 * n, "reference": 3 * n, "tip": 0 if self.whole else 3,
            "plant": len(KeptParameters.of(self.plant.chain).kept) if self.varies_plant else 0,
            "model": len(KeptParameters.of(self.arm.chain).kept) if self.varies_model else 0,
            "chance": {"none": 0, "philox": words_of(n), "table": n}[self.noise],
        }  # fmt: skip
        gains = {GAIN + name: prod(shape) for name, shape in self.form.parameters.items()}
        results = WHOLE if self.whole else (*FIGURES, *(WHOLE if self.substeps > 1 else ("applied",)))
        order = (*STATE, *results, *CONSTANTS)
        return Slots({name: widths[name] for name in order} | gains | {name: widths[name] for name in SAMPLE})

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the plan."""
        arms = [_chain_digest(arm.chain) for arm in (self.arm, self.plant)]
        text = [f"rollout generator {GENERATOR}", *arms, self.form.name, self.form.digest]
        text.append(repr(dict(self.slots.widths)))
        text += [repr(getattr(self, field.name)) for field in fields(self)[3:]]  # all but arms and form
        return hashlib.sha256("\n".join(text).encode()).hexdigest()


@lru_cache(maxsize=64)
def _chain_digest(chain: Chain) -> str:
    return KernelSpec("", chain, None).digest("rollout")


class Step(NamedTuple):
    """A casadi.Function of slots, the names of its arguments, and those of its results, one after the other."""

    function: Any
    arguments: tuple[str, ...]
    results: tuple[str, ...]


def steps(plan: StepPlan) -> tuple[Step, ...]:
    """What a driver calls at each sample: the sample with its motion, or that without and a substep of the motion."""
    return tuple(_step(plan, body) for body in ([_sample, _motion] if plan.substeps > 1 else [_sample]))


def _step(plan: StepPlan, body: Callable[[StepPlan, Mapping[str, Any]], dict[str, Any]]) -> Step:
    widths = plan.slots.widths
    x = {name: casadi.SX.sym(name, width) for name, width in widths.items()}
    out = body(plan, x)
    results = tuple(name for name, width in widths.items() if name in out and width)
    result = casadi.densify(casadi.vertcat(*(out[name] for name in results)))
    used = {str(symbol) for symbol in casadi.symvar(result)}
    arguments = tuple(name for name, symbol in x.items() if any(str(s) in used for s in casadi.vertsplit(symbol)))
    return Step(casadi.Function("step", [x[name] for name in arguments], [result]), arguments, results)


def _sample(plan: StepPlan, x: Mapping[str, Any]) -> dict[str, Any]:
    """Reading, law, delay, saturation and figures; the motion too where it is one step."""
    q_ref, dq_ref, ddq_ref = casadi.vertsplit(x["reference"], plan.plant.n)
    seen_q, seen_dq, encoder = _reading(plan, x)
    model = SymbolicModel.of(plan.arm.chain, x["model"] if plan.varies_model else None)
    gains = {name: x[GAIN + name] for name in plan.form.parameters}
    given = LawInputs(seen_q, seen_dq, q_ref, dq_ref, ddq_ref, x["memory"], gains, 1.0 / plan.rate)
    command, memory = plan.form.torque(model, given)
    command, commands = late_command(command, x["commands"], x["delay"], x["sample"])
    applied = saturate(command, x["effort"])
    plant = _plant(plan, x)
    out = {
        **({} if plan.whole else figures(x, plant.tip(x["q"]), command, applied)), "memory": memory, "encoder": encoder,
        "commands": commands, "applied": applied, "command": command, "friction_torque": plant.friction(x["dq"]),
    }  # fmt: skip
    if plan.substeps > 1:
        return out | {"friction_work": casadi.SX(0.0)}
    return out | plant.moved(x["q"], x["dq"], applied, 1.0 / plan.rate)._asdict()


def _motion(plan: StepPlan, x: Mapping[str, Any]) -> dict[str, Any]:
    """One of several steps of the motion between two samples."""
    moved = _plant(plan, x).moved(x["q"], x["dq"], x["applied"], 1.0 / (plan.rate * plan.substeps))
    return {"q": moved.q, "dq": moved.dq, "friction_work": x["friction_work"] + moved.friction_work}


def _plant(plan: StepPlan, x: Mapping[str, Any]) -> SymbolicPlant:
    return SymbolicPlant.of(plan.plant.chain, x, plan.varies_plant, plan.friction_width)


def _reading(plan: StepPlan, x: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    """What the controller sees as q and dq, and the encoder's memory."""
    if plan.pole is None:
        return x["q"], x["dq"], x["encoder"]
    n = plan.plant.n
    normal = normals(x["chance"], n) if plan.noise == "philox" else x["chance"]
    noise = None if plan.noise == "none" else x["noise"] * normal
    return encoder_reading(
        x["q"], x["dq"], x["encoder"], noise, x["resolution"], plan.pole,
        plan.rate, casadi.if_else(x["sample"] > 0.5, 0.0, 1.0),
    )  # fmt: skip
