"""A comparison has the figures of its runs, marks the best of each plant, and refuses runs that follow other things."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import DivergenceError, LwrDynError
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.studies.compare.compared_run import conditions
from lwr_dyn.studies.compare.comparison import COLUMNS, _limits, comparison_of, cross_table
from lwr_dyn.studies.compare.plants import plant_case
from lwr_dyn.studies.compare.study import ControllerStudy


@pytest.fixture(scope="module")
def study(arm, move):
    cases = [plant_case(arm, text) for text in ("nominal", "payload=3")]
    return ControllerStudy(arm, move, ("pd-gravity", "inverse-dynamics"), cases, "move").run()


def test_every_controller_runs_on_every_plant_and_has_its_own_figures(study, arm):
    compared, runs = study
    assert [(one.controller[:3], one.plant) for one in compared.runs] == [
        ("PD ", "as modelled"), ("inv", "as modelled"), ("PD ", "3 kg at the flange"), ("inv", "3 kg at the flange"),
    ]  # fmt: skip
    for one, run in zip(compared.runs, runs, strict=True):
        figures = metrics(run, arm)
        assert one.errors == {"tip_rms_mm": figures.tip_rms_mm, "tip_max_mm": figures.tip_max_mm}
        assert one.peak_torque == np.abs(run.tau_applied).max()
        assert one.share == np.max(np.abs(run.tau_applied).max(axis=0) / arm.effort)
        assert one.audit == run.meta["audit"]["residual"]


def test_the_best_of_each_plant_is_marked(study):
    compared, _ = study
    for runs in compared.plants.values():
        for error in ("tip_rms_mm", "tip_max_mm"):
            best = min(one.errors[error] for one in runs)
            assert [bool(compared.mark(one, error)) for one in runs] == [one.errors[error] == best for one in runs]
    text = compared.table.text()
    assert text.count(" *") == 4  # two errors on two plants
    assert "errors of the tip: rigid links and joints" in text


def test_what_is_true_of_the_limits_of_all_runs_is_said_once(study):
    runs = study[0].runs
    unknown = SimpleNamespace(within_limits=None, limits="torque unknown", bodies="rigid")
    broken = SimpleNamespace(within_limits=False, limits="speed NOT kept (joint_1)", bodies="rigid")
    shown = [SimpleNamespace(**{n: getattr(one, n) for n in ("controller", "plant")}, figures=unknown) for one in runs]
    assert _limits(shown) == ["limits of all runs: torque unknown"]
    shown[1].figures = broken
    assert len(_limits(shown)) == 4
    assert _limits(shown)[1] == f"{runs[1].controller}, {runs[1].plant}: limits: speed NOT kept (joint_1)"
    assert not any("limits" in note for note in study[0].notes)


def test_a_torque_of_rounding_errors_is_no_share_of_a_limit():
    shown = next(column.format for column in COLUMNS if column.key == "torque_share")
    assert [shown(share) for share in (1.7e-31, 0.0771, np.nan)] == ["0 %", "7.71 %", "unknown"]


def test_record_columns_and_table_have_the_numbers(study, arm):
    compared, runs = study
    records, columns, rows = compared.record()["runs"], compared.to_columns(), compared.table.shown().cells
    assert compared.title == compared.record()["title"] == "lwr4plus, move, 0.3 s"
    for k, (one, run, record) in enumerate(zip(compared.runs, runs, records, strict=True)):
        torque = np.abs(run.tau_applied)
        share = (torque / arm.effort).max()
        wanted = {
            "controller": one.controller, "typed": ("pd-gravity", "inverse-dynamics")[k % 2], "plant": one.plant,
            "tip_rms_mm": one.figures.tip_rms_mm, "tip_max_mm": one.figures.tip_max_mm, "peak_torque": torque.max(),
            "torque_share": share, "torque_cut_share": one.cuts.share, "unstable": False,
            "audit_residual_J": run.audit["residual"], "best": ["tip_rms_mm", "tip_max_mm"] if k % 2 else [],
        }  # fmt: skip
        assert {key: record[key] for key in wanted} == wanted
        assert record["metrics"] == one.figures.to_json()
        numbers = ["tip_rms_mm", "tip_max_mm", "peak_torque", "torque_share", "audit_residual_J"]
        assert [columns[name][k] for name in columns] == [wanted[key] for key in ["controller", "plant", *numbers]]
        best = " *" if k % 2 else ""
        assert list(rows[k]) == [
            one.controller, one.plant, *(f"{wanted[key]:.4g}{best}" for key in numbers[:2]), f"{torque.max():.4g}",
            f"{100 * share:.3g} %", "kept", f"{run.audit['residual']:.0e}",
        ]  # fmt: skip
    assert pandas.DataFrame(columns).shape == (4, 7)
    assert repr(compared) == "RunComparison(4 runs on 2 plants; .table, .to_columns(), .figure, .save)"


def test_runs_and_their_files_compare_the_same(study, tmp_path):
    _, runs = study
    for i, run in enumerate(runs):
        run.save(tmp_path / f"{i}.npz")
    from_files = lwr_dyn.compare(*(tmp_path / f"{i}.npz" for i in range(4)))
    assert from_files.table.text() == lwr_dyn.compare(*runs).table.text()


def test_a_run_of_another_rate_is_compared_at_common_times(arm, move, study):
    _, runs = study
    slower = lwr_dyn.simulate(arm, lwr_dyn.controller("pid", arm), move, rate=500.0)
    assert len(lwr_dyn.compare(runs[0], slower).runs) == 2


def test_what_the_model_lacks_is_said_of_any_run(study, arm, move):
    _, runs = study
    assert [conditions(run) for run in runs[1:3]] == ["as modelled", "3 kg at the flange"]
    wam = lwr_dyn.load("wam7")
    hold = lwr_dyn.reference("hold", wam, q=[0.1] * 7, duration=0.01)
    assert conditions(lwr_dyn.simulate(wam, lambda *_: np.zeros(7), hold)) == "friction"
    late = lwr_dyn.simulate(arm, lwr_dyn.controller("pid", arm), move, delay=2, duration=0.02)
    assert conditions(late) == "delay"


def other_runs(arm, runs):
    """Runs that cannot be compared with the first of `runs`."""
    moved = replace(runs[0], q_ref=runs[0].q_ref + 1e-6)
    robot = replace(runs[0], setup=None, meta={**runs[0].meta, "robot": "wam7", "reading": None, "digest": None})
    longer = replace(runs[0], t=2.0 * runs[0].t)
    return {
        "reference": (moved, "different references, 1e-06 rad or m apart at t = "),
        "robot": (robot, "runs of lwr4plus and wam7; allowed: runs of one robot"),
        "duration": (longer, "different references, 0.3 s and 0.6 s long"),
        "times": (replace(runs[0], t=runs[0].t ** 2 / runs[0].t[-1]), "few common times"),
    }


@pytest.mark.parametrize("case", ["reference", "robot", "duration", "times"])
def test_runs_that_follow_other_things_are_refused_with_the_reason(case, arm, study):
    other, words = other_runs(arm, study[1])[case]
    with pytest.raises(LwrDynError) as fault:
        lwr_dyn.compare(study[1][0], other)
    assert words in str(fault.value)
    assert str(fault.value).startswith("run 1 and run 2: ")
    assert "\n" not in str(fault.value)


def test_references_that_differ_by_rounding_are_the_same(study):
    _, runs = study
    assert lwr_dyn.compare(runs[0], replace(runs[1], q_ref=runs[1].q_ref * (1.0 + 1e-14)))


BAD = {
    "none": ((), "compare: 0 runs; allowed: two runs or more"),
    "one": ((0,), "compare: one run; allowed: two runs or more"),
    "labels": ((0, 1), "labels: 1 for 2 runs"),
}


@pytest.mark.parametrize("case", BAD)
def test_too_few_runs_or_labels_are_refused(case, study):
    places, words = BAD[case]
    with pytest.raises(LwrDynError, match=words):
        lwr_dyn.compare(*(study[1][i] for i in places), labels=["a"] if case == "labels" else None)


def test_one_controller_twice_is_numbered_and_labels_replace_it(study):
    _, runs = study
    assert [one.controller[-2:] for one in lwr_dyn.compare(runs[0], runs[0]).runs] == [" 1", " 2"]
    assert [one.controller for one in lwr_dyn.compare(runs[0], runs[1], labels=["a", "b"]).runs] == ["a", "b"]


def test_a_limit_that_was_not_kept_is_in_the_notes(arm):
    there = arm.upper - 0.01
    push = lwr_dyn.reference("hold", arm, q=there, duration=0.1)
    cases = [plant_case(arm, "nominal")]
    with_file = ControllerStudy(arm, push, ("pd-gravity", "pid"), cases, options=(("q0", there), ("dq0", [2.0] * 7)))
    compared, _ = with_file.run()
    assert any("limits" in note and "stop" in note for note in compared.notes)
    assert "NOT kept" in compared.table.text()


def test_a_controller_that_diverges_is_a_line_and_alone_an_error(arm, move, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n    return 1e7 * (q - q_ref) + 1e5 * dq + 1.0\n"
    )
    cases, free = [plant_case(arm, "nominal")], (("saturate", False), ("position_limits", False))
    compared, runs = ControllerStudy(arm, move, ("inverse-dynamics", str(file)), cases, options=free).run()
    assert len(runs) == 1
    assert compared.failures[0].startswith("mine.py, as modelled: the simulation diverges at t = ")
    assert "diverges at t = " in compared.table.text()
    with pytest.raises(DivergenceError):
        ControllerStudy(arm, move, (str(file),), cases, options=free).run()


def test_no_controllers_or_no_plants_are_refused(arm, move):
    for controllers, cases, words in (
        ((), [plant_case(arm, "nominal")], "controllers: none"),
        (("pid",), [], "plants"),
    ):
        with pytest.raises(LwrDynError, match=words):
            ControllerStudy(arm, move, controllers, cases).run()


def test_only_a_run_is_named_by_the_error(study):
    with pytest.raises(LwrDynError, match=r"a and b: different references"):
        comparison_of([study[1][0], replace(study[1][0], t=2.0 * study[1][0].t)], ["a", "b"])


def run(typed, plant, error, unstable=False, best=()):
    return {"typed": typed, "plant": plant, "tip_rms_mm": error, "unstable": unstable, "best": list(best)}


def test_each_run_stands_in_its_row_and_column():
    text = cross_table([
        run("a", "as modelled", 1.23456, best=["tip_rms_mm"]), run("b:xi=2", "as modelled", 12345.0, unstable=True),
        run("b:xi=2", "late", 0.000123456, best=["tip_max_mm"]),
    ])  # fmt: skip
    assert text.splitlines() == [
        "| plant | `a` | `b:xi=2` |", "| --- | --- | --- |",
        "| as modelled | **1.23** | 1.23e+04 ! |", "| late | none | 0.000123 |",
    ]  # fmt: skip
