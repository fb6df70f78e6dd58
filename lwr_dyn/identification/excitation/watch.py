"""When a search must end, and how far it is: its time, a wish to stop, and what progress shows."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Literal

from lwr_dyn.foundation.progress import Report

Ended = Literal["searched", "seconds", "stopped"]
"""Whether all that was asked was searched, the time was over, or the search was asked to stop."""
FOR_STARTS, FOR_ALL = 0.6, 0.97
"""Shares of the time: after the first no start is searched, the rest is for the best of them; then the last check."""


class SearchEnd(Exception):  # noqa: N818  no error: the search that meets it hands over the best so far
    """The time of a search is over, or it was asked to stop."""


@dataclass(slots=True, eq=False)
class SearchWatch:
    """The clock of one search, from its making on.

    Parameters
    ----------
    seconds : float
        [s] It may take.
    stop : function
        Whether it is asked to stop, as by Ctrl-C.
    report : function of float or str
        Called with the share that is done and with what is being done, as `progress` gives it.
    """

    seconds: float = math.inf
    stop: Callable[[], bool] = lambda: False
    report: Report = lambda _: None
    ended: Ended = "searched"
    begin: float = field(default_factory=perf_counter)
    steps: int = 1
    """Of the search; progress is their share."""
    done: int = 0

    @property
    def elapsed(self) -> float:
        """[s]"""
        return perf_counter() - self.begin

    def is_over(self, share: float = FOR_ALL) -> bool:
        """Whether to stop, or a share of the time is gone; keeps why."""
        late = self.elapsed >= share * self.seconds
        if self.stop():
            self.ended = "stopped"
        elif late and self.ended == "searched":
            self.ended = "seconds"
        return late or self.ended == "stopped"

    def step(self, name: str) -> None:
        """A step begins."""
        self.report(name)

    def inside(self, share: float) -> None:
        """A share of the step is done."""
        of_steps = (self.done + min(share, 1.0)) / self.steps
        self.report(min(1.0, max(of_steps, self.elapsed / self.seconds)))

    def step_done(self) -> None:
        """A step has ended."""
        self.done += 1
        self.inside(0.0)
