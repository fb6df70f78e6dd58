"""Large KRL programs."""

from __future__ import annotations

import tempfile
from pathlib import Path

from soak_lines.command import command


def krl_large() -> tuple[str, bool]:
    """A KRL program of 100 000 lines, read and checked."""
    rows = ["DEF big( )", "REAL x", "BAS(#VEL_PTP, 100)", "$VEL.CP = 0.3", "x = 0"]
    rows += ["PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}", "PTP {X 1200, Y 0, Z 1300, A 0, B 90, C 0, S 2, T 2}"]
    while len(rows) < 99_999:
        i = len(rows)
        place = f"X {1200 + i % 97}.{i % 89}, Y {i % 83}, Z {1300 + i % 79}, A 0.0, B 90.0, C 0.0"
        rows += [f"IF x < {i} THEN", f"  x = x + {i}.5 ; {i}", "ENDIF", f"LIN {{{place}}} C_DIS"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "big.src"
        path.write_text("\r\n".join([*rows[:99_999], "END"]))
        code, seconds, gigabytes, output = command("krl", "check", str(path))
    good = code == 0 and seconds < 20.0 and gigabytes < 1.0
    return f"{seconds:.1f} s, {1e3 * gigabytes:.0f} MB; {output.strip().splitlines()[-1].rpartition(': ')[2]}", good
