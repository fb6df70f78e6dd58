"""The worst runs of a study in its page: their parameters in a table, and each as a replay inside the page."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.page_parts import script_safe
from lwr_dyn.pages.replay.replay_page import RATE, replay_html
from lwr_dyn.studies.sweep.report.parallel_lines import MOST_AXES
from lwr_dyn.studies.sweep.statistics.summary import SweepSummary, draw_columns
from lwr_dyn.studies.sweep.statistics.summary_words import value_text

_DATA = re.compile(r'(<script type="application/json" id="replay-data">)(.*?)(</script>)', re.DOTALL)


@dataclass(frozen=True, slots=True, eq=False)
class WorstRun:
    """A run of a study again, whole, with the arm that was simulated."""

    controller: str
    number: int
    run: Run
    arm: Arm

    @property
    def label(self) -> str:
        """Controller and number of the run."""
        return f"{self.controller}, run {self.number}"


def worst_table_html(
    summary: SweepSummary, inks: Mapping[str, str], units: Mapping[str, str], runs: Sequence[WorstRun]
) -> str:
    """The worst runs with their metrics and parameters; those that are in `runs` have a button for their replay."""
    replays = {(one.controller, one.number): place for place, one in enumerate(runs)}
    first = next(iter(summary.controllers.values()))
    paths, all_paths = _paths(summary), len(draw_columns(summary.study, first.runs))
    heads = [("controller", ""), ("run", ""), ("replay", ""), *((words.title, words.unit) for words in summary.focus)]
    heads += [("flag", ""), *((path, units.get(path, "")) for path in paths)]
    head = "".join(f'<th scope="col">{escape(name)} <small>{escape(unit)}</small></th>' for name, unit in heads)
    body = ""
    for name, figures in summary.controllers.items():
        drawn = draw_columns(summary.study, figures.runs)
        for row in figures.worst[: summary.study.keep]:
            number = int(figures.runs.run[row])
            cells = [value_text(w, float(figures.metrics[w.name].badness[row])) for w in summary.focus]
            cells += [str(figures.runs.flags[row]) or "none", *(_cell(drawn[path][row]) for path in paths)]
            numbers = "".join(f'<td class="n">{escape(cell)}</td>' for cell in cells)
            who = f'<th scope="row"><i class="sw {inks[name]}"></i>{escape(name)}</th><td class="n">{number}</td>'
            body += f"<tr>{who}<td>{_button(name, number, replays.get((name, number)))}</td>{numbers}</tr>"
    more = f'<p class="note">{len(paths)} of {all_paths} parameters; the files of results have all.</p>'
    table = f'<table class="worst-runs"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    scrolled = f'<div class="scroll" tabindex="0" role="region" aria-label="Worst runs">{table}</div>'
    return scrolled + (more if all_paths > len(paths) else "")


def _button(name: str, number: int, place: int | None) -> str:
    if place is None:
        return ""
    more = f'<span class="unseen"> of {escape(name)}, run {number}</span>'
    return f'<button type="button" data-replay="{place}">Replay{more}</button>'


def _paths(summary: SweepSummary) -> list[str]:
    """The parameters that matter most to any controller."""
    ranks: dict[str, int] = {}
    for figures in summary.controllers.values():
        for place, each in enumerate(figures.metrics[summary.focus[0].name].influence):
            ranks[each.path] = min(place, ranks.get(each.path, place))
    first = next(iter(summary.controllers.values()))
    return (
        sorted(ranks, key=lambda path: ranks[path])[:MOST_AXES]
        or list(draw_columns(summary.study, first.runs))[:MOST_AXES]
    )


def _cell(value: Any) -> str:
    return str(value) if isinstance(value, str) else f"{float(np.asarray(value)):.3g}"


def replay_scripts(runs: Sequence[WorstRun]) -> str:
    """Script elements: the page of a replay once without its runs, and the data of each run."""
    if not runs:
        return ""
    pages = [replay_html([one.run], one.arm, labels=[one.label], title="Worst runs", rate=RATE / 2) for one in runs]
    found = [_DATA.search(page) for page in pages]
    data = [json.loads(one[2]) for one in found if one is not None]
    frame = _DATA.sub(lambda one: one[1] + "@@data@@" + one[3], pages[0])
    made = {
        "page": frame,
        "runs": [json.dumps(one, sort_keys=True) for one in data],
        "labels": [one.label for one in runs],
    }
    return f'<script type="application/json" id="replays">{script_safe(json.dumps(made))}</script>\n'
