"""The same program in C and JavaScript: random states, made of whole numbers, and a digest of all bits of the results.

Zeros and right angles are among the numbers. A line of output is "ROBOT_FUNCTION DIGEST"; equal lines mean equal bits
of every result; NaN counts as one number, since processors differ in its sign.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.codegen.emit.c_file import c_function, declaration, shared_functions
from lwr_dyn.codegen.emit.functions import EmittedFunction, emitted_code
from lwr_dyn.codegen.emit.javascript_file import javascript_source

C_TOOLS = """\
#include <stdint.h>
#include <string.h>
#include <math.h>
void print(const char *text);
static uint32_t state, digest[2];
static const double special[4] = {0.0, -0.0, 1.5707963267948966, 3.141592653589793};
static void fill(double *x, int n)
{
    for (int i = 0; i < n; i++) {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        uint32_t kind = (state >> 7) % 32;
        x[i] = kind < 4 ? special[kind] : (double)(int32_t)state / 536870912.0;
    }
}
static void mix(const double *x, int n)
{
    for (int i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &x[i], 8);
        if (x[i] != x[i]) bits = UINT64_C(0x7ff8000000000000);
        digest[0] = (digest[0] ^ (uint32_t)bits) * 16777619u;
        digest[1] = (digest[1] ^ (uint32_t)(bits >> 32)) * 16777619u;
    }
}
static void show(const char *name)
{
    char text[24] = " ";
    for (int i = 0; i < 16; i++) text[i + 1] = "0123456789abcdef"[(digest[i / 8] >> (28 - 4 * (i % 8))) & 15];
    text[17] = '\\n';
    print(name);
    print(text);
}
"""
C_PRINT = "#include <stdio.h>\nvoid print(const char *text) { fputs(text, stdout); }\n"
"""On a machine with a library; on the microcontroller the start-up code prints."""
JS_TOOLS = """\
const word = new Int32Array(1), digest = new Int32Array(2), lines = [];
const special = [0.0, -0.0, 1.5707963267948966, 3.141592653589793];
function fill(x) {
  for (let i = 0; i < x.length; i++) {
    word[0] ^= word[0] << 13;
    word[0] ^= word[0] >>> 17;
    word[0] ^= word[0] << 5;
    const kind = (word[0] >>> 7) % 32;
    x[i] = kind < 4 ? special[kind] : word[0] / 536870912.0;
  }
}
function mix(x) {
  for (let i = 0; i < x.length; i++) if (x[i] !== x[i]) x[i] = NaN;
  const words = new Int32Array(x.buffer);
  for (let i = 0; i < words.length; i++) digest[i % 2] = Math.imul(digest[i % 2] ^ words[i], 16777619);
}
function show(name) {
  lines.push(name + " " + Array.from(new Uint32Array(digest.buffer), x => x.toString(16).padStart(8, "0")).join(""));
}
function digests(robot, states) {
  for (const [name, about] of Object.entries(robot.functions)) {
    const values = about.arguments.map(([, width]) => new Float64Array(width)), out = new Float64Array(about.width);
    word[0] = 1; digest.fill(0);
    for (let k = 0; k < states; k++) {
      values.forEach(fill);
      robot[name](...values, out);
      mix(out);
    }
    show(robot.name + "_" + name);
  }
}
"""


@dataclass(frozen=True, slots=True, eq=False)
class EmittedRobot:
    """An arm's functions, to be run."""

    name: str
    functions: Sequence[EmittedFunction]


def c_functions(robot: EmittedRobot) -> str:
    """The functions, with what they include and call."""
    codes = [emitted_code(f) for f in robot.functions]
    texts = [c_function(code, f"{robot.name}_{code.function.name}", "restrict") for code in codes]
    return "\n".join(["#include <math.h>", shared_functions(codes), *texts])


def c_main(robots: Sequence[EmittedRobot], states: int) -> str:
    """The program around them."""
    named = [(f"{robot.name}_{f.name}", f) for robot in robots for f in robot.functions]
    heads = [declaration(emitted_code(f), name, "restrict") + ";" for name, f in named]
    widest = max(f.width for _, f in named)
    lines = [C_TOOLS, *heads, f"static double in[16][512], out[{widest}];", "int main(void)", "{"]
    for name, f in named:
        arguments = "".join(f"in[{k}], " for k in range(len(f.arguments)))
        fills = " ".join(f"fill(in[{k}], {a.width});" for k, a in enumerate(f.arguments))
        lines += [
            "    state = 1; digest[0] = digest[1] = 0;",
            f"    for (int k = 0; k < {states}; k++) {{ {fills} {name}({arguments}out); mix(out, {f.width}); }}",
            f'    show("{name}");',
        ]
    return "\n".join([*lines, "    return 0;", "}", ""])


def js_program(robots: Sequence[EmittedRobot], states: int, is_compact: bool = False) -> str:
    """A plain script; its lines are in `lines`."""
    texts = [javascript_source(robot.functions, robot.name, is_compact=is_compact) for robot in robots]
    return "\n".join([JS_TOOLS, *texts, *(f"digests({robot.name}, {states});" for robot in robots)])
