"""A Cortex-M7 with a unit for double numbers, emulated: compile, link without a library, run."""

import subprocess
from pathlib import Path

from tests.codegen.emit.programs import output, program

FOLDER = Path(__file__).parent / "cortex_m7"
FLAGS = ("-std=c99", "-O2", "-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard")


def linked(sources: list[Path], out: Path, *flags: str) -> Path:
    """The image of some C files with the start-up code; raises `AssertionError` where a function is missing."""
    tools = ["-nostartfiles", "--specs=nosys.specs", "-T", str(FOLDER / "link.ld"), str(FOLDER / "start.c")]
    output([program("arm-none-eabi-gcc"), *FLAGS, *flags, *tools, *map(str, sources), "-o", str(out)])
    return out


def run_lines(image: Path, *flags: str) -> list[str]:
    """What the image prints."""
    board = [program("qemu-system-arm"), "-M", "mps2-an500", "-nographic", "-semihosting", *flags, "-kernel"]
    done = subprocess.run([*board, str(image)], capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=120)
    return (done.stdout + done.stderr).splitlines()
