"""`RunComparison`: several runs of one reference as a table, records and figures; refuses runs that differ in more.

A comparison as one HTML file: the table, then for each plant the path with its errors magnified, and the tip error.

There is no script, and nothing is loaded; light and dark follow the reader's system.

A comparison as one table in Markdown, plants down and controllers across: the RMS error of the tip in mm.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.document import document_html
from lwr_dyn.pages.figures.run_figures import path, tip_error
from lwr_dyn.pages.notebook.exported_runs import arms_of
from lwr_dyn.pages.notebook.forms import line
from lwr_dyn.pages.plotting.drawn_panel import chart_html, swatch
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, facts, replayed_runs
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.studies.compare.compared_run import ComparedRun, TorqueCuts, check_same, conditions, torque_cuts

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

        write_file(path, comparison_html(self))

    def _repr_html_(self) -> str:

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


def comparison_html(compared: RunComparison) -> str:
    """The page; the same runs give the same text."""
    sections = "".join(_section(plant, runs) for plant, runs in compared.plants.items())
    table = f'<div class="scroll" tabindex="0" role="region" aria-label="Runs">{_table(compared)}</div>'
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in page_notes(compared))
    said = "".join(f"<li>{sentence}</li>" for sentence in _sentences(compared))
    main = (
        f'<h1>{escape(compared.title)}</h1><ul class="say">{said}</ul>'
        f'<section class="card">{table}{notes}</section>{sections}'
    )
    return document_html(compared.title, "comparison", main, "lwr-dyn compare")


def page_notes(compared: RunComparison) -> list[str]:
    """The notes, where the best is bold and not marked."""
    return [f"bold: {note[2:]}" if note.startswith(BEST.strip()) else note for note in compared.notes]


def table_rows(compared: RunComparison) -> str:
    """The table for a notebook: plain, the best of each plant in bold."""
    head = "".join(f'<th scope="col">{escape(h.title)}</th>' for h in compared.table.columns)
    rows = "".join(
        f'<tr><th scope="row">{escape(one.controller)}</th><td>{escape(one.plant)}</td>{_cells(compared, one)}</tr>'
        for one in compared.runs
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _table(compared: RunComparison) -> str:
    """One group of rows a plant, under its name."""
    words, numbers = compared.table.columns[:1], compared.table.columns[2:]
    head = "".join(f'<th scope="col">{escape(h.head)}</th>' for h in words)
    head += "".join(f'<th scope="col" class="n">{escape(h.head)} <small>{escape(h.unit)}</small></th>' for h in numbers)
    width = len(words) + len(numbers)
    groups = ""
    for plant, runs in compared.plants.items():
        name = f'<tr><th scope="rowgroup" colspan="{width}">{escape(plant)}</th></tr>'
        rows = "".join(
            f'<tr><th scope="row">{swatch(shown)}{escape(one.controller)}</th>{_cells(compared, one)}</tr>'
            for one, shown in zip(runs, _alone(runs), strict=True)
        )
        groups += f'<tbody class="plant">{name}{rows}</tbody>'
    return f"<table><thead><tr>{head}</tr></thead>{groups}</table>"


def _cells(compared: RunComparison, one: ComparedRun) -> str:
    return "".join(map(_cell, compared.cells(one)))


def _cell(text: str) -> str:
    if text.endswith(BEST):
        return f'<td class="n"><b>{escape(text.removesuffix(BEST))}</b></td>'
    return f'<td class="n{" bad" if text.startswith("NOT") or text.endswith(UNSTABLE) else ""}">{escape(text)}</td>'


def _sentences(compared: RunComparison) -> list[str]:
    """Of each plant with several runs, which controller has the smallest RMS error."""
    out = []
    for plant, all_runs in compared.plants.items():
        runs = [one for one in all_runs if not one.shakes]
        if len(runs) > 1:
            best, *_, worst = sorted(runs, key=lambda one: one.figures.tip_rms_mm)
            near = f"{escape(best.controller)} is nearest to the path, {best.figures.tip_rms_mm:.3g} mm RMS"
            far = f"{escape(worst.controller)} farthest, {worst.figures.tip_rms_mm:.3g} mm"
            out.append(f"<b>{escape(plant)}</b>: {near}; {far}.")
    return out


def _section(plant: str, runs: Sequence[ComparedRun]) -> str:
    shown = _alone(runs)
    charts = "".join(chart_html(figure, shown) for figure in (*path(shown), *tip_error(shown)))
    return f'<section class="card"><h2>{escape(plant)}</h2><div class="charts">{charts}</div></section>'


def _alone(runs: Sequence[ComparedRun]) -> tuple[ReplayedRun, ...]:
    """The runs of one plant, named by their controllers, with the colours that they have among themselves."""
    shown = [one.shown for one in runs]
    return replayed_runs([one.run for one in shown], [one.arm for one in shown], [one.controller for one in runs])


MARKS = {"unstable": "{} !", "best": "**{}**", "": "{}"}

NONE = "none"
"""Where a pair has no run; `failures` say why."""


def cross_table(runs: Iterable[Mapping[str, Any]]) -> str:
    """The table of the records of `RunComparison.record()["runs"]`, controllers as typed; the best of each plant bold.

    >>> run = {"typed": "pid", "plant": "delay", "tip_rms_mm": 0.123456, "unstable": False, "best": []}
    >>> print(cross_table([run, {**run, "typed": "mine.py", "tip_rms_mm": 9.0, "unstable": True}]))
    | plant | `pid` | `mine.py` |
    | --- | --- | --- |
    | delay | 0.123 | 9 ! |
    """
    listed = list(runs)
    controllers = list(dict.fromkeys(str(run["typed"]) for run in listed))
    plants = list(dict.fromkeys(str(run["plant"]) for run in listed))
    cells = {(run["plant"], run["typed"]): _cross_cell(run) for run in listed}
    rows = [[plant, *(cells.get((plant, one), NONE) for one in controllers)] for plant in plants]
    head = ["plant", *(f"`{one}`" for one in controllers)]
    return "\n".join(map(_line, [head, ["---"] * len(head), *rows]))


def _cross_cell(run: Mapping[str, Any]) -> str:
    mark = "unstable" if run["unstable"] else "best" if "tip_rms_mm" in run["best"] else ""
    return MARKS[mark].format(f"{run['tip_rms_mm']:.3g}")


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
