"""Where the kernel of inverse kinematics keeps its numbers: rows of W lanes in its buffer, and its settings.

Buffer: q (n), T (12), repair, flag, next q (n), the measures of the step; then the state of the lane, its nearest miss
(n), the position that solutions shall be near to (n). Settings: number of starts, whether to move angles by whole
turns, whether the arm is redundant, n; lower, upper, middle, turning (n each); the starts.
"""

POSE, MEASURES, STATE = 12, 4, 9
"""Rows of T, of the measures and of the state."""
AT, START, STEPS, ALL, CODE, MISS, PLACE = range(STATE - 2)
"""The state of a lane: its pose (-1: none), its start, steps of the start and of the pose, the outcome of the nearest
miss, how far it misses, and its three measures."""
HEAD = 4
"""Settings before those of the joints."""


def buffer_size(n: int, lanes: int) -> int:
    """Numbers in the buffer for n joints."""
    return (4 * n + POSE + 2 + MEASURES + STATE) * lanes
