"""`krl write` of tables of axes, which move in proportion between rows, and of a run that ends with a pause."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.krl.writing.path_program import WritingOptions, write_path
from lwr_dyn.krl.writing.sampled_path import path_of_motion, read_sampled_path
from tests.krl.short_programs import HOME, run_of
from tests.krl.writing.test_path_program import dense, hausdorff, tool_places


def test_the_last_pause_belongs_to_the_path(arm):
    run = run_of(arm, HOME, "LIN_REL {Z -100}", "WAIT SEC 2")
    assert path_of_motion(run.to_run(), arm).duration == pytest.approx(run.cycle_time, abs=1e-3)


def test_between_rows_of_axes_the_axes_move_in_proportion(arm, tmp_path):
    """A line in their place would be 4.9 mm off."""
    (tmp_path / "a.csv").write_text("A1,A2,A3,A4,A5,A6\n0,-90,90,0,30,0\n10,-90,90,0,30,0\n40,-60,90,60,30,0\n")
    path = read_sampled_path(tmp_path / "a.csv", arm)
    written = write_path(path, WritingOptions(kinds=("PTP",), approximate=False))
    assert written.holds
    assert written.deviation.position < 5e-5
    fitted = write_path(path, WritingOptions())
    assert fitted.holds
    t = np.linspace(0.0, fitted.run.cycle_time, 4000)
    truth = np.interp(np.linspace(0, 2, 4000), [0, 1, 2], [0, 1, 2])
    rows = np.radians([[0, -90, 90, 0, 30, 0], [10, -90, 90, 0, 30, 0], [40, -60, 90, 60, 30, 0]])
    q = np.stack([np.interp(truth, [0, 1, 2], x) for x in rows.T], axis=1)
    places = [dense(tool_places(arm, x, np.eye(4)), 2000) for x in (q, fitted.run.timeline.sample(t).q)]
    assert hausdorff(*places) < 1.5e-3


def test_a_program_is_no_table(arm, tmp_path):
    (tmp_path / "a.src").write_text("DEF a( )\nWAIT SEC 1\nEND\n")
    with pytest.raises(FileAccessError, match=r"a program, no path; allowed: a \.csv"):
        read_sampled_path(tmp_path / "a.src", arm)


def test_a_table_of_six_axes_is_refused_for_an_arm_with_seven(tmp_path):
    (tmp_path / "a.csv").write_text("A1,A2,A3,A4,A5,A6\n0,-90,90,0,30,0\n10,-90,90,0,30,0\n")
    with pytest.raises(OptionError, match="6 joints"):
        read_sampled_path(tmp_path / "a.csv", lwr_dyn.load("lwr4plus"))
