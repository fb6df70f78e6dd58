"""What reproducing a paper comes to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Whether everything printed is reproduced or explained, the text for people, the record for programs."""

    holds: bool
    text: str
    record: dict[str, Any]
