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
from lwr_dyn.studies.sweep.intervals import percent, share_of
from lwr_dyn.studies.sweep.report_page import report_html
from lwr_dyn.studies.sweep.summary import ControllerRuns, sample_rows, spans, summarise
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
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


K = np.arange(60)
LOADS = SweepStudy(
    "loads", "lwr4plus", "computed", ("a", "b", "c"), "hold", method="random", runs=60, keep=2,
    limits={"tip_max": 50e-3}, parameters=(varied("payload.mass", 0.0, 7.0, 0.0, "kg"),),
)  # fmt: skip


def by_load(values):
    """A millimetre for each sixtieth of 7 kg that is begun."""
    return {"tip_max": 1e-3 * (1 + np.floor(60 * values["payload.mass"] / 7))}


def loads(name, count=60, lost=60):
    """Runs 0 to 59 with 1 to 60 mm; those from `lost` on diverge. Torque is cut from 45 on, and unknown from 57 on."""
    k, values = K[:count], {"payload.mass": 7 * (K[:count] + 0.5) / 60}
    metrics = {"tip_max": np.where(k >= lost, np.nan, by_load(values)["tip_max"])}
    metrics["saturated_s"] = np.column_stack([np.where(k >= 45, 0.1, 0.0), np.where(k >= 57, np.nan, 0.0)])
    return ControllerRuns(name, k, values, metrics, np.where(k >= lost, "diverged", ""), k >= lost)


SIXTY = {"a": loads("a"), "b": loads("b", lost=57), "c": loads("c", 58)}
"""By hand: the median of 60 is the 30th, and bounded by the 22nd and the 39th; 72 runs would bound 95 %."""


def test_a_summary_by_hand_in_words():
    failures = {"c": {7: "no", 3: "not"}}
    made = summarise(LOADS, SIXTY, lambda name, values: by_load(values), None, {"c": "it is slow"}, failures)
    assert [line.rstrip() for line in summary_text(made).splitlines()] == WORDS
    assert made.worst() == [("a", 59), ("a", 58), ("b", 57), ("b", 58), ("c", 57), ("c", 56)]
    assert "not looked at" not in summary_text(summarise(LOADS, SIXTY, not_searched={"c": "it is slow"}))
    record = summary_record(made)
    share = share_of(50, 60)
    kept = {"count": 50, "runs": 60, "share": 50 / 60, "low": share.low, "high": share.high}
    quantiles = [(0.5, 30, 22, 39, 6), (0.95, 57, 53, None, 72), (0.99, 60, 58, None, 368), (0.999, 60, 59, None, 3688)]
    parts = [(7 * (12 * k + 0.5) / 60, 7 * (12 * k + 11.5) / 60, 12e-3 * (k + 1)) for k in range(5)]
    first = record["controllers"]["a"]
    (influence,) = first["metrics"]["tip_max"].pop("influence")
    for one, (low, high, value) in zip(influence.pop("parts"), parts, strict=True):
        assert one == pytest.approx({"from": low, "to": high, "quantile": value, "runs": 12})
    assert influence == {"parameter": "payload.mass", "clear": True, "goes_along_with": [], "rank_correlation": 1.0}
    assert first["metrics"]["tip_max"] == {
        "bound": 0.05, "kept": kept, "sobol": None,
        "quantiles": [
            {"share": p, "value": pytest.approx(1e-3 * x), "low": pytest.approx(1e-3 * a),
             "high": b and pytest.approx(1e-3 * b), "runs": 60, "runs_needed": n}
            for p, x, a, b, n in quantiles
        ],
    }  # fmt: skip
    step = 7.0 / 256
    (line,) = first["first_break"]["lines"]
    assert line == {"parameter": "payload.mass", "end": 7.0, "share": 214 / 256, "kept": 213 * step,
                    "broken": 214 * step, "limit": "tip_max"}  # fmt: skip
    assert (first["runs"], first["all_limits_kept"], first["events"]["torque cut"]["count"]) == (60, kept, 12)
    rest = {"name": "loads", "robot": "lwr4plus", "reading": "computed", "task": "hold", "method": "random", "seed": 0,
            "runs": 60, "extra_runs": 66, "digest": LOADS.digest, "limits": {"tip_max": 0.05}, "level": 0.95,
            "missing": {"c": 2}, "not_searched": {"c": "it is slow"}}  # fmt: skip
    assert {key: record[key] for key in rest} == rest
    assert record["caveat"] == summary_document.caveat(made)
    assert record["worst"] == [{"controller": name, "run": run} for name, run in made.worst()]
    assert record["controllers"]["c"]["first_break"] is None


