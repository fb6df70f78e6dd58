"""What an arm's page computes with: its functions as a script, the code of `lwr-dyn kernels --language js`."""

from importlib.resources import files

from lwr_dyn.codegen.kernel import require_packages
from lwr_dyn.errors import LwrDynError
from lwr_dyn.model.arm import Arm

FUNCTIONS = (
    "inverse_dynamics", "mass_matrix", "coriolis_matrix", "gravity_vector", "flange_pose", "jacobian",
    "inverse_kinematics",
)  # fmt: skip
MOST_JOINTS = 8
"""Of an arm whose functions are written out: they grow with the cube of the joints."""
BUNDLE = "bundle/three.min.js"


def robot_script(arm: Arm) -> tuple[str, str]:
    """The script that defines `robot`, and why it has no more than it has; an empty script where nothing is known."""
    if arm.n > MOST_JOINTS:
        return "", f"this page computes for arms of at most {MOST_JOINTS} joints; this one has {arm.n}"
    try:
        require_packages()
        from lwr_dyn.emit.emission import emitted_arm
        from lwr_dyn.emit.functions import Emitted, emitted_function
        from lwr_dyn.emit.javascript_file import javascript_source

        emitted = emitted_arm(arm, ("flange_pose", "jacobian"))
    except LwrDynError as fault:
        return "", f"this page does not compute: {fault}"
    functions: list[Emitted] = []
    missing: list[str] = []
    for name in FUNCTIONS:
        try:
            functions.append(emitted_function(emitted.spec, name, arm))
        except LwrDynError as fault:
            missing.append(str(fault))
    return javascript_source(functions, "robot", is_compact=True), "; ".join(dict.fromkeys(missing))


def three_bundle() -> str:
    """three.js with its controls as a script that defines `lwrThree`; made by scripts/build_three.py."""
    return files("lwr_dyn.explorer").joinpath(BUNDLE).read_text(encoding="utf-8")
