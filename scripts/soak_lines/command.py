"""`lwr-dyn` in a process of its own, with what it cost."""

from __future__ import annotations

import subprocess
import sys

_COMMAND = """
import sys, time
from pathlib import Path
from lwr_dyn.cli.main import main
start, code = time.perf_counter(), 0
try:
    main(sys.argv[1:])
except SystemExit as end:
    code = end.code
peak = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
print(f"{code} {time.perf_counter() - start} {peak / 1e6}", file=sys.stderr)
"""


def command(*arguments: str) -> tuple[int, float, float, str]:
    """`lwr-dyn` in a process of its own: exit code, seconds, peak memory [GB], what it printed."""
    done = subprocess.run([sys.executable, "-c", _COMMAND, *arguments], capture_output=True, text=True)
    code, seconds, gigabytes = done.stderr.strip().splitlines()[-1].split()
    return int(code), float(seconds), float(gigabytes), done.stdout
