"""What must be known of a kernel to call it: its inputs, its buffer, its lanes; and what it costs."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Description:
    """How a kernel is called and what it costs."""

    inputs: tuple[str, ...]
    """Names of its inputs, joint vectors first."""
    widths: tuple[int, ...]
    """Values of one row of each input."""
    width: int
    """Values of one row of the result."""
    buffer: int
    """Numbers in the buffer of a block."""
    lanes: int
    """States of a block."""
    limit: float
    """Largest angle [rad]; a state with a larger one is counted as trouble."""
    operations: int
    fused: int
    """Operations when a product and a sum are one."""
