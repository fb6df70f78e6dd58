"""A ranking of sets: each with what it leaves, and the document of all."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.tables import Heading, Marked, Table
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.ranking.filtered_log import FilteredLog, FilterRule
from lwr_dyn.identification.ranking.published_logs import PublishedLog
from lwr_dyn.identification.ranking.set_fits import Fit
from lwr_dyn.model.arm import LINK_SIDE, Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import repr_html

BLOCK = 1.0
"""[s] of the blocks that are drawn again for an interval: what is left is alike for tenths of a second."""
AHEAD = 0.95
"""Share of draws in which a set must leave less than the next, to be ahead of it beyond chance."""


@dataclass(frozen=True, slots=True, eq=False)
class SetScore:
    """One set: `fits` as published, then with more freed, one added to those before; `alone` with each freed alone.

    `own` has the friction that the set publishes in place of one that is fitted; None where it publishes none.
    `intervals` (low, high) [N m] of each fit's total, `ahead` the share of draws of blocks in which it leaves less than
    the set that follows it (as published); `not_bodies` are links that no body can have, each with by how much.
    """

    name: str
    arm: Arm
    fits: tuple[Fit, ...]
    alone: tuple[Fit, ...]
    intervals: tuple[tuple[float, float], ...]
    not_bodies: tuple[str, ...]
    ahead: float | None = None
    own: Fit | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """Sets from the one that leaves least, as published; `floors` (k, n) are what least squares leave, by what is free.

    `train` and `test` are the rows, `tested_on` the name of the log that tests (that of the log where its end does).
    """

    robot: str
    log: JointLog
    published: PublishedLog | None
    tested_on: str
    rule: FilterRule
    free: tuple[tuple[str, ...], ...]
    scores: tuple[SetScore, ...]
    floors: tuple[Array, ...]
    train: FilteredLog
    test: FilteredLog
    with_load: str
    """The set that leaves least with a free load, if that is more than chance; else the first of `scores`."""

    def floor(self, which: int = 0) -> float:
        """What least squares leave over all joints [N m or N]."""
        return rms_of(self.floors[which])

    def of(self, name: str) -> SetScore:
        """The score of a set by its name; raises `KeyError`."""
        return {one.name: one for one in self.scores}[name]

    @property
    def document(self) -> Document:
        """For people and programs."""
        sections = [
            Section("Sets, from the one that leaves least", [_sets(self), *_notes(self)]),
            Section("What is left of each joint", [_joints(self)], brief=True),
            Section("What each set misses", [_misses(self), Note(list(_found_words(self)))]),
            Section("How", _how(self)),
        ]
        return Document(
            f"{self.robot} on {self.log.source}", _verdict(self), sections, "lwr-dyn rank", "ranking", caveats=()
        )

    _repr_html_ = repr_html

    def __repr__(self) -> str:
        return f"Ranking({_verdict(self)})"

    @property
    def unit(self) -> str:
        """Of the torques."""
        kinds = {link.kind for link in self.scores[0].arm.chain.links}
        return "N m" if kinds == {JointKind.REVOLUTE} else "N m, N"


def rms_of(values: Array) -> float:
    """Root mean square of all values."""
    return float(np.sqrt(np.mean(np.square(values))))


TURNS_ROUND = "; a free load turns the ranking round, so which set is wrong is not shown"


def _verdict(found: Ranking) -> str:
    best, worst = found.scores[0], found.scores[-1]
    unit, of = found.unit, float(np.sqrt(np.mean(np.square(found.test.tau))))
    more = "" if best is worst else f", {worst.name} {worst.fits[0].total:.3f}"
    said = f"{best.name} leaves {best.fits[0].total:.3f} {unit} of {of:.3g} {unit} of torque{more}; least squares"
    return f"{said} {found.floor():.3f}{TURNS_ROUND if _turns(found) else ''}"


def _turns(found: Ranking) -> bool:
    """Whether another set leaves least with a free load."""
    return found.with_load != found.scores[0].name


def _sets(found: Ranking) -> Table:
    """A row a set, a column what is freed."""
    unit, steps = found.unit, found.free
    least = [min(one.fits[i].total for one in found.scores) for i in range(len(steps))]
    headings = [Heading("set", key="set")]
    headings += [
        Heading("as published" if not free else f"+ {free[-1]}", unit, ".3f", None)
        for free in steps
    ]  # fmt: skip
    if any(one.own for one in found.scores):
        headings += [Heading("own friction", unit, _known, None)]
    headings += [
        Heading("", "", "", "own_friction",
                "RMS torque left with the friction that the set publishes, and nothing fitted.", float),
        Heading("", "", "", "left", "RMS torque left as published, then with each of `free` added.", list[float]),
        Heading("95 %", "", _range, "interval", "Of the first, over blocks of the rows that test.", list[float]),
        Heading("ahead", "", lambda x: "" if x is None else f"{x:.0%}", "ahead",
                "Share of draws of the blocks in which it leaves less than the next.", float),
        Heading("a body", "", lambda x: "yes" if not x else f"no: {'; '.join(x)}", "not_bodies",
                "Links that no body can have.", list[str]),
    ]  # fmt: skip
    rows = [
        (one.name, *(Marked(fit.total, "best" if fit.total == least[i] else "") for i, fit in enumerate(one.fits)),
         *_own(found, one), [fit.total for fit in one.fits], [*one.intervals[0]], one.ahead, [*one.not_bodies])
        for one in found.scores
    ]  # fmt: skip
    floors = [found.floor(i) for i in range(len(steps))]
    rest = (floors, [float("nan")] * 2, None, ["not a set of bodies"])
    rows.append(("least squares", *floors, *_own(found, None), *rest))
    return Table("", headings, rows, key="sets", says="Sets, and at the end the least squares of all parameters.")


def _known(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.3f}"


def _own(found: Ranking, score: SetScore | None) -> list[float]:
    """What is left with a set's own friction, for people where some set has any, and for programs."""
    left = float("nan") if score is None or score.own is None else score.own.total
    return [left] * (1 + any(one.own is not None for one in found.scores))


