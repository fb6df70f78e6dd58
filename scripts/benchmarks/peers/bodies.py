"""Which links' inertial parameters a body can have, in numpy alone: for any peer's environment."""

from collections.abc import Sequence

import numpy as np

TOLERANCE = 1e-8
"""Negative eigenvalue of the pseudo-inertia that still counts as 0 (figaroh's own tolerance)."""


def share_of_bodies(links: np.ndarray, keys: Sequence[str]) -> float:
    """Share of links (n, 10), with parameters of these names about the frame's origin, whose pseudo-inertia is >= 0."""
    values = [dict(zip(keys, link, strict=True)) for link in links]
    return float(np.mean([np.linalg.eigvalsh(_pseudo_inertia(link))[0] > -TOLERANCE for link in values]))


def _pseudo_inertia(p: dict[str, float]) -> np.ndarray:
    tensor = np.array([[p["I" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    first = np.array([p["mx"], p["my"], p["mz"]])
    second = np.trace(tensor) / 2 * np.eye(3) - tensor
    return np.block([[second, first[:, None]], [first[None], np.array([[p["m"]]])]])
