"""What a peer's process does: it runs its loop once for each line it is sent, and answers with the time it took."""

import json
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np


def serve(packages: tuple[str, ...], loop: Callable[[], np.ndarray], folder: Path) -> None:
    """Versions first; then, for each line, the final positions into `end.npy` and the processor time [s]."""
    print(json.dumps({name: version(name) for name in packages}), flush=True)
    for _ in sys.stdin:
        start = time.process_time()
        end = loop()
        took = time.process_time() - start
        np.save(folder / "end.npy", end)
        print(took, flush=True)
