"""The kinds of planted faults, each with the codes that name it rightly; fixed before the first count.

`KINDS` are slips of any language; `REFUSED` is what the pendant refuses at once and version 0.2.0 of the check passed.
"""

from tests.krl.planting.refused import REFUSED
from tests.krl.planting.site import FaultKind
from tests.krl.planting.slips import KINDS as SLIPS

KINDS: tuple[FaultKind, ...] = tuple(SLIPS)
__all__ = ["KINDS", "REFUSED", "FaultKind"]
