"""What an engine loses of a file: each feature is taken out of the file, and the engine's result must change as ours.

    loss = max |(tau(file) - tau(file without it)) of the engine - the same of ours|

Where no torque depends on a feature (limits), the engine's own record of it decides.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.engines.child_process import Loaded
from lwr_dyn.checks.engines.engine import tolerance
from lwr_dyn.checks.engines.features import FEATURES
from lwr_dyn.checks.engines.reference import FileReference
from lwr_dyn.foundation.arrays import Array

KEPT, RECORDED, IGNORED, ASIDE, MISREAD, MERGED = (
    "kept", "recorded", "ignored", "recorded, not in its torque", "misread", "merged"
)  # fmt: skip
NO_DYNAMICS = "no dynamics"
"""Verdicts."""
SHAPES, BEHIND_FIXED, ZEROS, CONTINUOUS = "shapes", "links behind fixed joints", "zero inertials", "continuous joints"


@dataclass(frozen=True, slots=True)
class Loss:
    """What an engine makes of one feature of a file; the torque that is then wrong [N m or N], and its share."""

    engine: str
    feature: str
    verdict: str
    torque: float | None = None
    relative: float | None = None
    detail: str = ""

    @property
    def is_loss(self) -> bool:
        """Whether something is not as the file says."""
        return self.verdict not in (KEPT, RECORDED, NO_DYNAMICS)


def feature_loss(
    engine: str, feature: str, loaded: tuple[Loaded, Loaded], ours: tuple[Array, Array] | None, reference: FileReference
) -> Loss:
    """One feature: the engine's and our results with it and without it."""
    held = next(x.held for x in FEATURES if x.name == feature)
    whole, without = loaded
    by_record = _by_record(engine, feature, held, whole, reference)
    if ours is None or not whole.has_dynamics:
        return by_record if held else Loss(engine, feature, NO_DYNAMICS)
    theirs = whole.torque - without.torque
    expected = ours[0] - ours[1]
    scale = float(np.abs(ours[0]).max())
    wrong = float(np.abs(theirs - expected).max())
    allowed = tolerance(engine, "torque") * scale
    if wrong <= allowed:
        only_recorded = held and float(np.abs(expected).max()) == 0.0
        return by_record if only_recorded else Loss(engine, feature, KEPT)
    if feature == ZEROS:  # it is their absence that is misread, and the file has them
        return Loss(engine, feature, KEPT, detail=f"without them {wrong:.2g} N m: {_weight(without, whole, 'without')}")
    silent = float(np.abs(theirs).max()) <= allowed
    verdict = (ASIDE if by_record.verdict == RECORDED else IGNORED) if silent else MISREAD
    return Loss(engine, feature, verdict, wrong, wrong / scale, _weight(whole, without))


def _by_record(engine: str, feature: str, held: tuple[str, ...], whole: Loaded, reference: FileReference) -> Loss:
    """The verdict where only the engine's own numbers can show a feature."""
    recorded = [x for x in held if x in whole.held]
    wrong = [words for x in recorded if (words := wrong_record(whole, reference, x, feature == CONTINUOUS))]
    if not recorded or (all(np.isinf(whole.held[x]).all() for x in recorded) and feature != CONTINUOUS):
        return Loss(engine, feature, IGNORED)
    return Loss(engine, feature, MISREAD, detail=wrong[0]) if wrong else Loss(engine, feature, RECORDED)


def wrong_record(loaded: Loaded, reference: FileReference, name: str, endless: bool = False) -> str:
    """The first joint of which an engine's number is not the file's; empty if there is none.

    With `endless`, only of joints without such a limit: an engine may have 0 or a very large number there.
    """
    ours, theirs = reference.held()[name], loaded.held[name]
    if endless:
        bad = np.isinf(ours) & (theirs != 0.0) & (np.abs(theirs) < _NO_LIMIT)
    else:
        bad = np.isfinite(ours) & ~np.isclose(theirs, ours, rtol=1e-6, atol=1e-12)
    found = np.flatnonzero(bad)
    if not found.size:
        return ""
    k = int(found[0])
    more = f" and {found.size - 1} more" if found.size > 1 else ""
    return f"{name} of {reference.arm.joint_names[k]}: {theirs[k]:g} for {ours[k]:g}{more}"


_NO_LIMIT = 1e6
"""Above this a limit is none."""


def _weight(one: Loaded, other: Loaded, words: str = "with it") -> str:
    more = one.mass - other.mass
    return f"{more:+.6g} kg {words}" if abs(more) > 1e-9 * max(one.mass, 1.0) else ""


def shapes_loss(engine: str, whole: Loaded, bare: Loaded, reference: FileReference) -> Loss:
    """The file as it stands against the file without shapes: no torque should depend on them."""
    more = f"shapes weigh {whole.mass - bare.mass:.6g} kg"
    if not (whole.has_dynamics and reference.has_dynamics):
        return Loss(engine, SHAPES, NO_DYNAMICS)
    wrong, scale = float(np.abs(whole.torque - bare.torque).max()), float(np.abs(reference.torque()).max())
    if wrong <= tolerance(engine, "torque") * scale:
        return Loss(engine, SHAPES, KEPT)
    return Loss(engine, SHAPES, MISREAD, wrong, wrong / scale, more)


def merged_loss(engine: str, loaded: Loaded, links: Mapping[str, object]) -> Loss:
    """Links of the file that the engine no longer knows by name."""
    gone = [name for name in links if name not in loaded.links]
    if not gone:
        return Loss(engine, BEHIND_FIXED, KEPT)
    some = ", ".join(gone[:3]) + (f" and {len(gone) - 3} more" if len(gone) > 3 else "")
    return Loss(engine, BEHIND_FIXED, MERGED, 0.0, 0.0, f"{some}: no longer there by name")
