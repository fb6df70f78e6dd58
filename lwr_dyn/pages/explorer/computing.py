"""What an arm's page computes with: emitted functions as a script, the code of `lwr-dyn kernels --language js`.

The links' inertial parameters and gravity are arguments, rotors are added by the page, so that arms with the same
kinematics and limits, such as the readings of one paper, need one set of functions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.kernel import require_packages
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.model.arm import Arm

FUNCTIONS = (
    "inverse_dynamics", "mass_matrix", "gravity_vector", "flange_pose", "jacobian", "inverse_kinematics",
)  # fmt: skip
MOST_JOINTS = 8
"""Of an arm whose dynamics are written out: they grow with the square of the joints; longer ones have kinematics."""
KINEMATICS = ("flange_pose", "jacobian")
BUNDLE = "bundle/three.min.js"


@dataclass(frozen=True, slots=True)
class FunctionSets:
    """The functions of the arms of a page."""

    script: str
    """Defines `armSets`, a list of sets of functions; empty where no arm has one."""
    places: tuple[int | None, ...]
    """Of each arm's set in that list."""
    missing: tuple[str, ...]
    """Of each arm, what it lacks and why; empty where it has all."""


def function_sets(arms: Sequence[Arm]) -> FunctionSets:
    """The functions of some arms, each set once."""
    found: dict[bytes, int] = {}
    sources: list[str] = []
    places: list[int | None] = []
    missing: list[str] = []
    why: dict[bytes, str] = {}
    for arm in arms:
        key = _kinematics(arm)
        if key not in why:
            source, why[key] = functions_script(arm, f"armFunctions{len(sources)}")
            if source:
                found[key] = len(sources)
                sources.append(source)
        places.append(found.get(key))
        missing.append(why[key])
    names = ", ".join(f"armFunctions{k}" for k in range(len(sources)))
    script = "\n".join([*sources, f"var armSets = [{names}];"]) if sources else ""
    return FunctionSets(script, tuple(places), tuple(missing))


def functions_script(arm: Arm, name: str) -> tuple[str, str]:
    """The script that defines the functions of an arm, and what it lacks; an empty script where nothing is known."""
    try:
        require_packages()
        from lwr_dyn.codegen.emit.functions import Emitted, emitted_function
        from lwr_dyn.codegen.emit.javascript_file import javascript_source

        spec = _spec(arm)
    except LwrDynError as fault:
        return "", f"this page does not compute: {fault}"
    functions: list[Emitted] = []
    is_long = arm.n > MOST_JOINTS
    missing = (
        [f"torques are computed for arms of at most {MOST_JOINTS} joints; this one has {arm.n}"] if is_long else []
    )
    for function in KINEMATICS if is_long else FUNCTIONS:
        try:
            functions.append(emitted_function(spec, function, arm))
        except LwrDynError as fault:
            missing.append(str(fault))
    return javascript_source(functions, name, is_compact=True), "; ".join(dict.fromkeys(missing))


def _spec(arm: Arm) -> Any:
    """With inertia and gravity as arguments; an arm without masses keeps its kinematics."""
    from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, kernel_spec
    from lwr_dyn.foundation.errors import MissingDataError

    inputs = ("inertia", "gravity")
    try:
        return kernel_spec(arm, inputs, rotors="none")
    except MissingDataError:
        return KernelSpec(arm.name, arm.chain, None, inputs, "none")


def _kinematics(arm: Arm) -> bytes:
    """All on which the functions of an arm depend: kinematics, limits, and whether its masses are known."""
    chain = arm.chain
    poses = [pose.matrix() for link in chain.links for pose in (link.before, link.after)]
    kinds = "".join(link.kind.value for link in chain.links)
    has_masses = all(link.body is not None and not link.body.unknown for link in chain.links)
    numbers = np.concatenate([np.ravel(x) for x in (*poses, chain.flange.matrix(), arm.lower, arm.upper)])
    return f"{kinds} {has_masses or arm.digest}".encode() + np.asarray(numbers, dtype=np.float64).tobytes()


def three_bundle() -> str:
    """three.js with its controls as a script that defines `lwrThree`; made by scripts/build_three.py."""
    return files("lwr_dyn.pages.explorer").joinpath(BUNDLE).read_text(encoding="utf-8")
