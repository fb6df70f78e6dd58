"""Logs as robots write them: names of their own, uneven times, a torque cut off, a wrong sign, order and unit."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.column_files import table_bytes
from lwr_dyn.foundation.files import make_folder, write_file
from lwr_dyn.model.friction import friction_torque, symmetric

MAP = """time = "stamp"
q = "lbr_pos_*"
tau = "lbr_trq_*"

[units]
time = "ms"
q = "deg"
tau = "N m"
"""


def recording(rng: np.random.Generator, rate: float = 200.0, seconds: float = 20.0) -> tuple[Array, Array, Array]:
    """Times, positions and torques of five harmonics at every joint, with friction and noise."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    late = rng.uniform(-0.3, 0.3, round(seconds * rate))
    t, w = (np.arange(seconds * rate) + late) / rate, 2 * np.pi * np.arange(1, 6) / 10.0
    size, angle = rng.normal(0.0, 0.2, (7, 5)), w * t[:, None, None] + rng.uniform(0.0, 6.0, (7, 5))
    q, dq, ddq = (np.sum(x * size, axis=-1) for x in (np.sin(angle), w * np.cos(angle), -(w**2) * np.sin(angle)))
    tau = lwr_dyn.dynamics_of(arm).inverse_dynamics(q, dq, ddq) + friction_torque([symmetric(3.0, 2.0)] * 7, dq)
    return t, q, np.clip(tau + rng.normal(0.0, 0.1, tau.shape), -20.0, 20.0)


def written(path: Path, t: Array, q: Array, tau: Array) -> None:
    names = ["stamp", *(f"lbr_pos_{j}" for j in range(7)), *(f"lbr_trq_{j}" for j in range(7))]
    write_file(path, table_bytes(names, [1e3 * t, *np.degrees(q).T, *tau.T], path.suffix))
    print(f"wrote {path}")


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/logs"))
    out: Path = parser.parse_args(arguments).out
    make_folder(out)
    write_file(out / "map.toml", MAP.encode())
    t, q, tau = recording(np.random.default_rng(3))
    written(out / "run.csv", t, q, tau)
    written(out / "sign.csv", t, q * [1, 1, -1, 1, 1, 1, 1], tau)
    written(out / "order.parquet", t, q[:, [0, 1, 2, 4, 3, 5, 6]], tau[:, [0, 1, 2, 4, 3, 5, 6]])
    written(out / "units.csv", t, q, 1e3 * tau)


if __name__ == "__main__":
    main()
