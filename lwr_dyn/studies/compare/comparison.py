"""`RunComparison`: several runs of one reference as a table, records and figures; refuses runs that differ in more.

On its page each plant has the path with its errors magnified, and the tip error; there is no script. A second page
replays any two runs side by side; what all runs share (the arm, the reference, the times) stands in it once. A table in
Markdown, plants down and controllers across, has the RMS error of the tip in mm.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from lwr_dyn.design.gain_search import TunedRecord
from lwr_dyn.foundation.document import Document, Fact, Note, PageFigure, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.foundation.tables import Heading, Marked, Table
from lwr_dyn.model.arm import Arm, caveats_of
from lwr_dyn.model.caveats import ABSENT_ROTORS, ROTOR_RUN
from lwr_dyn.model.run import Run, repr_html, run_used
from lwr_dyn.pages.document import page_html
from lwr_dyn.pages.figures.run_figures import path_figure, tip_error_figure
from lwr_dyn.pages.plotting.drawn_panel import chart_html
from lwr_dyn.pages.plotting.plots import arms_of, draw
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.replayed_runs import facts, replayed_runs
from lwr_dyn.simulation.metrics import Metrics, MetricsRecord, metrics
from lwr_dyn.studies.compare.compared_run import ComparedRun, TorqueCuts, check_same, conditions, thinned, torque_cuts

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
    remedy: str = ROTOR_RUN
    """How rotors that are missing are added: when runs are made, or by an option of this comparison."""

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
            (one.controller, one.typed, one.plant, *(Marked(v, self.mark(one, k)) for k, v in one.errors.items()),
             one.peak_torque, one.share, one.cuts.share, one.shakes,
             LIMITS[one.figures.within_limits], one.audit, [k for k in one.errors if self.mark(one, k) == "best"],
             one.figures.to_json())
            for one in self.runs
        ]  # fmt: skip
        return Table(self.title, COLUMNS, rows, "\n".join(self.notes), "runs", "One record a run, plant by plant.")

    @property
    def notes(self) -> tuple[str, ...]:
        """What the numbers rest on: rigid or elastic joints, stops, limits that were not kept, runs that failed."""
        several = any(len(group) > 1 for group in self.plants.values())
        said = [
            Note(f"errors of the tip: {' or '.join(dict.fromkeys(one.figures.bodies for one in self.runs))}"),
            Note("* the smallest of its plant", several),
            Note("! unstable: a torque goes from one limit to the other again and again; it is not ranked",
                 any(one.shakes for one in self.runs)),
            Note(_limits(self.runs)),
            Note([f"{one.controller}, {one.plant}: unstable, bounded by the torque limits alone: {one.cuts}"
                  for one in self.runs if one.shakes]),
            Note([f"{name}: omega_n {one.omega_n:.3g} rad/s, where |S_ii| reaches {one.peak:.3g} of {one.limit:g} "
                  f"({one.case.words}, joint {one.joint + 1})" for name, one in self.tuned.items()]),
        ]  # fmt: skip
        return (*(line for note in said for line in note.lines), *self.failures)

    def mark(self, one: ComparedRun, error: str) -> str:
        """The mark of the smallest of several errors of a plant, or of an unstable loop, else nothing."""
        if one.shakes:
            return "bad"
        group = [other.errors[error] for other in self.plants[one.plant]]
        still = [other.errors[error] for other in self.plants[one.plant] if not other.shakes]
        return "best" if len(group) > 1 and one.errors[error] == min(still) else ""

    @property
    def document(self) -> Document:
        """The comparison for people and programs."""
        tuned = {name: one.to_json() for name, one in self.tuned.items()}
        title = Fact("title", self.title, "Robot, task and duration.")
        runs = Section("Runs", [
            replace(self.table, title="", note=""),
            Fact("tuned", tuned, "Controller as typed -> its omega_n of one margin; empty without --tuned.",
                 kind=dict[str, TunedRecord]),
            Fact("failures", list(self.failures), "Runs that could not be finished, each with the reason.",
                 kind=list[str]),
            Note(self.notes, key="notes", says="What the numbers rest on."),
        ], brief=True)  # fmt: skip
        caveats = [
            line
            for one in self.runs
            for line in caveats_of([one.shown.arm], (*run_used(one.shown.run), ABSENT_ROTORS), self.remedy)
        ]
        return Document(self.title, "", [runs], "lwr-dyn compare", "comparison", [title], tuple(dict.fromkeys(caveats)))

    def record(self) -> dict[str, Any]:
        """The comparison as JSON values: one record a run, with all its figures of merit."""
        return self.document.record()

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
        shown = [one.shown for one in self.runs]
        return draw([path_figure(shown), tip_error_figure(shown)], shown)

    def save(self, path: str | Path) -> None:
        """Write the page, one HTML file that needs no network; raises `FileAccessError`."""
        write_file(path, comparison_html(self))

    _repr_html_ = repr_html


def _percent(share: float) -> str:
    """A share of a torque limit in percent; rounding errors are 0."""
    return "0 %" if share < ROUNDING else f"{100 * share:.3g} %"


ROUNDING = 1e-9
"""Share of a torque limit below which a torque is a rounding error."""
LIMITS = {True: "kept", False: "NOT kept", None: UNKNOWN}
COLUMNS = (
    Heading("controller", key="controller", says="Label of the controller."),
    Heading(key="typed", says="The controller as typed; its label in runs that do not say."),
    Heading("plant", key="plant", says="What of the plant its model lacks."),
    Heading("tip RMS", "mm", ".4g", "tip_rms_mm", "RMS error of the tip, mm.", float),
    Heading("max", "mm", ".4g", "tip_max_mm", "Largest error of the tip, mm.", float),
    Heading("peak torque", "N m", ".4g", "peak_torque", "Largest torque of any joint, N m (N)."),
    Heading("of limit", "", lambda share: UNKNOWN if np.isnan(share) else _percent(share), "torque_share",
            "Largest share of a torque limit; null where none is known."),
    Heading(key="torque_cut_share",
            says="Share of the time in which the torque of one joint is cut at its limit, of the worst joint."),
    Heading(key="unstable",
            says="Whether torques are cut for so long that the loop counts as unstable; it is not ranked."),
    Heading("limits", key=None, shade=lambda words: 0.3 if words == LIMITS[False] else 0.0),
    Heading("audit", "J", lambda left: "none" if np.isnan(left) else f"{left:.0e}", "audit_residual_J",
            "Energy that the audit leaves unexplained, J; null without an audit."),
    Heading(key="best", says="Errors in which it is the smallest of its plant.",
            kind=list[Literal["tip_rms_mm", "tip_max_mm"]]),
    Heading(key="metrics", says="Errors and uses of limits.", kind=MetricsRecord),
)  # fmt: skip


def _limits(runs: Sequence[ComparedRun]) -> list[str]:
    """The limits that runs did not keep, or that are unknown; one line where it is the same for all runs."""
    said = {one.figures.limits for one in runs}
    if len(said) == 1 and len(runs) > 1:
        return [f"limits of all runs: {words}" for words in said if runs[0].figures.within_limits is not True]
    return [
        f"{one.controller}, {one.plant}: limits: {one.figures.limits}"
        for one in runs
        if one.figures.within_limits is not True
    ]


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
    nearest = Section("", [Note(_nearest(compared))])
    charts = [Section(plant, [PageFigure(partial(_charts, runs))]) for plant, runs in compared.plants.items()]
    document = compared.document
    return page_html(replace(document, sections=[nearest, *document.sections, *charts]))


def _nearest(compared: RunComparison) -> list[str]:
    """Of each plant with several runs, which controller has the smallest RMS error."""
    out = []
    for plant, all_runs in compared.plants.items():
        runs = _nearest_first(all_runs)
        if len(runs) > 1:
            near, far = (f"{one.controller} {word}, {one.figures.tip_rms_mm:.3g} mm"
                         for one, word in ((runs[0], "is nearest to the path"), (runs[-1], "farthest")))  # fmt: skip
            out.append(f"{plant}: {near} RMS; {far}.")
    return out


def _charts(runs: Sequence[ComparedRun]) -> str:
    """Of the runs of one plant, named by their controllers, with the colours that they have among themselves."""
    alone = [one.shown for one in runs]
    shown = replayed_runs([one.run for one in alone], [one.arm for one in alone], [one.controller for one in runs])
    charts = "".join(chart_html(figure, shown) for figure in (path_figure(shown), tip_error_figure(shown)))
    return f'<div class="charts">{charts}</div>'


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
    cells: dict[str, dict[str, str]] = {}
    for run in listed:
        mark = "unstable" if run["unstable"] else "best" if "tip_rms_mm" in run["best"] else ""
        cells.setdefault(run["plant"], {})[run["typed"]] = MARKS[mark].format(f"{run['tip_rms_mm']:.3g}")
    controllers = list(dict.fromkeys(str(run["typed"]) for run in listed))
    rows = [[plant, *(row.get(one, NONE) for one in controllers)] for plant, row in cells.items()]
    head = ["plant", *(f"`{one}`" for one in controllers)]
    return "\n".join(f"| {' | '.join(row)} |" for row in [head, ["---"] * len(head), *rows])


BUDGET = 12_000_000
"""Largest size of all series in the page [bytes]; above it fewer samples a second are kept."""
LEAST = 10.0
"""[Hz] Fewer samples a second would not show a motion."""
SHARED = ("joints", "flange", "base", "native", "floor", "tip_model", "t", "q_ref", "reference", "samples")
"""Of a run's record: what runs of one reference have in common, as a rule."""


