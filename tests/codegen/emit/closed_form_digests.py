"""The same program in C and JavaScript for inverse kinematics: digests of all bits of what its functions give.

Poses are those of random positions, singular ones among them; some are out of reach, some are no poses at all.
"""

from collections.abc import Sequence
from pathlib import Path

import lwr_dyn
from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.closed_form import NAME
from lwr_dyn.codegen.emit.emission import emitted_arm
from lwr_dyn.codegen.emit.functions import SinCosKind
from lwr_dyn.codegen.emit.javascript_file import javascript_source
from tests.codegen.emit.digests import C_TOOLS, JS_TOOLS

_STATE = """
        fill({q}); fill({psi});
        {robot}flange_pose(q, pose);
        if (k % 8 == 7) fill({pose});
        if (k % 8 == 5) pose[3] *= 3.0;
"""
_CALLS = {
    "": ("x[0] = {f}(pose, {angle}out);", "{x} {out}"),
    "_near": ("fill({near}); x[0] = {f}_near(pose, {angle}near, found);", "{x} {found}"),
    "_arm_angle": ("{f}_arm_angle(q, four);", "{four}"),
    "_intervals": ("x[0] = {f}_intervals(pose, 0.05, pairs, counts);", "{x} {pairs} {counts}"),
}
"""Ending of a name -> call, and the arrays that are mixed into the digest."""
_SIZES = {"q": 0, "psi": 1, "pose": 16, "near": 0, "x": 1, "found": 0, "four": 4, "pairs": 256, "out": 56}


def write_c(names: Sequence[str], folder: Path, states: int, kind: SinCosKind = "own") -> list[Path]:
    """The arms' files and the program around them; returns those to compile."""
    made = []
    for name in names:
        emitted = emitted_arm(lwr_dyn.load(name), ("flange_pose", NAME), kind=kind)
        for path, text in c_files(emitted, folder / f"{name}_ik.c").items():
            path.write_text(text)
        made.append(folder / f"{name}_ik.c")
    heads = "".join(f'#include "{name}_ik.h"\n' for name in names)
    loops = "".join(_c_loops(name, states) for name in names)
    (folder / "ik_main.c").write_text(f"{heads}{C_TOOLS}int main(void)\n{{\n{loops}    return 0;\n}}\n")
    return [*made, folder / "ik_main.c"]


def js_program(
    names: Sequence[str], states: int, kind: SinCosKind = "own", is_compact: bool = False
) -> str:  # fmt: skip
    """A plain script; its lines are in `lines`."""
    texts = []
    for name in names:
        emitted = emitted_arm(lwr_dyn.load(name), ("flange_pose", NAME), kind=kind)
        functions = [*(code.function for code in emitted.codes), *emitted.templates]
        texts += [javascript_source(functions, name, "script", kind, is_compact), _js_loops(name, states)]
    return "\n".join([JS_TOOLS, *texts])


def _calls(n: int) -> list[str]:
    return [ending for ending in _CALLS if n == 7 or ending in ("", "_near")]


def _c_loops(name: str, states: int) -> str:
    n = lwr_dyn.load(name).n
    words = {array: f"{array}, {size or n}" for array, size in _SIZES.items()}
    mixes = {array: f"mix({word});" for array, word in words.items()}
    mixes["counts"] = "for (int b = 0; b < 8; b++) { x[0] = counts[b]; mix(x, 1); }"
    begin = f"""    {{
    static double q[{n}], psi[1], pose[16], near[{n}], x[1], out[56], found[{n}], four[4], pairs[256];
    static int counts[8];
    (void)near; (void)four; (void)pairs; (void)counts;
"""
    return begin + _loops(name, n, states, words, mixes, f"{name}_", "int k") + "    }\n"


def _js_loops(name: str, states: int) -> str:
    n = lwr_dyn.load(name).n
    words = {array: array for array in _SIZES}
    mixes = {array: f"mix({array});" for array in _SIZES} | {"counts": "mix(Float64Array.from(counts));"}
    arrays = ", ".join(f"{array} = new Float64Array({size or n})" for array, size in _SIZES.items())
    begin = f"{{ const {arrays}, counts = new Int32Array(8);\n"
    return begin + _loops(name, n, states, words, mixes, f"{name}.", "let k") + "}\n"


def _loops(
    name: str, n: int, states: int, words: dict[str, str], mixes: dict[str, str], robot: str, counter: str
) -> str:  # fmt: skip
    seed = "state = 1; digest[0] = digest[1] = 0;" if robot.endswith("_") else "word[0] = 1; digest.fill(0);"
    text = ""
    for ending in _calls(n):
        call, shown = (x.format(f=robot + NAME, angle="psi[0], " if n == 7 else "", **(words if i == 0 else mixes))
                       for i, x in enumerate(_CALLS[ending]))  # fmt: skip
        state = _STATE.format(robot=robot, **words)
        text += f"    {seed}\n    for ({counter} = 0; k < {states}; k++) {{{state}        {call} {shown}\n    }}\n"
        text += f'    show("{name}_{NAME}{ending}");\n'
    return text
