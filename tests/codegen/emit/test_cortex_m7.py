"""What a step of control costs on a Cortex-M7: flash, stack and instructions, as compiled and as run."""

import re
from pathlib import Path

import pytest

from lwr_dyn.codegen.emit.c_file import c_function, declaration
from lwr_dyn.codegen.emit.functions import emitted_code
from tests.codegen.emit.cortex import FLAGS, linked, run_lines
from tests.codegen.emit.emitted_robots import ARMS, emitted_robot
from tests.codegen.emit.programs import output, program

CALLS = 500
INSTRUCTIONS = 40
"""Of a tick: the clock of the board is 25 MHz beside one instruction a ns."""
MAIN = """
void print(const char *text);
unsigned int ticks(void);
static double in[8][8], out[8];
static void nothing(void) { __asm__ volatile(""); }
static void step(void) { CALL; }
static unsigned int measured(void (*call)(void))
{
    unsigned int from = ticks();
    for (int i = 0; i < CALLS; i++) call();
    return (ticks() - from) & 0xffffffu;
}
int main(void)
{
    char text[12] = "0000000000\\n";
    for (int a = 0; a < 8; a++)
        for (int k = 0; k < 8; k++) in[a][k] = 0.1 * (a + 1) * (k - 3.5);
    unsigned int empty = measured(nothing), all = measured(step) - empty;
    for (int i = 9; i >= 0; i--, all /= 10) text[i] = (char)('0' + all % 10);
    print(text);
    return 0;
}
"""


def costs(function, folder: Path, *flags: str) -> tuple[int, int, int]:
    """(bytes of flash, bytes of stack, instructions a call) of a function."""
    compiler = program("arm-none-eabi-gcc")
    program("qemu-system-arm")
    code = emitted_code(function)
    source, main, made = folder / "step.c", folder / "main.c", folder / "step.o"
    source.write_text(c_function(code, "control_step", "restrict"))
    output([compiler, *FLAGS, *flags, "-fstack-usage", "-c", str(source), "-o", str(made)], folder)
    (stack,) = re.findall(r"\t(\d+)\tstatic", made.with_suffix(".su").read_text())
    flash = output(["arm-none-eabi-size", str(made)]).splitlines()[1].split()[0]
    call = f"control_step({', '.join(f'in[{i}]' for i in range(len(function.arguments)))}, out)"
    main.write_text(
        declaration(code, "control_step", "restrict") + ";\n" + MAIN.replace("CALLS", str(CALLS)).replace("CALL", call)
    )
    (shown,) = run_lines(linked([source, main], folder / "step.elf", *flags), "-icount", "shift=0")
    return int(flash), int(stack), round(int(shown) * INSTRUCTIONS / CALLS)


@pytest.mark.parametrize("contraction", ["off", "fast"])
@pytest.mark.parametrize("arm", ARMS)
def test_a_step_of_control_fits_a_small_controller(arm, contraction, tmp_path):
    """The registered law of inverse dynamics: its gains are arguments."""
    (step,) = emitted_robot(arm, ("step_inverse_dynamics",)).functions
    flash, stack, instructions = costs(step, tmp_path, f"-ffp-contract={contraction}")
    assert 1000 < flash < 8000
    assert 100 < stack < 700
    assert len(emitted_code(step).statements) < instructions < 1800


def test_the_counter_counts_instructions(tmp_path):
    """Of 400 that do nothing, within the call's own few."""
    program("arm-none-eabi-gcc"), program("qemu-system-arm")
    main = tmp_path / "main.c"
    nothing = '__asm__ volatile(".rept 400\\n nop\\n .endr")'
    main.write_text(MAIN.replace("CALLS", str(CALLS)).replace("CALL", nothing))
    (shown,) = run_lines(linked([main], tmp_path / "nops.elf"), "-icount", "shift=0")
    assert abs(int(shown) * INSTRUCTIONS / CALLS - 400) < 10
