"""The result of one check: quantity, value, tolerance, pass or fail; all results of an arm; their table."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from lwr_dyn.foundation.document import Document, Note, Section
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.run import repr_html, short_repr

Bound = Literal["at most", "above"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """One identity or agreement: `value` against `tolerance`, in `unit`."""

    name: str
    value: float
    tolerance: float
    unit: str
    bound: Bound = "at most"

    @property
    def holds(self) -> bool:
        """A value that is not a number never holds.

        >>> Verdict("x", float("nan"), 1.0, "").holds
        False
        """
        return self.value <= self.tolerance if self.bound == "at most" else self.value > self.tolerance


@dataclass(frozen=True, slots=True)
class CheckReport:
    """All verdicts on an arm, and notes on what could not be checked and why."""

    robot: str
    reading: str
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()
    not_judged: tuple[str, ...] = ()
    """What no verdict is about, and why."""
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def holds(self) -> bool:
        """Every verdict holds."""
        return all(v.holds for v in self.verdicts)

    def summary(self) -> str:
        """How many checks hold or fail, and how many things were not judged."""
        failed, every = sum(not v.holds for v in self.verdicts), len(self.verdicts)
        found = f"{failed} of {every} checks fail{'s' * (failed == 1)}" if failed else f"all {every} checks hold"
        return found + (f", {len(self.not_judged)} not judged" if self.not_judged else "")

    def table(self) -> Table:
        """The verdicts under the robot's name."""
        return verdict_table(f"{self.robot}, reading {self.reading}", self.verdicts)

    @property
    def document(self) -> Document:
        """How many checks hold, and those that fail first."""
        title = f"{self.robot}, reading {self.reading}: {self.summary()}"
        verdicts = sorted(self.verdicts, key=lambda verdict: verdict.holds)
        left = Note([f"not judged: {one}" for one in self.not_judged])
        return Document(title, "", [Section("", [verdict_table("", verdicts), left], brief=True)], kind="checks")


def verdict_table(title: str, verdicts: Iterable[Verdict]) -> Table:
    """Verdicts as a table.

    >>> print(verdict_table("arm", [Verdict("B symmetric", 2e-16, 1e-12, "relative")]).text())
    arm
    check        value  bound    tolerance  unit      verdict
    -----------  -----  -------  ---------  --------  -------
    B symmetric  2e-16  at most  1e-12      relative  holds
    """
    headings = (
        Heading("check", key="name"),
        Heading("value", "", ".3g", "value", "In `unit` where there is one."),
        Heading("bound", key="bound", says="What the tolerance is of the value.", kind=Bound),
        Heading("tolerance", "", ".3g", "tolerance", "What the value is held against."),
        Heading("unit", key="unit"),
        Heading("verdict", "", lambda holds: "holds" if holds else "FAILS", "holds", "Whether it holds."),
    )
    rows = [(v.name, v.value, v.bound, v.tolerance, v.unit, v.holds) for v in verdicts]
    return Table(title, headings, rows, "", "verdicts", "The checks.")
