"""How far the path of a program that is run lies from the samples it was written from: both ways, place by place.

Each sample is compared with the nearest place that the program passes in the motion written for it or in the motions
beside it, and each place of the program with the nearest place between the samples. Near is meant in position and
orientation together, each by its tolerance; times are not compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.running.program_run import ProgramRun
from lwr_dyn.krl.writing.path_fit import FittedMotion, Tolerance
from lwr_dyn.krl.writing.sampled_path import SampledPath

FEWEST, MOST = 16, 20_000
"""Places of a motion."""
EVEN = 3000
CORNERS = 4
"""Nearest corners of a line whose pieces are tried: where a path comes back to a place, more than one piece begins."""
FINEST = 0.02
"""Share of the tolerance by which the program's path bends between two places at most."""


@dataclass(frozen=True, slots=True)
class PathDeviation:
    """The largest distance [m] and angle [rad] between a program's path and the samples."""

    position: float
    orientation: float

    def holds(self, tolerance: Tolerance) -> bool:
        """Whether both are within the tolerance."""
        return self.position <= tolerance.position and self.orientation <= tolerance.orientation


def path_deviation(
    samples: SampledPath, motions: Sequence[FittedMotion], run: ProgramRun, tolerance: Tolerance
) -> PathDeviation:
    """Compares a run of the written program with its samples."""
    moved = [x for x in run.executed[1:] if x.kind != "WAIT"]
    weight = tolerance.position / tolerance.orientation
    worst = np.zeros(2)
    ends = np.cumsum([len(motion.knots) or 1 for motion in motions])
    spans = [(moved[b - (len(m.knots) or 1)].begin, moved[b - 1].end) for m, b in zip(motions, ends, strict=True)]
    places = [_program_places(samples, run, begin, end, FINEST * tolerance.position) for begin, end in spans]
    written = [samples.T[m.first : m.last + 1] for m in motions]
    for i in range(len(motions)):
        around = slice(max(i - 1, 0), i + 2)
        worst = np.maximum(worst, _farthest(written[i], np.concatenate(places[around]), weight))
        worst = np.maximum(worst, _farthest(places[i], np.concatenate(written[around]), weight))
    return PathDeviation(float(worst[0]), float(worst[1]))


def _program_places(samples: SampledPath, run: ProgramRun, begin: float, end: float, finest: float) -> Array:
    """Poses (k, 4, 4) [m] between two times, so near to each other that the path bends less than `finest` [m]."""
    count = FEWEST
    while True:
        q = run.timeline.sample(np.linspace(begin, end, count + 1)).q
        T = np.asarray(flange_pose(samples.arm.chain, q) @ samples.tool)
        bend = float(np.linalg.norm(np.diff(T[:, :3, 3], 2, axis=0), axis=1).max()) / 8.0
        if bend <= finest or count >= MOST:
            return T
        count = int(min(MOST, np.ceil(1.1 * count * np.sqrt(bend / finest))))


def _farthest(T: Array, others: Array, weight: float) -> Array:
    """The largest distance [m] and angle [rad] of poses (k, 4, 4) from the path between others (m, 4, 4)."""
    points, line = _embedded(T, weight), _even(_embedded(others, weight))
    nearest = cKDTree(line).query(points, min(CORNERS, len(line)))[1]
    best = np.full((len(points), 3), np.inf)
    for first in np.vstack([nearest.T - 1, nearest.T]):
        a = np.clip(first, 0, len(line) - 2)
        way = line[a + 1] - line[a]
        u = np.clip(np.sum((points - line[a]) * way, axis=1) / np.maximum(np.sum(way * way, axis=1), 1e-300), 0.0, 1.0)
        miss = points - line[a] - u[:, None] * way
        # |R - S| = sqrt(2) angle for a small angle
        parts = np.stack([np.linalg.norm(miss, axis=1), *_parts(miss, weight)], axis=1)
        best = np.where((parts[:, 0] < best[:, 0])[:, None], parts, best)
    return np.asarray(best[:, 1:].max(axis=0))


def _even(line: Array) -> Array:
    """The same line with `EVEN` corners more at even steps, so that the nearest corner is beside the nearest piece."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.unique(np.concatenate([along, np.linspace(0.0, along[-1], EVEN)]))
    return np.stack([np.interp(at, along, column) for column in line.T], axis=1)


def _parts(miss: Array, weight: float) -> tuple[Array, Array]:
    return np.linalg.norm(miss[:, :3], axis=1), np.linalg.norm(miss[:, 3:], axis=1) / weight


def _embedded(T: Array, weight: float) -> Array:
    """Poses as points (k, 12) whose distances are those of positions [m] and, weighed, of orientations."""
    return np.hstack([T[:, :3, 3], weight / np.sqrt(2.0) * T[:, :3, :3].reshape(-1, 9)])