def pair_html(compared: RunComparison) -> str:
    """The page; the same comparison gives the same text.

    Raises
    ------
    OptionError
        Fewer than two runs.
    """
    if len(compared.runs) < 2:
        raise OptionError("replay of two runs", "one run", "two runs or more")
    own = ("pair.css", "pair.js")
    return replay_page.player_page(compared.title, pair_data(compared), own=own, of="lwr_dyn.studies.compare")


def pair_data(compared: RunComparison) -> dict[str, Any]:
    """The player's data: two runs on the stage, and what is needed to put any other there."""
    rate, start = rate_within(compared.runs), (0, 1)
    for runs in compared.plants.values():  # first shown: the best and the worst of the last plant with two stable runs
        still = _nearest_first(runs)
        if len(still) > 1:
            start = compared.runs.index(still[0]), compared.runs.index(still[-1])
    records = [_record(one, rate) for one in compared.runs]
    shared = {key: records[0][key] for key in SHARED}
    own = [{key: x for key, x in record.items() if shared.get(key) != x} for record in records]
    first = [replace(compared.runs[i].shown, place=place) for place, i in enumerate(start)]
    commands = [command for place, one in enumerate(first) for command in replay_page.arm_commands(one, place)]
    return {
        "runs": [
            {**records[i], "place": place, "trace": {"t": records[i]["t"], **records[i]["trace"]}}
            for place, i in enumerate(start)
        ],
        "scene": commands,
        "made_by": replay_page.generator_line(),
        "title": compared.title,
        "live": False,
        "start": {"trace": True, "frames": False, "beside": True},
        "pair": {"shared": shared, "runs": own, "chosen": list(start)},
    }


