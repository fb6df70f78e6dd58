"""One sample of a closed loop on symbols, as one straight line: reading, law, delay, saturation, figures, RK4 substeps.

The state before the sample is judged (figures, trouble), then moved to the next; a driver calls the step k + 1 times,
the last only for its figures. The laws of `simulate` are repeated in its order: encoder, controller, delay, saturation.
"""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any, NamedTuple

import casadi

from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.codegen.rollouts.laws.protocol import LawForm, LawInputs
from lwr_dyn.codegen.rollouts.philox import words_of
from lwr_dyn.codegen.rollouts.sensing import encoder_reading, late_command, normals
from lwr_dyn.codegen.rollouts.slots import CONSTANTS, FIGURES, GAIN, OF_JOINTS, SAMPLE, STATE, WHOLE, Slots
from lwr_dyn.codegen.rollouts.step_figures import figures
from lwr_dyn.codegen.rollouts.symbolic_model import KeptParameters, SymbolicModel
from lwr_dyn.codegen.rollouts.symbolic_plant import SymbolicPlant
from lwr_dyn.model.arm import Arm

GENERATOR = 3
"""Version of the step and its driver: raised when they compute otherwise, so that cached kernels are not used."""
MOST_DELAY = 8
"""[samples] Longest delay of a kernel that has one."""


@dataclass(frozen=True, slots=True, eq=False)
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
    """Whether the torques of each sample and the work of friction are results too."""

    @property
    def slots(self) -> Slots:
        """The numbers of one run."""
        n = self.plant.n
        widths = dict.fromkeys((*STATE, *FIGURES, *WHOLE, *CONSTANTS, *SAMPLE), 1) | dict.fromkeys(OF_JOINTS, n)
        widths |= {
            "memory": self.form.memory, "encoder": 0 if self.pole is None else 2 * n, "commands": n * self.most_delay,
            "friction": 0 if self.friction_width is None else 5 * n, "reference": 3 * n, "tip": 3,
            "plant": len(KeptParameters.of(self.plant.chain).kept) if self.varies_plant else 0,
            "model": len(KeptParameters.of(self.arm.chain).kept) if self.varies_model else 0,
            "chance": {"none": 0, "philox": words_of(n), "table": n}[self.noise],
        }  # fmt: skip
        gains = {GAIN + name: prod(shape) for name, shape in self.form.parameters.items()}
        order = (*STATE, *FIGURES, *(WHOLE if self.whole or self.substeps > 1 else ("applied",)), *CONSTANTS)
        return Slots({name: widths[name] for name in order} | gains | {name: widths[name] for name in SAMPLE})

    @property
    def digest(self) -> str:
        """SHA-256 of the plan."""
        arms = [KernelSpec("", arm.chain, None).digest("rollout") for arm in (self.arm, self.plant)]
        text = [
            f"rollout generator {GENERATOR}", *arms, self.form.name, self.form.digest,
            repr(dict(self.slots.widths)),
            *(repr(getattr(self, name)) for name in _PLAIN),
        ]  # fmt: skip
        return hashlib.sha256("\n".join(text).encode()).hexdigest()


_PLAIN = (
    "rate", "substeps", "varies_plant", "varies_model", "friction_width", "pole", "noise", "most_delay", "whole",
)  # fmt: skip


class Step(NamedTuple):
    """A casadi.Function of slots, the names of its arguments, and those of its results, one after the other."""

    function: Any
    arguments: tuple[str, ...]
    results: tuple[str, ...]


def steps(plan: StepPlan) -> tuple[Step, ...]:
    """What a driver calls at each sample: the sample with its motion, or that without and a substep of the motion."""
    motion = _motion if plan.substeps > 1 else None
    bodies = [_sample] if motion is None else [_sample, motion]
    return tuple(_step(plan, body) for body in bodies)


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
    applied = casadi.fmax(casadi.fmin(command, x["effort"]), -x["effort"])
    plant = _plant(plan, x)
    out = {
        **figures(x, plant.tip(plant.positions(x["q"])), command, applied), "memory": memory, "encoder": encoder,
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
