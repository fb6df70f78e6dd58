"""What comes of a sweep of a controller with a kernel beside one without."""

from dataclasses import replace

import pytest

from lwr_dyn.studies.sweep.report_page import finish
from lwr_dyn.studies.sweep.running.sweep import sweep
from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults
from tests.studies.sweep.small import LAW, OWN, small_study


@pytest.mark.slow
def test_a_controller_in_python_takes_no_figures_from_the_others(tmp_path):
    made = small_study(tmp_path, OWN, "mine.py", mine=LAW)
    study = replace(made, runs=3, chunk=3, keep=0, limits={"tip_max": 1.0})
    sweep(study, tmp_path / "out", threads=1)
    summary = finish(study, SweepResults.load(tmp_path / "out")).summary
    assert summary.controllers[OWN].outwards is not None
    assert summary.not_searched == {"mine.py": "it has no kernel form"}
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "mine.py was not looked at, it has no kernel form." in page
    assert "mine.py: all runs by simulate, with stops." in page
