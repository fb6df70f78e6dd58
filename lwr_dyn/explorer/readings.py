"""What the page needs to say what a slip of the paper changes, and what a payload does: further inverse dynamics."""

import json

from lwr_dyn.codegen.kernel import require_packages
from lwr_dyn.errors import LwrDynError
from lwr_dyn.loading import load_with_paper
from lwr_dyn.model.arm import Arm
from lwr_dyn.papers.catalog import readings, robots


def further_script(arm: Arm) -> str:
    """The script that defines `otherReadings` (reading -> inverse dynamics) and, where it can be made, `loadedRobot`.

    Other readings are those of a robot of the package that is neither mounted nor has a tool.
    """
    scripts = [_dynamics(arm, "loadedRobot", ("payload",)) or "var loadedRobot = null;"]
    names: list[str] = []
    for name, other in other_readings(arm).items():
        script = _dynamics(other, f"reading{len(names) + 1}", ())
        if script:
            names.append(f"{json.dumps(name)}: reading{len(names) + 1}")
            scripts.append(script)
    scripts.append(f"var otherReadings = {{ {', '.join(names)} }};")
    return "\n".join(scripts)


def other_readings(arm: Arm) -> dict[str, Arm]:
    """The same robot as its paper's other readings have it."""
    if arm.file or arm.installation is not None or arm.name not in robots() or arm.reading not in readings(arm.name):
        return {}
    return {name: load_with_paper(arm.name, name)[0] for name in readings(arm.name) if name != arm.reading}


def _dynamics(arm: Arm, name: str, inputs: tuple[str, ...]) -> str:
    try:
        require_packages()
        from lwr_dyn.emit.emission import emitted_arm
        from lwr_dyn.emit.functions import emitted_function
        from lwr_dyn.emit.javascript_file import javascript_source

        spec = emitted_arm(arm, ("flange_pose",), inputs=inputs).spec
        function = emitted_function(spec, "inverse_dynamics", arm)
    except LwrDynError:
        return ""
    return javascript_source([function], name, is_compact=True)
