"""One batch of fuzzed inputs in a process of its own, with bounds of memory and time: `fuzz.py` starts it.

python fuzz_worker.py READER SEED BEGIN END FOLDER
"""

from __future__ import annotations

import contextlib
import json
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # for `tests`

from tests.hostile.readers import one_input

MEMORY = 1_000_000_000
"""[bytes] Beyond what the loaded libraries take."""
LONGEST = 1.0
"""[s] Of CPU time for one input."""
WARM = 60
"""Inputs before the first that counts: they load what the reader needs."""
HANG = 10
"""[s] After this an input is stopped."""


class HangError(Exception):
    """An input took too long."""


def _stop(*_: object) -> None:
    raise HangError("hang")


def _statm(column: int) -> int:
    return int(Path("/proc/self/statm").read_text().split()[column]) * resource.getpagesize()


def _bounded() -> None:
    """No more than `MEMORY` beyond what is loaded; a C function that hangs is killed."""
    resource.setrlimit(resource.RLIMIT_AS, (_statm(0) + MEMORY,) * 2)
    signal.signal(signal.SIGPROF, _stop)


def batch(reader: str, seed: int, begin: int, end: int, folder: Path) -> dict[str, Any]:
    """Counts of one batch; `folder/at` always names the input at work."""
    with tempfile.TemporaryDirectory() as place:
        for warm in range(1, WARM):
            with contextlib.suppress(Exception):  # what is wrong shows below
                one_input(reader, seed, -warm, Path(place))
        _bounded()
        base, out = _statm(1), {"inputs": 0, "read": 0, "slow": [], "slowest": 0.0, "foreign": []}
        for number in range(begin, end):
            (folder / "at").write_text(str(number))
            start = time.process_time()
            signal.setitimer(signal.ITIMER_PROF, HANG)
            try:
                out["read"] += one_input(reader, seed, number, Path(place))
            except Exception as fault:
                out["foreign"].append([number, _place(fault)])
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
            took = time.process_time() - start
            out["inputs"] += 1
            out["slowest"] = max(out["slowest"], took)
            if took > LONGEST:
                out["slow"].append([number, round(took, 2)])
    out["peak"] = max(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - base, 0)
    return out


def _place(fault: Exception) -> str:
    frame = traceback.extract_tb(fault.__traceback__)[-1]
    return f"{type(fault).__name__} at {Path(frame.filename).name}:{frame.lineno}: {str(fault)[:120]!r}"


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    reader, seed, begin, end, folder = sys.argv[1], *map(int, sys.argv[2:5]), Path(sys.argv[5])
    (folder / "result").write_text(json.dumps(batch(reader, seed, begin, end, folder)))