def rate_within(runs: Sequence[ComparedRun], budget: int = BUDGET) -> float:
    """Samples a second that the page keeps [Hz], at most a replay's, so that its series stay within `budget` bytes."""
    numbers = sum((one.shown.arm.n + 5) * float(one.shown.run.t[-1]) for one in runs)  # a second
    return max(LEAST, min(replay_page.RATE, budget / (numbers * 16 / 3)))


def _record(one: ComparedRun, rate: float) -> dict[str, Any]:
    """A run's record for the player, with its figures among its facts."""
    (shown,) = replayed_runs([thinned(one.shown.run, rate)], [one.shown.arm], [f"{one.controller}, {one.plant}"])
    record = replay_page.run_record(shown)
    figures = [["tip RMS", f"{one.figures.tip_rms_mm:.3g} mm"],
               ["largest", f"{one.figures.tip_max_mm:.3g} mm"], ["limits", one.figures.limits]]  # fmt: skip
    figures += [["unstable,", str(one.cuts)]] if one.shakes else []
    about = [fact for fact in record["facts"] if fact[0] in ("reading", "audit")]
    samples = [int(shown.run.t.size), int(one.shown.run.t.size)]
    more = {"facts": figures + about, "controller": one.controller, "plant": one.plant, "samples": samples}
    return {**record, **more, "trace": {"points": replay_page.pack_int32(shown.pose[:, :3, 3])}}


def _nearest_first(runs: Sequence[ComparedRun]) -> list[ComparedRun]:
    """The stable runs, by the RMS error of the tip."""
    return sorted((one for one in runs if not one.shakes), key=lambda one: one.figures.tip_rms_mm)
