"""The table of errors: what it writes of each pair, and how dark a page shows it."""

from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.audit.sensitivity.result_tables import error_table

TIPS = np.array([[1.0, 2.0], [4.0, np.nan]])


def test_errors_are_written_with_their_marks_and_shaded_by_their_share():
    run = SimpleNamespace(model="a", plant="b", controller="pd", rate=2000.0)
    result = SimpleNamespace(
        names=("a", "b"), rate=1000.0, runs=(run,), tip_rms_mm=lambda name: TIPS, worst_mrad=lambda name: 10 * TIPS
    )
    table = error_table(result, "pd")
    assert table.cells == (("a", "1 (10)", "2 (20)*"), ("b", "4 (40)", "no run"))
    assert table.shades == ((None, 0.0, pytest.approx(0.25)), (None, pytest.approx(0.75), 0.0))
