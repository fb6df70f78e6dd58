"""The functions of an arm that go into one file, with what all of them share: prefix, number type, sine and cosine."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.codegen.emit.functions import EMITTED, TemplateFunction, emitted_function
from lwr_dyn.codegen.emit.identifiers import identifier
from lwr_dyn.codegen.emit.straight_code import EmittedCode, SinCosKind, check_sincos, emitted_code
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, kernel_spec
from lwr_dyn.codegen.kernels.parameters import chosen_inputs
from lwr_dyn.foundation.errors import LwrDynError, MissingDataError, MissingPackageError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True, eq=False)
class EmittedArm:
    """The functions of an arm, ready to be written."""

    arm: Arm
    spec: KernelSpec
    prefix: str
    """Names of functions begin with it and an underscore."""
    codes: tuple[EmittedCode, ...]
    templates: tuple[TemplateFunction, ...]
    kind: SinCosKind
    dtype: str
    left_out: tuple[tuple[str, str], ...]
    """Functions that the arm cannot have, and why."""

    def name_of(self, function: str) -> str:
        """The name of a function in the file."""
        return f"{self.prefix}_{function}"


LANGUAGES: Registry[Callable[[EmittedArm, Path], dict[Path, str]]] = Registry(
    "language",
    {
        "c": Row("lwr_dyn.codegen.emit.c_file:c_files", "C99 that is also C++: FILE.c and FILE.h", extra="batch"),
        "js": Row(
            "lwr_dyn.codegen.emit.javascript_file:js_files",
            "FILE.js, a plain script; FILE.mjs, an ES module",
            extra="batch",
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
    kind: SinCosKind = "own",
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
    check_sincos(kind)
    wanted = tuple(dict.fromkeys(functions))
    spec = _spec(arm, inputs, friction, dtype)
    codes: list[EmittedCode] = []
    templates: list[TemplateFunction] = []
    left_out: list[tuple[str, str]] = []
    for name in wanted or EMITTED.names:
        try:
            found = emitted_function(spec, name, arm)
            if isinstance(found, TemplateFunction):
                templates.append(found)
            else:
                codes.append(emitted_code(found, kind, dtype))
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
    chosen = chosen_inputs(inputs)
    try:
        return kernel_spec(arm, chosen, friction, "armature", dtype)
    except MissingDataError:
        if friction != "none":
            raise
        return KernelSpec(f"{arm.name} ({arm.reading})", arm.chain, None, chosen, "armature", dtype)
