"""Measured pairs A B A B and the lines of a table: what the benchmarks share."""

from __future__ import annotations

import importlib.util
import statistics
import time
from collections.abc import Callable

Call = Callable[[], object]
clocks: list[Callable[[], float]] = [time.perf_counter]
"""The clock of all times: that of the wall, or `use_processor_time`."""


def use_processor_time() -> None:
    """Times are processor time of this process: for a busy machine; says nothing of several threads."""
    clocks[0] = time.process_time


def seconds(call: Call, number: int) -> float:
    """Seconds a call, over `number` calls."""
    clock = clocks[0]
    start = clock()
    for _ in range(number):
        call()
    return (clock() - start) / number


def paired(ours: Call, theirs: Call, pairs: int, number: int) -> tuple[float, float, float]:
    """Medians of both [s] and of the ratio ours / theirs, pair by pair, after one warm-up each."""
    ours(), theirs()
    times = [(seconds(ours, number), seconds(theirs, number)) for _ in range(pairs)]
    ratio = statistics.median(a / b for a, b in times)
    return statistics.median(a for a, _ in times), statistics.median(b for _, b in times), ratio


def row(what: str, peer: str, result: tuple[float, float, float], note: str = "") -> None:
    """One line of the table: times in microseconds, the ratio."""
    ours, theirs, ratio = result
    print(f"| {what} | {ours * 1e6:.3g} | {peer} | {theirs * 1e6:.3g} | {ratio:.3g} | {note} |", flush=True)


def head(title: str) -> None:
    """A heading and the head of a table."""
    print(f"\n### {title}\n\n| what | ours [us] | peer | peer [us] | ours / peer | |\n|---|---|---|---|---|---|")


def installed(module: str) -> bool:
    """Whether a peer is there; prints a note when it is not."""
    there = importlib.util.find_spec(module) is not None
    if not there:
        print(f"({module} is not installed: left out)")
    return there
