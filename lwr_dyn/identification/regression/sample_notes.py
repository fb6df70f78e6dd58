"""What the samples of logs are, where it is not what was asked for: split recordings, a lower cut-off."""

from collections.abc import Iterable

import numpy as np

from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.recordings import recordings
from lwr_dyn.identification.regression.samples import NYQUIST, SampleRule

_FEW = 3
"""Gaps that are named."""


def sample_notes(logs: Iterable[JointLog], rule: SampleRule) -> tuple[str, ...]:
    """A line for every log with gaps in time, and one for every log that is too slow for the filter."""
    notes = []
    for log in logs:
        starts = [piece.start for piece in recordings(log.t)][1:]
        if starts:
            gaps = [f"{log.t[i] - log.t[i - 1]:.4g} s at {log.t[i - 1]:.6g} s" for i in starts[:_FEW]]
            more = f" and {len(starts) - _FEW} more" if len(starts) > _FEW else ""
            notes.append(f"{log.source}: {len(starts) + 1} recordings, split at gaps of {', '.join(gaps)}{more}")
        if rule.cutoff is not None and log.t.size > 1:
            rate = 1.0 / float(np.median(np.diff(log.t)))
            if rule.cutoff > NYQUIST * 0.5 * rate:
                notes.append(
                    f"{log.source}: filtered at {NYQUIST * 0.5 * rate:.4g} Hz in place of {rule.cutoff:g} Hz, "
                    f"which is too near to half of its rate of {rate:.4g} Hz"
                )
    return tuple(notes)
