"""The summary of runs by formula: its figures are those of the runs, an interval stands only where one can be had."""

import json
from dataclasses import replace
from html import unescape
from itertools import pairwise

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.document import Document
from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.studies.sweep import summary_document
from lwr_dyn.studies.sweep.charts import indices_html
from lwr_dyn.studies.sweep.intervals import IntervalEstimate, percent, quantile_of, share_of
from lwr_dyn.studies.sweep.report_page import report_html
from lwr_dyn.studies.sweep.summary import sample_rows, spans, summarise
from tests.studies.sweep.made_up import CONTROLLERS, evaluate, metrics_of, runs_of, study, varied, without_divergence


def summary_text(summary):
    """What people read."""
    return Document("", "", summary_document.summary_sections(summary)).text()


def summary_record(summary):
    """What programs read."""
    return json.loads(json_text(Document("", "", summary_document.summary_sections(summary)).record()))["summary"]


MADE = study(4000)
RUNS = runs_of(MADE)


@pytest.fixture(scope="module")
def summary():
    return summarise(MADE, RUNS, evaluate)


@pytest.mark.slow
def test_quantiles_and_shares_are_those_of_the_runs(summary):
    for name, one in summary.controllers.items():
        tip = RUNS[name].metrics["tip_max"]
        assert one.metrics["tip_max"].quantiles[1] == quantile_of(tip, 0.95)
        inside = (tip <= 1e-3) & (RUNS[name].metrics["limit_margin"].min(axis=1) >= 0.05)
        assert one.within == share_of(int(inside.sum()), 4000)
        assert one.metrics["tip_max"].within == share_of(int((tip <= 1e-3).sum()), 4000)
        assert one.events["not finite"].count == int(np.isinf(tip).sum()) > 0
        assert one.events["torque cut"].count == int((RUNS[name].values["payload.mass"] > 6.8).sum())


def test_a_lower_bound_is_judged_from_below(summary):
    one = summary.controllers[CONTROLLERS[1]].metrics["limit_margin"]
    margin = RUNS[CONTROLLERS[1]].metrics["limit_margin"].min(axis=1)
    found = one.words.shown(one.quantiles[1].value)
    assert np.mean(1e3 * margin >= found) == pytest.approx(0.95, abs=1e-3)
    assert one.quantiles[1].value == -np.sort(np.nan_to_num(margin, nan=-np.inf))[200]


def test_the_worst_runs_are_the_worst(summary):
    chosen = summary.worst()
    assert [name for name, _ in chosen] == [name for name in CONTROLLERS for _ in range(2)]
    for name in CONTROLLERS:
        tip = RUNS[name].metrics["tip_max"]
        order = [run for one, run in summary.worst(4000) if one == name]
        assert all(tip[a] >= tip[b] for a, b in pairwise(order))


@pytest.mark.slow
def test_the_first_break_is_found_by_runs_of_its_own(summary):
    found = summary.controllers[CONTROLLERS[1]].outwards
    assert {line.share for line in found.lines} == {None}  # 0.8 mm at 7 kg without delay
    tighter = replace(MADE, limits={"tip_max": 0.55e-3})
    found = summarise(tighter, RUNS, evaluate).controllers[CONTROLLERS[1]].outwards
    assert found.lines[0].path == "payload.mass"
    assert found.lines[0].kept < 3.9 <= found.lines[0].broken <= 3.93
    assert summary.extra_runs == 3 * found.runs - 3 * 16
    assert "payload.mass" in summary_document.outward_table(summarise(tighter, RUNS, evaluate)).text()
    assert summary_document.outward_table(summary).rows[0][1:3] == ("none", "their ends")


def test_spans_begin_at_the_nominal_value_and_keep_to_what_can_be():
    by_path = {span.path: span for span in spans(MADE)}
    assert by_path["loop.delay"].values == (0.0, 1.0, 2.0, 3.0, 4.0)
    assert by_path["reading"].nominal == "computed"
    assert by_path["arm.com"].draws == 6
    whole = replace(
        MADE, parameters=(varied("loop.delay", 0.0, 3.0, 0.0), varied("controller.omega_n", 10.0, 30.0, None))
    )
    delay, gain = spans(whole)
    assert delay.values == (0.0, 1.0, 2.0, 3.0)
    assert gain.nominal == 20.0


