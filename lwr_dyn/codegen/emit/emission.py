"""The functions of an arm for one file, and what all of them share: names, the comment at the top, test vectors.

The comment says which arm and source, what wrote it, what its numbers mean. The expected numbers of the test vectors
are what CasADi's virtual machine gives, with the sine and cosine of the C library.
"""

import json
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.urdf.elements import caveat_lines, estimates, numbers
from lwr_dyn.codegen.emit import functions as emit
from lwr_dyn.codegen.kernels import kernel_spec as specs
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError, MissingDataError, MissingPackageError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.foundation.version import VERSION
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind, names_of_ends, unphysical_links


def identifier(name: str) -> str:
    """A name as an identifier: letters, digits and single underscores, a letter first (C++ reserves the others).

    >>> identifier("KR 30-HA"), identifier("7dof arm"), identifier("ö")
    ('KR_30_HA', 'arm_7dof_arm', 'arm')
    """
    made = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", name)).strip("_")
    return made if made[:1].isalpha() else f"arm_{made}".rstrip("_")


@dataclass(frozen=True, slots=True, eq=False)
class EmittedArm:
    """The functions of an arm, ready to be written."""

    arm: Arm
    spec: KernelSpec
    prefix: str
    """Names of functions begin with it and an underscore."""
    codes: tuple[emit.EmittedCode, ...]
    templates: tuple[emit.TemplateFunction, ...]
    kind: emit.SinCosKind
    dtype: str
    left_out: tuple[tuple[str, str], ...]
    """Functions that the arm cannot have, and why."""

    def name_of(self, function: str) -> str:
        """The name of a function in the file."""
        return f"{self.prefix}_{function}"


LANGUAGES: Registry[Callable[[EmittedArm, Path], dict[Path, str]]] = Registry(
    "language",
    {
        "c": Row("lwr_dyn.codegen.emit.c_file:c_files", "C99 that is also C++: FILE.c and FILE.h", "batch"),
        "js": Row(
            "lwr_dyn.codegen.emit.javascript_file:js_files", "FILE.js, a plain script; FILE.mjs, an ES module", "batch"
        ),
    },
)
"""Languages: name -> function of (emitted, path) that gives the files to write."""


def emitted_arm(
    arm: Arm,
    functions: Iterable[str] = (),
    *,
    inputs: Iterable[str] = (),
    friction: str = "none",
    dtype: str = "float64",
    kind: emit.SinCosKind = "own",
    prefix: str | None = None,
) -> EmittedArm:
    """The functions of an arm, ready to be written in another language.

    Parameters
    ----------
    arm : Arm
    functions : names out of `EMITTED`
        All that the arm can have if empty.
    inputs : names out of inertia, payload, gravity, friction
        The quantities that functions take as arguments instead of the arm's constants.
    friction : {"none", "arm"}
        "arm" adds the arm's own friction to inverse dynamics and subtracts it in forward dynamics.
    dtype : {"float64", "float32"}
    kind : {"own", "libm"}
        Whose sine and cosine.
    prefix : str
        What names begin with; the arm's name if not given. It is made an identifier.

    Raises
    ------
    UnknownNameError
        No function of that name.
    OptionError
        A choice that does not exist.
    MissingDataError
        A named function needs numbers that the arm does not have.
    """
    emit.check_sincos(kind)
    wanted = tuple(dict.fromkeys(functions))
    spec = _spec(arm, inputs, friction, dtype)
    codes: list[emit.EmittedCode] = []
    templates: list[emit.TemplateFunction] = []
    left_out: list[tuple[str, str]] = []
    for name in wanted or emit.EMITTED.names:
        try:
            found = emit.emitted_function(spec, name, arm)
            if isinstance(found, emit.TemplateFunction):
                templates.append(found)
            else:
                codes.append(emit.emitted_code(found, kind, dtype))
        except MissingPackageError:
            raise
        except LwrDynError as fault:
            if wanted:
                raise
            left_out.append((name, str(fault)))
    name = identifier(arm.name if prefix is None else prefix)
    return EmittedArm(arm, spec, name, tuple(codes), tuple(templates), kind, dtype, tuple(left_out))


def _spec(arm: Arm, inputs: Iterable[str], friction: str, dtype: str) -> KernelSpec:
    """The options, checked; an arm without masses keeps its kinematics."""
    chosen = specs.chosen_inputs(inputs)
    try:
        return specs.kernel_spec(arm, chosen, friction, "armature", dtype)
    except MissingDataError:
        if friction != "none":
            raise
        return KernelSpec(f"{arm.name} ({arm.reading})", arm.chain, None, chosen, "armature", dtype)


WIDTH = 110

_FRICTION = {True: "the arm's own, added in inverse and subtracted in forward dynamics", False: "none"}


def provenance_lines(emitted: EmittedArm) -> list[str]:
    """Robot, reading, errata, hash of the data, versions, units and range: plain lines that fit into a comment."""
    return [line for text in _texts(emitted) for line in wrapped(text)]


def wrapped(text: str) -> list[str]:
    """Text as lines that may stand in a comment of C or JavaScript: ASCII, and nothing that ends the comment."""
    plain = text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")
    plain = plain.encode("ascii", "backslashreplace").decode().replace("\\", "/")
    return textwrap.wrap(plain, WIDTH, subsequent_indent="  ", break_on_hyphens=False) or [""]


