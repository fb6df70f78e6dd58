"""`RunComparison`: several runs of one reference as a table, records and figures; refuses runs that differ in more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.notebook.markup import line
from lwr_dyn.pages.notebook.plot import arms_of
from lwr_dyn.pages.notebook.quantities import path, tip_error
from lwr_dyn.pages.replay.replayed_runs import facts, replayed_runs
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.studies.compare.compared_run import ComparedRun, TorqueCuts, torque_cuts
from lwr_dyn.studies.compare.conditions import check_same, conditions

BEST = " *"
UNSTABLE = " !"
UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True, eq=False)
class RunComparison:
    """Runs of one robot on one reference; a notebook shows their table, `save` writes the page."""

    runs: tuple[ComparedRun, ...]
    failures: tuple[str, ...] = ()
    """Runs that could not be finished, each with the reason."""
    title: str = ""
    tuned: Mapping[str, Any] = field(default_factory=dict)
    """Controller as typed -> its `TunedFrequency`, of a study with gains of one margin."""

    def __repr__(self) -> str:
        return (
            f"RunComparison({len(self.runs)} runs on {len(self.plants)} plants; .table, .to_columns(), .figure, .save)"
        )

    @property
    def plants(self) -> Mapping[str, tuple[ComparedRun, ...]]:
        """Plant in words -> its runs."""
        names = dict.fromkeys(one.plant for one in self.runs)
        return {name: tuple(one for one in self.runs if one.plant == name) for name in names}

    @property
    def table(self) -> Table:
        """One row a run: RMS and largest error of the tip, peak torque and its share of the limit, limits, audit."""
        rows = [
            (one.controller, one.plant, *self.cells(one))
            for one in self.runs
        ]  # fmt: skip
        headings = (
            Heading("controller"), Heading("plant"), Heading("tip RMS", "mm"), Heading("max", "mm"),
            Heading("peak torque", "N m"), Heading("of limit"), Heading("limits"), Heading("audit", "J"),
        )  # fmt: skip
        return Table(self.title, headings, rows, "\n".join(self.notes))

    @property
    def notes(self) -> tuple[str, ...]:
        """What the numbers rest on: rigid or elastic joints, stops, limits that were not kept, runs that failed."""
        said = [f"errors of the tip: {' or '.join(dict.fromkeys(one.figures.bodies for one in self.runs))}"]
        if any(len(group) > 1 for group in self.plants.values()):
            said.append("* the smallest of its plant")
        if any(one.shakes for one in self.runs):
            said.append("! unstable: a torque goes from one limit to the other again and again; it is not ranked")
        said += [f"{one.controller}, {one.plant}: limits {one.figures.limits}" for one in self.runs if _limited(one)]
        said += [f"{one.controller}, {one.plant}: {_shaking(one)}" for one in self.runs if one.shakes]
        said += [f"{name}: {_margin(one)}" for name, one in self.tuned.items()]
        return (*said, *self.failures)

    def cells(self, one: ComparedRun) -> tuple[str, ...]:
        """A run's numbers as text, in the order of the table; the best of its plant is marked."""
        errors = [f"{value:.4g}{self.mark(one, name)}" for name, value in one.errors.items()]
        share = UNKNOWN if np.isnan(one.share) else f"{100 * one.share:.3g} %"
        audit = "none" if np.isnan(one.audit) else f"{one.audit:.0e}"
        return (*errors, f"{one.peak_torque:.4g}", share, "kept" if one.figures.within_limits else "NOT kept", audit)

    def mark(self, one: ComparedRun, error: str) -> str:
        """The mark of the smallest of several errors of a plant, or of an unstable loop, else nothing."""
        if one.shakes:
            return UNSTABLE
        group = [other.errors[error] for other in self.plants[one.plant]]
        still = [other.errors[error] for other in self.plants[one.plant] if not other.shakes]
        return BEST if len(group) > 1 and one.errors[error] == min(still) else ""

    def record(self) -> dict[str, Any]:
        """The comparison as JSON values: one record a run, with all its figures of merit."""
        return {
            "title": self.title,
            "runs": [
                {"controller": one.controller, "typed": one.typed, "plant": one.plant, **one.errors,
                 "peak_torque": one.peak_torque, "torque_share": one.share, "torque_cut_share": one.cuts.share,
                 "unstable": one.shakes, "audit_residual_J": one.audit,
                 "best": [name for name in one.errors if self.mark(one, name) == BEST],
                 "metrics": one.figures.to_json()}
                for one in self.runs
            ],
            "tuned": {name: one.to_json() for name, one in self.tuned.items()},
            "failures": list(self.failures), "notes": list(self.notes),
        }  # fmt: skip

    def to_columns(self) -> dict[str, Any]:
        """One column a quantity, one row a run: pandas, polars and pyarrow make a table of them as it is."""
        measured = {
            "tip_rms [mm]": [one.figures.tip_rms_mm for one in self.runs],
            "tip_max [mm]": [one.figures.tip_max_mm for one in self.runs],
            "peak_torque [N m]": [one.peak_torque for one in self.runs],
            "torque_share": [one.share for one in self.runs],
            "audit_residual [J]": [one.audit for one in self.runs],
        }
        words = {"controller": [one.controller for one in self.runs], "plant": [one.plant for one in self.runs]}
        return {**words, **{name: np.array(values, dtype=np.float64) for name, values in measured.items()}}

    @property
    def figure(self) -> Any:
        """A new `matplotlib.figure.Figure`: path and tip error of all runs; needs the extra `plots`."""
        from lwr_dyn.pages.plotting.plots import draw

        shown = [one.shown for one in self.runs]
        return draw([*path(shown), *tip_error(shown)], shown)

    def save(self, path: str | Path) -> None:
        """Write the page, one HTML file that needs no network; raises `FileAccessError`."""
        from lwr_dyn.studies.compare.page import comparison_html

        write_file(path, comparison_html(self))

    def _repr_html_(self) -> str:
        from lwr_dyn.studies.compare.page import page_notes, table_rows

        return table_rows(self) + "".join(map(line, page_notes(self)))


