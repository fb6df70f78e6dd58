"""The table of errors: what it writes of each pair, and how dark a page shows it."""

from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.checks.sensitivity.analysis import error_table, notes

TIPS = np.array([[1.0, 2.0], [4.0, np.nan]])


def result_of(**stops):
    def run(model, plant):
        met = stops.get(model + plant, "")
        figures = SimpleNamespace(stops=SimpleNamespace(met=bool(met), sentence=lambda: met))
        rate = 2000.0 if (model, plant) == ("a", "b") else 1000.0
        return SimpleNamespace(model=model, plant=plant, controller="pd", rate=rate, metrics=figures, fault="")

    return SimpleNamespace(
        names=("a", "b"), rate=1000.0, runs=tuple(run(m, p) for m in "ab" for p in "ab"),
        tip_rms_mm=lambda name: TIPS, worst_mrad=lambda name: 10 * TIPS,
    )  # fmt: skip


def test_errors_are_written_with_their_marks_and_shaded_by_their_share():
    table = error_table(result_of(), "pd")
    assert table.cells == (("a", "1 (10)", "2 (20)*"), ("b", "4 (40)", "no run"))
    assert table.shades == ((None, 0.0, pytest.approx(0.25)), (None, pytest.approx(0.75), 0.0))


def test_a_run_that_met_a_stop_is_marked_and_named():
    result = result_of(ab="joint_6 on its stop for 1.6 s")
    assert error_table(result, "pd").cells[0] == ("a", "1 (10)", "2 (20)*!")
    assert "! pd, a on b: joint_6 on its stop for 1.6 s" in notes(result)
