"""A peer in an environment of its own, in turns with us: it may need another version of a package than we do."""

from __future__ import annotations

import json
import subprocess
import sys
import venv
from pathlib import Path

import numpy as np

PEERS = {"mjbatch": ("mjbatch==0.1.4",), "drake": ("drake==1.51.1",)}
"""What is installed in the environment of a peer."""
HERE = Path(__file__).resolve().parent / "peers"


def interpreter(folder: Path, peer: str) -> Path:
    """The Python of a peer's environment in this folder; made with pip where it is not there."""
    python = folder / peer / "bin" / "python"
    if not python.is_file():
        print(f"(making {folder / peer}: {' '.join(PEERS[peer])})", file=sys.stderr, flush=True)
        venv.create(folder / peer, with_pip=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", *PEERS[peer]], check=True)
    return python


class PeerProcess:
    """The closed loop of a peer; `seconds` runs it once."""

    def __init__(self, python: Path, peer: str, folder: Path, runs: int) -> None:
        command = [str(python), str(HERE / f"{peer}_loop.py"), str(folder), str(runs)]
        self._folder = folder
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.versions: dict[str, str] = json.loads(self._answer())

    def __enter__(self) -> PeerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()

    def _answer(self) -> str:
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self._process.args}: ended with {self._process.wait()}")
        return line

    def seconds(self) -> float:
        """Processor time of one loop [s]."""
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return float(self._answer())

    def end(self) -> np.ndarray:
        """The final positions (runs, n) of the last loop."""
        return np.load(self._folder / "end.npy")
