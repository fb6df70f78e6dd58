"""KRL lines and files, written and read back."""

from __future__ import annotations

from lwr_dyn.krl.language.source import parse_bytes, parse_text
from tests.krl.random_programs import Writer

PROGRAMS = 30_000


def krl_written() -> tuple[str, bool]:
    """30 000 random programs of every form of line are written, read back the same, and written again byte for byte."""
    lines = 0
    for seed in range(PROGRAMS):
        file = Writer(seed).file()
        back, diagnostics = parse_text(file.text(), file.name)
        again, _ = parse_bytes(back.to_bytes(), file.name)
        if diagnostics or back != file or again.to_bytes() != back.to_bytes():
            return f"program {seed} differs", False
        lines += len(file.lines)
    return f"{PROGRAMS} programs, {lines} lines", True
