"""Test vectors: a few states, and what each function gives there by another way than the emitted code.

The expected numbers are what CasADi's virtual machine gives, with the sine and cosine of the C library.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.emit.functions import Argument, EmittedFunction, TemplateCase
from lwr_dyn.codegen.kernels.parameters import FRICTION, inertial_parameters, payload_parameters
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind

STATES = 3
TOLERANCE = {"float64": 1e-12, "float32": 1e-4}
"""Of the largest expected number of a function: what any compiler may leave, of badly conditioned arms too."""
_LARGEST = {"q": 3.0, "dq": 2.0, "ddq": 4.0, "tau": 30.0}
_SLIDING = 0.5
_NOISE = 0.1
"""In SI units: where all expected numbers are smaller, they may be rounding of cos 90 deg times weights."""


@dataclass(frozen=True, slots=True, eq=False)
class EmittedCase:
    """The test vectors of one function, a state a row."""

    function: EmittedFunction
    arguments: tuple[Array, ...]
    results: Array

    def rows(self) -> Iterator[tuple[Argument, Array]]:
        """Each argument with its values."""
        return zip(self.function.arguments, self.arguments, strict=True)

    @property
    def largest(self) -> float:
        """The largest expected number, at least `_NOISE`."""
        return max(float(np.abs(self.results).max()), _NOISE)


def emitted_cases(emitted: EmittedArm) -> tuple[EmittedCase, ...]:
    """The test vectors of each function, at the same states."""
    values = argument_values(emitted)
    return tuple(_case(code.function, values) for code in emitted.codes)


def argument_values(emitted: EmittedArm) -> dict[str, Array]:
    """Argument -> its values, a state a row, rounded to the number type."""
    arm, rng = emitted.arm, np.random.default_rng(30)
    kinds = [link.kind for link in arm.chain.links]
    share = np.where([kind is JointKind.REVOLUTE for kind in kinds], 1.0, _SLIDING)
    drawn: dict[str, Array] = {
        name: rng.uniform(-most, most, (STATES, arm.n)) * share for name, most in _LARGEST.items()
    }
    for name in emitted.spec.inputs:
        drawn[name] = np.tile(np.ravel(_input(arm, name)), (STATES, 1))
    return {name: rows.astype(emitted.dtype).astype(np.float64) for name, rows in drawn.items()}


def vectors_text(emitted: EmittedArm) -> str:
    """The test vectors as JSON: for each function the rows of its arguments and of its result.

    Those of a template have a tolerance of their own, and what the function returns beside its result.
    """
    functions: list[dict[str, Any]] = [
        {
            "name": case.function.name,
            "arguments": [
                {"name": a.name, "unit": a.unit, "rows": rows.tolist()}
                for a, rows in case.rows()
            ],
            "result": {"unit": case.function.unit, "shape": case.function.shape, "rows": case.results.tolist()},
        }
        for case in emitted_cases(emitted)
    ]  # fmt: skip
    functions += [_template_record(case) for template in emitted.templates for case in template.cases()]
    top: Mapping[str, Any] = {
        "robot": emitted.arm.name,
        "reading": emitted.arm.reading,
        "source_sha256": emitted.arm.digest,
        "prefix": emitted.prefix,
        "dtype": emitted.dtype,
        "tolerance_of_largest": TOLERANCE[emitted.dtype],
        "functions": functions,
    }
    return json.dumps(top, indent=1, allow_nan=False) + "\n"


def _template_record(case: TemplateCase) -> dict[str, Any]:
    """With null for NaN, as JSON has none."""
    result: dict[str, Any] = {"unit": case.unit, "rows": _listed(case.rows), "tolerance": case.tolerance}
    if case.returned is not None:
        result["returned"] = case.returned
    arguments = [{"name": a.name, "unit": a.unit, "rows": rows} for a, rows in case.arguments]
    return {"name": case.name, "arguments": arguments, "result": result}


def _listed(x: Any) -> Any:
    if isinstance(x, list):
        return [_listed(each) for each in x]
    return None if x != x else x


def _case(function: EmittedFunction, values: Mapping[str, Array]) -> EmittedCase:
    arguments = tuple(values[a.name] if a.name in values else _other(a) for a in function.arguments)
    results = [np.asarray(function.symbolic(*rows), dtype=np.float64).ravel() for rows in zip(*arguments, strict=True)]
    return EmittedCase(function, arguments, np.array(results))


def _other(argument: Argument) -> Array:
    """Values of an argument that is no joint vector and no input, such as gains: others for another name."""
    rng = np.random.default_rng(list(argument.name.encode()))
    return rng.integers(1, 64, (STATES, argument.width)) / 16.0


def _input(arm: Arm, name: str) -> Array:
    match name:
        case "inertia":
            return inertial_parameters(arm.chain)
        case "payload":
            return payload_parameters(2.0, (0.01, -0.02, 0.1))
        case "gravity":
            return arm.chain.gravity
        case _:
            return np.full((len(FRICTION), arm.n), 0.25)