def _limited(one: ComparedRun) -> bool:
    return not one.figures.within_limits


def _margin(one: Any) -> str:
    limit = f"|S_ii| reaches {one.peak:.3g} of {one.limit:g}"
    return f"omega_n {one.omega_n:.3g} rad/s, where {limit} ({one.case.words}, joint {one.joint + 1})"


def _shaking(one: ComparedRun) -> str:
    return f"unstable, bounded by the torque limits alone: {one.cuts}"


def compare(*runs: Run | str | Path, labels: Sequence[str] | None = None) -> RunComparison:
    """Runs of one robot on one reference, or their files, side by side: table, columns, figure, page.

    Parameters
    ----------
    *runs : Run, str or path
        Two or more.
    labels : sequence of str, optional
        Names in place of the controllers'.

    Raises
    ------
    OptionError
        Fewer than two runs, or runs of different robots or references: with what differs.
    FileAccessError
        A file that is no run file.
    """
    names = [f"run {i}" if isinstance(run, Run) else Path(run).name for i, run in enumerate(runs, 1)]
    return comparison_of([run if isinstance(run, Run) else Run.load(run) for run in runs], names, labels)


def comparison_of(
    runs: Sequence[Run],
    names: Sequence[str],
    labels: Sequence[str] | None = None,
    failures: Sequence[str] = (),
    figures: Sequence[tuple[Metrics, TorqueCuts]] | None = None,
    arms: Sequence[Arm] | None = None,
    least: int = 2,
) -> RunComparison:
    """A comparison of runs, which errors call by `names`.

    `figures` are of the same runs with all their samples, `arms` are theirs; both are found out if not given.

    Raises
    ------
    OptionError
        Fewer than `least` runs, labels of another number, runs of different robots or references: with what differs.
    """
    if len(runs) + len(failures) < least or not runs:
        raise OptionError("compare", f"{len(runs)} runs" if len(runs) != 1 else "one run", "two runs or more")
    arms = arms or arms_of(runs)
    for run, name in zip(runs[1:], names[1:], strict=True):
        check_same(runs[0], names[0], run, name)
    plants = [conditions(run) for run in runs]
    controllers = [_controller(run) for run in runs] if labels is None else list(labels)
    measured = figures or [(metrics(run, arm), torque_cuts(run, arm)) for run, arm in zip(runs, arms, strict=True)]
    shown = replayed_runs(runs, arms, None if labels is None else labels)
    compared = [
        ComparedRun(one, controller, plant, *found)
        for one, controller, plant, found in zip(shown, _unique(controllers, plants), plants, measured, strict=True)
    ]
    return RunComparison(tuple(compared), tuple(failures), _title(runs[0]))


def _controller(run: Run) -> str:
    """The controller's label, with options that a study gave it."""
    given = (run.meta.get("note") or {}).get("controller_options")
    return ", ".join([facts(run).get("controller", "controller"), *([given] if isinstance(given, str) else [])])


def _unique(controllers: Sequence[str], plants: Sequence[str]) -> list[str]:
    """The controllers, numbered where one stands twice on a plant."""
    pairs = list(zip(controllers, plants, strict=True))
    return [
        name if pairs.count((name, plant)) == 1 else f"{name} {pairs[: i + 1].count((name, plant))}"
        for i, (name, plant) in enumerate(pairs)
    ]


def _title(run: Run) -> str:
    known = facts(run)
    parts = [known.get("robot", "unknown robot"), *([known["task"]] if "task" in known else []), f"{run.t[-1]:g} s"]
    begun = (run.meta.get("note") or {}).get("since")
    return ", ".join(parts) + ("" if begun is None else f" from {begun:g} s on")