WORDS = """\
loads: lwr4plus computed, hold
58 to 60 of 60 runs a controller on the same plants (independent points, seed 0); 66 more to see what breaks a limit \
first. Missing runs, which may be the worst: 2 of c (chunk 3: not).

error of the tip, largest [mm]
controller  runs  <= 50 kept             median         95 % at most  99 % at most        99.9 % at most
----------  ----  ---------------------  -------------  ------------  ------------------  ------------------
a           60    83.3 % [71.5 to 91.7]  30 [22 to 39]  57 [53 to ?]  60 [58 to ?]        60 [59 to ?]
b           60    83.3 % [71.5 to 91.7]  30 [22 to 39]  57 [53 to ?]  unbounded [? to ?]  unbounded [? to ?]
c           58    86.2 % [74.6 to 93.9]  29 [22 to 37]  56 [51 to ?]  58 [56 to ?]        58 [57 to ?]

Of the runs
controller  all limits kept        simulated        diverged         torque cut
----------  ---------------------  ---------------  ---------------  ---------------------
a           83.3 % [71.5 to 91.7]  0 % [0 to 6]     0 % [0 to 6]     21.1 % [11.4 to 33.9]
b           83.3 % [71.5 to 91.7]  5 % [1 to 13.9]  5 % [1 to 13.9]  21.1 % [11.4 to 33.9]
c           86.2 % [74.6 to 93.9]  0 % [0 to 6.2]   0 % [0 to 6.2]   21.1 % [11.4 to 33.9]

95 % quantile of error of the tip, largest [mm], runs cut by each parameter
controller  parameter     best part     there  worst part    there      clear  rank correlation
----------  ------------  ------------  -----  ------------  ---------  -----  ----------------
a           payload.mass  0.06 to 1.34  12     5.66 to 6.94  60         yes    +1.00
b           payload.mass  0.06 to 1.34  12     5.66 to 6.94  unbounded  yes    +1.00
c           payload.mass  0.06 to 1.34  12     5.42 to 6.71  58         yes    +1.00

Each parameter alone, from its nominal value outwards
controller  parameter     kept up to  broken at                limit
----------  ------------  ----------  -----------------------  -------
a           payload.mass  5.824       5.852 (84 % of the way)  tip_max
b           payload.mass  5.824       5.852 (84 % of the way)  tip_max

In brackets: 95 % intervals, of quantiles by order statistics, of shares by Clopper and Pearson.
Runs are computed with smooth friction, without stick and without stops; those that reach a stop are computed again by \
simulate, and show its figures. Unbounded: runs that diverged; they keep no limit.
Torque cut: of the runs of which it is known, 57 of 60 of a, 57 of 60 of b, 57 of 58 of c.
Each parameter alone: c was not looked at, it is slow.
?: not bounded by the runs: 95 % needs 72 runs, and 60 were drawn; 99 % needs 368 runs, and 60 were drawn; 99.9 % \
needs 3688 runs, and 60 were drawn.
?: not bounded by the runs: 95 % needs 72 runs, and 58 were drawn; 99 % needs 368 runs, and 58 were drawn; 99.9 % \
needs 3688 runs, and 58 were drawn.""".splitlines()


@pytest.mark.parametrize(
    ("loop", "slow", "count", "words"),
    [
        ({"friction": "none"}, "", 60, "without friction and without stops; those that reach a stop are computed"),
        ({"hand_over": False}, "", 57, "without stick and without stops; none of them reached one."),
        ({"position_limits": False}, "", 57, "without stick; positions have no limits."),
        ({}, "a", 60, "show its figures. a: all runs by simulate, with stops. Unbounded: runs that diverged;"),
        ({"position_limits": False}, "ab", 60, "without stick. a, b: all runs by simulate. Unbounded"),
        ({}, None, 60, "without stops; 3 that met a stop or diverged were not computed again, and have no figures."),
        ({"position_limits": False}, None, 60,
         "positions have no limits; 3 that diverged were not computed again, and have no figures. "
         "Unbounded: runs that have no figures; they keep no limit."),
    ],
)  # fmt: skip
def test_what_runs_lack_is_said_by_case(loop, slow, count, words):
    """`simulate` has stops, and makes all runs of a controller in Python; friction and limits may be left out."""
    runs = {name: loads(name, count, 57 if name == "b" else 60) for name in "ab"}
    for name in "ab" if slow is None else slow:
        runs[name] = replace(runs[name], simulated=np.full(count, slow is not None))
    assert words in summary_document.caveat(summarise(replace(LOADS, loop=loop), runs))


@pytest.mark.parametrize(
    ("limit", "row"), [(0.5, ("none", "their ends", "", "")), (1e-4, ("none", "", "broken as modelled", "tip_max"))]
)
def test_limits_that_nothing_or_everything_breaks(limit, row):
    made = summarise(replace(LOADS, limits={"tip_max": limit}), {"a": SIXTY["a"]}, lambda name, values: by_load(values))
    assert list(summary_document.outward_table(made).rows) == [("a", *row)]


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


@pytest.mark.parametrize(("robot", "known"), [("lwr4plus", True), ("kr30ha", False), ("lwr4", False)])
def test_without_torque_limits_no_share_of_runs_is_cut(robot, known):
    summary = summarise(MADE, RUNS, arm=lwr_dyn.load(robot))
    assert [("torque cut" in one.events) for one in summary.controllers.values()] == [known] * len(RUNS)
    assert ("Torque limits are unknown: no run shows whether torques keep them." in summary_text(summary)) != known


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
