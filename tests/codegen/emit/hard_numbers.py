"""A program that calls every emitted function of an arm with numbers that are none, infinite, huge and tiny.

Arrays have exactly the sizes of the header, so that an address sanitizer sees a number too many.
"""

from pathlib import Path

from lwr_dyn.codegen.emit.c_file import c_files
from lwr_dyn.codegen.emit.closed_form import NAME
from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.emit.functions import TemplateFunction
from lwr_dyn.codegen.emit.further_functions import EXPANDED

SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
_TOOLS = """\
#include <math.h>
#include <stdio.h>
#include <stdint.h>
static uint32_t state = 1;
static const double hard[12] = {
    (double)NAN, (double)INFINITY, -(double)INFINITY, 1e300, -1e300,
    5e-324, -1e-310, 0.0, -0.0, 1e7, 1.5707963267948966, 1e-8};
static uint32_t drawn(void)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}
/* one array in four has hard numbers alone, one in four some, others none */
static void fill(NUMBER *x, int n)
{
    const uint32_t kind = drawn() % 4;
    for (int i = 0; i < n; i++) {
        const uint32_t one = drawn();
        const double plain = (double)one / 715827882.0 - 3.0;
        x[i] = (NUMBER)(kind == 0 || (kind == 1 && one % 5 == 0) ? hard[drawn() % 12] : plain);
    }
}
"""
_SRS = f"""\
    double pose[16], psi[1], q[7], near[7], out[56], four[4], pairs[256], found[7];
    int counts[8];
    fill(pose, 16); fill(psi, 1); fill(q, 7); fill(near, 7);
    @_{NAME}(pose, psi[0], out);
    @_{NAME}_arm_angle(q, four);
    @_{NAME}_intervals(pose, psi[0], pairs, counts);
    @_{NAME}_near(pose, psi[0], near, found);
"""
_SIX = f"""\
    double pose[16], near[6], out[48], found[6];
    fill(pose, 16); fill(near, 6);
    @_{NAME}(pose, out);
    @_{NAME}_near(pose, near, found);
"""
_BEGIN = "static long calls;\nint main(void)\n{\n"
_END = '    printf("%ld\\n", calls);\n    return 0;\n}\n'


def write_program(emitted: EmittedArm, folder: Path, states: int) -> list[str]:
    """The arm's file and the program; returns the names of the files to compile."""
    for path, text in c_files(emitted, folder / "arm.c").items():
        path.write_text(text)
    blocks = [_straight(emitted, code.function) for code in emitted.codes]
    blocks += [_template(emitted, template) for template in emitted.templates]
    loops = "".join(f"    for (int k = 0; k < {states}; k++, calls++) {{\n{block}    }}\n" for block in blocks)
    number = "float" if emitted.dtype == "float32" else "double"
    text = f'#include "arm.h"\n{_TOOLS}{_BEGIN}{loops}{_END}'
    (folder / "main.c").write_text(text.replace("NUMBER", number))
    return ["arm.c", "main.c"]


def _straight(emitted: EmittedArm, function: object) -> str:
    arguments = function.arguments  # type: ignore[attr-defined]
    arrays = "".join(f"NUMBER {a.name}_[{a.width}]; fill({a.name}_, {a.width}); " for a in arguments)
    given = "".join(f"{a.name}_, " for a in arguments)
    width, name = function.width, emitted.name_of(function.name)  # type: ignore[attr-defined]
    return f"        {arrays}NUMBER out[{width}];\n        {name}({given}out);\n"


def _template(emitted: EmittedArm, template: TemplateFunction) -> str:
    if template.name == NAME:
        text = _SRS if emitted.arm.n == 7 else _SIX
        return text.replace("@_", f"{emitted.prefix}_")
    assert template.name == EXPANDED
    head = template.declaration["c"]
    narrow, wide = (int(head.split(f"{array}[")[1].split("]")[0]) for array in ("values", "out"))
    name = emitted.name_of(EXPANDED)
    return (f"        NUMBER values[{narrow}], out[{wide}]; fill(values, {narrow});\n        {name}(values, out);\n"
            f"        calls += {name}_index(k % {wide}) > 1000;\n")  # fmt: skip