def _texts(emitted: EmittedArm) -> list[str]:
    arm, spec = emitted.arm, emitted.spec
    loaded = ", ".join(f"{name} {value}" for name, value in arm.loaded_with.items() if value)
    first, _ = names_of_ends(arm.installation)
    unphysical = unphysical_links(arm.chain) if arm.chain.bodies is not None else ()
    units = ("rad" if link.kind is JointKind.REVOLUTE else "m" for link in arm.chain.links)
    joints = [f"q[{i}] {name} [{unit}]" for i, (name, unit) in enumerate(zip(arm.joint_names, units, strict=True))]
    return [
        f"{arm.title}; robot {arm.name}, reading {arm.reading}",
        *caveat_lines(arm),
        f"written by lwr-dyn {VERSION} with CasADi {version('casadi')}; do not edit: write it again",
        f"errata applied: {arm.caveats.errata_words(arm.errata)}",
        f"source file sha256: {arm.digest or 'none'}",
        *([f"loaded with: {loaded}"] if loaded else []),
        *([] if "gravity" in spec.inputs else [f"gravity in the {first} frame [m/s^2]: {numbers(arm.chain.gravity)}"]),
        *([] if "friction" in spec.inputs else [f"friction: {_FRICTION[spec.friction is not None]}"]),
        "rotors: as inertia at the joints (armature) where the source gives them",
        f"inertias that no body can have: {', '.join(unphysical) or 'none'}",
        *(f"estimated: {line}" for line in estimates(arm)),
        f"joints: {', '.join(joints)}; frames: {_frames(arm)}",
        f"numbers: {emitted.dtype}, SI; {_range(emitted)}",
    ]


def _frames(arm: Arm) -> str:
    """Both frames of the functions; where a mount or tool makes it another one, that one by its name."""
    ends = zip(names_of_ends(arm.installation), ("base", "flange"), strict=True)
    return ", ".join(said if end == said else f"{end} (where a function says {said})" for end, said in ends)


def _range(emitted: EmittedArm) -> str:
    if emitted.kind == "libm":
        return "sine and cosine of the library"
    most = int(sincos(emitted.dtype).most_half_turns * 3.14159)
    return f"sine and cosine by polynomials of its own, for angles up to {most} rad; larger ones give wrong results"


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

    function: emit.EmittedFunction
    arguments: tuple[Array, ...]
    results: Array

    def rows(self) -> Iterator[tuple[emit.Argument, Array]]:
        """Each argument with its values."""
        return zip(self.function.arguments, self.arguments, strict=True)

    @property
    def largest(self) -> float:
        """The largest expected number, at least `_NOISE`."""
        return max(float(np.abs(self.results).max()), _NOISE)


def emitted_cases(emitted: EmittedArm) -> tuple[EmittedCase, ...]:
    """The test vectors of each function, at the same states."""
    values, cases = argument_values(emitted), []
    for function in (code.function for code in emitted.codes):
        arguments = tuple(values[a.name] if a.name in values else _other(a) for a in function.arguments)
        results = [np.asarray(function.symbolic(*rows)).ravel() for rows in zip(*arguments, strict=True)]
        cases.append(EmittedCase(function, arguments, np.array(results, dtype=np.float64)))
    return tuple(cases)


def argument_values(emitted: EmittedArm) -> dict[str, Array]:
    """Argument -> its values, a state a row, rounded to the number type."""
    arm, rng = emitted.arm, np.random.default_rng(30)
    share = np.where(arm.chain.turning, 1.0, _SLIDING)
    drawn = {name: rng.uniform(-most, most, (STATES, arm.n)) * share for name, most in _LARGEST.items()}
    drawn |= {name: np.tile(np.ravel(_input(arm, name)), (STATES, 1)) for name in emitted.spec.inputs}
    return {name: rows.astype(emitted.dtype).astype(np.float64) for name, rows in drawn.items()}


def vectors_text(emitted: EmittedArm) -> str:
    """The test vectors as JSON: for each function the rows of its arguments and of its result.

    Those of a template have a tolerance of their own, and what the function returns beside its result.
    """
    functions: list[dict[str, Any]] = [
        {
            "name": case.function.name,
            "arguments": [{"name": a.name, "unit": a.unit, "rows": rows.tolist()} for a, rows in case.rows()],
            "result": {"unit": case.function.unit, "shape": case.function.shape, "rows": case.results.tolist()},
        }
        for case in emitted_cases(emitted)
    ]
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


def _template_record(case: emit.TemplateCase) -> dict[str, Any]:
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


def _other(argument: emit.Argument) -> Array:
    """Values of an argument that is no joint vector and no input, such as gains: others for another name."""
    rng = np.random.default_rng(list(argument.name.encode()))
    return rng.integers(1, 64, (STATES, argument.width)) / 16.0


def _input(arm: Arm, name: str) -> Array:
    match name:
        case "inertia":
            return specs.inertial_parameters(arm.chain)
        case "payload":
            return specs.payload_parameters(2.0, (0.01, -0.02, 0.1))
        case "gravity":
            return arm.chain.gravity
        case _:
            return np.full((len(specs.FRICTION), arm.n), 0.25)
