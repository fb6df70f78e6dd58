"""Logs that are given twice, under whatever name: their errors would look smaller than they are."""

from collections.abc import Sequence
from hashlib import blake2b

import numpy as np

from lwr_dyn.foundation.errors import LogError
from lwr_dyn.identification.logs.joint_log import FIELDS, JointLog

_BLOCK = 10_000
"""Rows at once."""


def digest_of(log: JointLog) -> bytes:
    """Of all that was measured, to the last bit; of the times only their number, as clocks may start anywhere."""
    found = blake2b(f"{log.joints} {len(log.t)}".encode())
    for field in FIELDS.values():
        values = getattr(log, field)
        if field != "dq" and values is not None:  # a copy may lack the measured velocity
            for first in range(0, len(values), _BLOCK):
                found.update(np.ascontiguousarray(values[first : first + _BLOCK]).data)
    return found.digest()


def repeated(log: JointLog, seen: dict[bytes, str], needed: str = "each recording once") -> LogError | None:
    """A fault where the rows are in `seen` (digest -> whose); else they are noted there."""
    digest = digest_of(log)
    if digest not in seen:
        seen[digest] = log.source
        return None
    first = seen[digest]
    found = "given twice" if first == log.source else f"the same as those of {first}"
    return LogError(log.source, "rows", found, needed)


def apart_from(
    logs: Sequence[JointLog], others: Sequence[JointLog] = (), what: str = "", needed: str = "each recording once"
) -> tuple[list[JointLog], list[LogError]]:
    """The logs whose rows stand neither in `others` (which are `what`) nor in a log before; a fault for each other."""
    seen = {digest_of(log): f"{log.source}, {what}" for log in others}
    faults = [repeated(log, seen, needed) for log in logs]
    kept = [log for log, fault in zip(logs, faults, strict=True) if fault is None]
    return kept, [fault for fault in faults if fault is not None]