@pytest.mark.slow
def test_a_saltelli_design_has_indices_and_its_quantiles_rest_on_two_rows_of_each_group():
    made = study(8 * 64, "saltelli")
    one = summarise(made, runs_of(made)).controllers[CONTROLLERS[0]]
    assert one.metrics["tip_max"].quantiles[0].runs == 2 * 64
    assert sample_rows(made, np.arange(16)).nonzero()[0].tolist() == [0, 1, 8, 9]
    found = one.metrics["limit_margin"].indices
    assert list(found.total) == [each.path for each in made.varied]
    assert max(found.total, key=lambda path: found.total[path].value) == "payload.mass"
    assert "rows A and B" in summary_text(summarise(made, runs_of(made)))


def test_a_share_just_below_zero_is_zero():
    made = study(8 * 64, "saltelli")
    whole = summarise(made, {CONTROLLERS[0]: runs_of(without_divergence(made))[CONTROLLERS[0]]})
    near = IntervalEstimate(-1e-3, -2e-3, -1e-4)
    words = whole.focus[0].name
    figures = whole.controllers[CONTROLLERS[0]]
    found = replace(figures.metrics[words].indices, first={"payload.mass": near}, total={"payload.mass": near})
    metric = replace(figures.metrics[words], indices=found)
    part = replace(whole, controllers={CONTROLLERS[0]: replace(figures, metrics={words: metric})})
    for text in (summary_document.index_table(part).text(), indices_html(found)):
        assert "0.00 [0.00 to 0.00]" in text
        assert "-0.00" not in text


@pytest.mark.slow
def test_a_study_that_is_not_finished_keeps_its_groups():
    made = without_divergence(study(8 * 64, "saltelli"))
    parts = runs_of(made)[CONTROLLERS[0]], runs_of(made, 0, 8 * 40 + 3)[CONTROLLERS[0]]
    whole, part = (summarise(made, {CONTROLLERS[0]: one}).controllers[CONTROLLERS[0]] for one in parts)
    assert part.metrics["limit_margin"].indices.groups == 40
    assert whole.metrics["limit_margin"].indices.groups == 64
    failures = {CONTROLLERS[1]: {3: "its process died", 1: "run 9: no number"}}
    part = summarise(made, {CONTROLLERS[0]: parts[1]}, failures=failures)
    lacking = f"189 of {CONTROLLERS[0]}, 512 of {CONTROLLERS[1]} (chunk 1: run 9: no number), 512 of {CONTROLLERS[2]}."
    for said in (summary_text(part), unescape(report_html(part))):
        assert "323 of 512 runs" in said
        assert f"Missing runs, which may be the worst: {lacking}" in said
    assert summary_record(part)["missing"] == dict(zip(CONTROLLERS, (189, 512, 512), strict=True))
    assert "Missing" not in summary_text(summarise(made, runs_of(made)))


@pytest.mark.slow
def test_a_controller_that_cannot_be_searched_takes_nothing_from_the_others():
    slow = CONTROLLERS[1]
    part = summarise(MADE, RUNS, evaluate, not_searched={slow: "it has no kernel form"})
    assert [name for name, one in part.controllers.items() if one.outwards is None] == [slow]
    assert {row[0] for row in summary_document.outward_table(part).rows} == set(CONTROLLERS) - {slow}
    assert f"Each parameter alone: {slow} was not looked at, it has no kernel form." in summary_text(part)
    assert "Not looked at: it has no kernel form." in report_html(part)
    assert summary_record(part)["not_searched"] == {slow: "it has no kernel form"}
    assert "not looked at" not in summary_text(summarise(MADE, RUNS, not_searched={slow: "it has no kernel form"}))


def test_torque_is_not_cut_where_it_is_not_known_and_none_has_an_interval():
    first = CONTROLLERS[0]
    cut = np.zeros((4000, 2))
    cut[:3000, 1], cut[3000:3010, 0] = np.nan, 0.1
    lost = replace(RUNS[first], metrics={**RUNS[first].metrics, "saturated_s": cut}, flags=np.full(4000, "diverged"))
    both = summarise(MADE, {first: lost, CONTROLLERS[1]: RUNS[CONTROLLERS[1]]})
    assert both.controllers[first].events["torque cut"] == share_of(10, 1000)
    assert both.controllers[CONTROLLERS[1]].events["diverged"] == share_of(0, 4000)
    assert all(cell.endswith("]") for row in summary_document.event_table(both).rows for cell in row[1:])
    assert f"Torque cut: of the runs of which it is known, 1000 of 4000 of {first}." in summary_text(both)


