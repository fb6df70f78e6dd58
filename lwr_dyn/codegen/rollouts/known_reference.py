"""References that are sampled once for many calls: following a path in space takes longer than a hundred runs of it."""

from functools import lru_cache
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.run import Motion, Reference

_KEPT = 16
"""Motions of each reference, references, and tables that are kept."""


class KnownReference:
    """A reference that keeps the motions that it was asked for."""

    __slots__ = ("_motions", "about", "duration", "name", "reference")

    def __init__(self, reference: Reference) -> None:
        self.reference, self.duration = reference, float(reference.duration)
        self.name = getattr(reference, "name", type(reference).__name__)
        self.about: Any = getattr(reference, "about", {})
        self._motions: dict[tuple[int, float], Motion] = {}

    def sample(self, t: Array) -> Motion:
        """The motion at times from 0 on in equal steps, (k,) [s]."""
        key = len(t), float(t[-1])
        if key not in self._motions:
            if len(self._motions) >= _KEPT:
                self._motions.clear()
            self._motions[key] = self.reference.sample(t)
        return self._motions[key]


def known_reference(reference: Reference) -> KnownReference:
    """The same object for the same reference of this package; a user's own may change, and is sampled at every call."""
    own: Any = reference
    return _kept(own) if type(own).__module__.startswith("lwr_dyn.") else KnownReference(reference)


@lru_cache(maxsize=_KEPT)
def _kept(reference: Reference) -> KnownReference:
    return KnownReference(reference)


@lru_cache(maxsize=_KEPT)
def reference_rows(motion: Motion, chain: Chain) -> Array:
    """Rows of a kernel's table, (samples, 3 n + 3): q, dq, ddq, and the place of the tip."""
    return np.hstack([motion.q, motion.dq, motion.ddq, flange_pose(chain, motion.q)[:, :3, 3]])
