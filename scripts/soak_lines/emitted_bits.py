"""Emitted code of every function of three arms: the same bits in C, JavaScript and on a Cortex-M7."""

from __future__ import annotations

import tempfile
from pathlib import Path

from lwr_dyn.foundation.tables import aligned

STATES, IK_STATES = 3000, 500
COMPILERS = (
    ("gcc", ("-std=c99", "-O2", "-fno-tree-slp-vectorize")),
    ("gcc", ("-std=c99", "-O3", "-march=native")),
    ("gcc", ("-std=gnu11", "-O0")),
    ("clang", ("-std=c99", "-O2")),
    ("clang", ("-std=c99", "-O3", "-march=native")),
)
NAMES = (
    "inverse_dynamics", "forward_dynamics", "mass_matrix", "coriolis_matrix", "gravity_vector", "bias_torque",
    "flange_pose", "jacobian", "torque_regressor", "kinetic_energy", "potential_energy", "step_pd_gravity", "step_pid",
    "step_inverse_dynamics", "step_adaptive",
)  # fmt: skip


def emitted_bits() -> tuple[str, bool, str]:
    """Emitted code of 15 functions of 3 arms and inverse kinematics: bits in C, node and Cortex-M7, beside node's."""
    from tests.codegen.emit.cortex import linked, run_lines
    from tests.codegen.emit.digests import C_PRINT, c_functions, c_main, js_program
    from tests.codegen.emit.emitted_robots import ARMS, emitted_robot
    from tests.codegen.emit.programs import output

    robots = [emitted_robot(name, NAMES) for name in ARMS]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        texts = {robot.name: c_functions(robot) for robot in robots}
        texts |= {"main": c_main(robots, STATES), "print": C_PRINT}
        for stem, text in texts.items():
            (folder / f"{stem}.c").write_text(text)
        own, board = [folder / f"{stem}.c" for stem in (*ARMS, "main")], folder / "image.elf"
        lines = {}
        for is_compact in (False, True):
            script = folder / f"compact_{is_compact}.js"
            script.write_text(js_program(robots, STATES, is_compact) + '\nconsole.log(lines.join("\\n"));\n')
            lines["node, compact" if is_compact else "node"] = output(["node", str(script)]).splitlines()
        for compiler, flags in COMPILERS:
            made = folder / "made"
            output([compiler, *flags, *map(str, own), str(folder / "print.c"), "-o", str(made), "-lm"], seconds=600)
            lines[f"{compiler} {' '.join(flags)}"] = output([str(made)]).splitlines()
        lines["arm-none-eabi-gcc"] = run_lines(linked(own, board, "-ffp-contract=off"))
        for build, found in _closed_form(folder).items():
            lines[build] += found
    for what, found in lines.items():
        same = sum(a == b for a, b in zip(found, lines["node"], strict=True))
        rows.append((what, f"{same} of {len(found)}"))
    holds = all(found == lines["node"] for found in lines.values())
    return f"{len(lines['node'])} functions in {len(rows)} builds", holds, aligned(rows, ("build", "equal"))


def _closed_form(folder: Path) -> dict[str, list[str]]:
    """The digests of inverse kinematics in the same builds."""
    from tests.codegen.emit.closed_form_digests import js_program, write_c
    from tests.codegen.emit.cortex import linked, run_lines
    from tests.codegen.emit.emitted_robots import ARMS
    from tests.codegen.emit.programs import output

    script, made = folder / "ik.js", folder / "made_ik"
    lines: dict[str, list[str]] = {}
    for is_compact in (False, True):
        script.write_text(js_program(ARMS, IK_STATES, is_compact=is_compact) + '\nconsole.log(lines.join("\\n"));\n')
        lines["node, compact" if is_compact else "node"] = output(["node", str(script)]).splitlines()
    own = write_c(ARMS, folder, IK_STATES)
    files = [*map(str, own), str(folder / "print.c"), "-o", str(made), "-lm"]
    for compiler, flags in COMPILERS:
        output([compiler, *flags, *files], seconds=600)
        lines[f"{compiler} {' '.join(flags)}"] = output([str(made)]).splitlines()
    board = linked(own, folder / "ik.elf", "-ffp-contract=off", "-fno-math-errno")
    lines["arm-none-eabi-gcc"] = run_lines(board)
    return lines