@pytest.mark.parametrize(("robot", "known"), [("lwr4plus", True), ("kr30ha", False), ("lwr4", False)])
def test_without_torque_limits_no_share_of_runs_is_cut(robot, known):
    summary = summarise(MADE, RUNS, arm=lwr_dyn.load(robot))
    assert [("torque cut" in one.events) for one in summary.controllers.values()] == [known] * len(RUNS)
    assert ("Torque limits are unknown: no run shows whether torques keep them." in summary_text(summary)) != known


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loop", "slow", "flagged", "words"),
    [
        ({"friction": "none"}, [], True, "without friction and without stops; those that reach a stop are"),
        ({"hand_over": False}, [], False, "without stick and without stops; none of them reached one."),
        ({"position_limits": False}, [], False, "without stick; positions have no limits."),
        ({}, [0], True, f"show its figures. {CONTROLLERS[0]}: all runs by simulate, with stops."),
        ({"position_limits": False}, [0, 1], True,
         f"with smooth friction, without stick. {CONTROLLERS[0]}, {CONTROLLERS[1]}: all runs by simulate."),
    ],
)  # fmt: skip
def test_what_runs_lack_is_said_by_case(loop, slow, flagged, words):
    """`simulate` has stops, and makes all runs of a controller in Python; friction and limits may be left out."""
    runs = {}
    for k, name in enumerate(CONTROLLERS[:2]):
        flags = RUNS[name].flags if flagged else np.full(4000, "")
        runs[name] = replace(RUNS[name], flags=flags, simulated=(flags != "") | (k in slow))
    assert words in summary_document.caveat(summarise(replace(MADE, loop=loop), runs))


def test_a_grid_has_no_intervals():
    parameters = (replace(varied("payload.mass", 0, 7, 0), distribution="levels", values=(0.0, 3.0, 7.0)),)
    made = study(3, "grid", parameters=parameters, limits={})
    fixed = {path: column[:3] for path, column in MADE.values(0, 3).items()}
    runs = {name: replace(one, run=np.arange(3), values=made.values(0, 3), metrics=metrics_of(fixed, 1.0),
                          flags=one.flags[:3], simulated=one.simulated[:3]) for name, one in RUNS.items()}  # fmt: skip
    summary = summarise(made, runs)
    assert not summary.is_sample
    assert "[" not in summary_document.quantile_table(summary, summary.focus[0]).text().splitlines()[-1]
    assert "A grid is no sample" in summary_text(summary)
    first = summary_record(summary)["controllers"][CONTROLLERS[0]]["metrics"]["tip_max"]["quantiles"][0]
    assert "low" not in first


def test_too_few_runs_are_said():
    made = study(200)
    text = summary_text(summarise(made, runs_of(made)))
    assert "99.9 % needs 3688 runs, and 200 were drawn" in text
    assert " to ?]" in text
    record = summary_record(summarise(made, runs_of(made)))
    last = record["controllers"][CONTROLLERS[0]]["metrics"]["tip_max"]["quantiles"][-1]
    assert (last["high"], last["runs"], last["runs_needed"]) == (None, 200, 3688)


def test_the_text_says_what_the_runs_lack_and_the_record_is_in_si(summary):
    text = summary_text(summary)
    assert "without stick and without stops" in text
    assert "4000 runs a controller on the same plants (independent points, seed 0)" in text
    assert "Unbounded: runs that diverged; they keep no limit." in text
    quantile = summary_record(summary)["controllers"]["adaptive"]["metrics"]["tip_max"]["quantiles"][0]
    assert quantile["value"] == np.sort(RUNS["adaptive"].metrics["tip_max"])[1999]
    assert quantile["low"] < quantile["value"] < quantile["high"]
    assert summary_document.event_table(summary).rows[0][1].endswith("]")


def test_runs_that_were_not_handed_over_are_counted():
    alone = {name: replace(one, simulated=np.zeros(one.count, dtype=bool)) for name, one in RUNS.items()}
    flagged = sum(int((one.flags != "").sum()) for one in RUNS.values())
    text = summary_text(summarise(MADE, alone))
    assert f"{flagged} that met a stop or diverged were not computed again, and have no figures." in text


def test_a_limit_of_another_name_and_a_controller_without_runs_are_refused():
    with pytest.raises(UnknownNameError, match="tip_most"):
        summarise(replace(MADE, limits={"tip_most": 1.0}), RUNS)
    empty = replace(
        RUNS["adaptive"], run=np.arange(0), values={}, metrics={}, flags=np.array([]), simulated=np.array([])
    )
    with pytest.raises(OptionError, match="results of adaptive: no run"):
        summarise(MADE, {"adaptive": empty})


@pytest.mark.parametrize(("share", "text"), [(0.9999, "99.99"), (0.123456, "12.3"), (0.0, "0"), (1e-9, "0.0000001")])
def test_a_share_is_never_rounded_to_none_or_all(share, text):
    assert percent(share) == text