def _range(pair: Sequence[float]) -> str:
    return "" if np.isnan(pair[0]) else f"{pair[0]:.3f} to {pair[1]:.3f}"


def _notes(found: Ranking) -> Iterator[Note]:
    load = "unknown: what one set lacks another may have absorbed" if found.published is None else found.published.load
    yield Note(f"Load on the robot when it was logged: {load}.")
    close = [a.name for a in found.scores if a.ahead is not None and a.ahead < 0.95]
    yield Note(f"Not ahead of the next one beyond chance: {', '.join(close)}.", bool(close))
    if _turns(found):
        best = found.of(found.with_load)
        load_of = best.alone[0].load
        assert load_of is not None
        yield Note(
            f"With a free load on the last link {best.name} leaves least ({best.alone[0].total:.3f} {found.unit}, with "
            f"{load_of[0]:.2f} kg): either the robot carried it, or the table lacks it. The log cannot tell which."
        )


def _joints(found: Ranking) -> Table:
    names = found.scores[0].arm.joint_names
    headings = [Heading("set", key="set"), *(Heading(name, "", ".3f", None) for name in names)]
    headings.append(Heading("", "", "", "left", "RMS torque left of each joint, as published.", list[float]))
    rows = [(one.name, *one.fits[0].rms, one.fits[0].rms.tolist()) for one in found.scores]
    floor = np.sqrt(np.mean(np.square(found.floors[0]), axis=0))
    rows.append(("least squares", *floor, floor.tolist()))
    return Table(f"RMS in {found.unit}, as published", headings, rows, key="joints", says="A row a set.")


def _misses(found: Ranking) -> Table:
    """What each set leaves with one thing freed alone: what it misses is where that falls."""
    rotors = "with rotors" if any(len(one.alone) > 2 for one in found.scores) else ""  # not behind the gears
    headings = [
        Heading("set", key="set"), Heading("as published", found.unit, ".3f", "published"),
        Heading("with a load", "", ".3f", "load"), Heading("with gains", "", ".3f", "gain"),
        Heading(rotors, "", _known, "rotor"), Heading("load found", "kg", "+.2f", "mass"),
        Heading("its m c", "kg m", lambda x: " ".join(f"{v:+.3f}" for v in x), "first_moment",
                "Of the load found, in the frame of the last link.", list[float]),
        Heading("worst joint", "", "", "worst", "The joint of which most is left, as a share of its torque."),
    ]  # fmt: skip
    rows = []
    size = np.sqrt(np.mean(np.square(found.test.tau - found.test.tau.mean(axis=0)), axis=0))
    for one in found.scores:
        load = one.alone[0].load
        assert load is not None
        worst = one.arm.joint_names[int(np.argmax(one.fits[0].rms / size))]
        totals = [fit.total for fit in (one.fits[0], *one.alone)]
        totals += [float("nan")] * (4 - len(totals))
        rows.append((one.name, *totals, float(load[0]), load[1:4].tolist(), worst))
    return Table("One thing freed alone", headings, rows, key="misses", says="A row a set.")


def _found_words(found: Ranking) -> Iterator[str]:
    """Rotors and gains that were found with all that is freed."""
    for one in found.scores:
        fit = one.fits[-1]
        if fit.rotors is not None:
            yield f"{one.name}: rotors {' '.join(f'{x:.3f}' for x in fit.rotors)} kg m^2"
        if fit.gains is not None:
            gains = " ".join("?" if np.isnan(x) else f"{1.0 / x:.2f}" for x in fit.gains)
            yield f"{one.name}: torques of the set over those of the log {gains} (? where the log does not say)"


def _how(found: Ranking) -> list[Fact | Note]:
    log = found.published
    source = "your own log" if log is None else f"{log.about}; {log.source}"
    return [
        Fact("robot", found.robot, "Whose sets."),
        Fact("free", [*found.free[-1]], "What is fitted beside the friction, in this order.", kind=list[str]),
        Fact("log", found.log.source, "As given."),
        Fact("tested_on", found.tested_on, "The log whose rows test."),
        Fact("train_rows", len(found.train), "Rows that train.", "rows that train"),
        Fact("test_rows", len(found.test), "Rows that test.", "rows that test"),
        Fact("cutoff", found.rule.cutoff, "Of the filter on positions and torques.", "filter", "Hz", "g"),
        Fact("torques", gains := "" if log is None else log.gains, "How they became N m."),
        Note(f"Log: {found.log.source}, {source}."),
        Note(f"Torque gains: {gains}.", when=bool(gains)),
        Note(f"Tested on {found.tested_on}."),
        Note("Torques are measured behind the gears: no rotor is in them, and none is fitted.",
             when=any(one.arm.torques == LINK_SIDE for one in found.scores)),
        Note("own friction: the bodies with the friction that the set publishes, and nothing fitted.",
             when=any(one.own is not None for one in found.scores)),
        Note("Of every set the bodies alone count; friction (Coulomb of each direction, viscous, offset) is fitted "
             "again for each on the rows that train. Another filter gives other numbers."),
        Note(f"Intervals draw blocks of {BLOCK:g} s of the rows that test; they do not cover other motions or robots."),
    ]  # fmt: skip
