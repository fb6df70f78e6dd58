"""The plots: the curves are the run's numbers, the limits are drawn, the bytes are always the same."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from lwr_dyn.errors import FileAccessError, OptionError
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.viewer import plots

FIGURES = (plots.position_error_figure, plots.velocity_error_figure, plots.torque_figure, plots.path_figure)


def lines_of(figure, k):
    return [np.asarray(line.get_ydata()) for axes in figure.axes for line in axes.lines if len(line.get_ydata()) == k]


def test_error_curves_are_ref_minus_actual_in_thousandths(arm, two_runs):
    for make, names in ((plots.position_error_figure, "q"), (plots.velocity_error_figure, "dq")):
        drawn = lines_of(make(two_runs, arm), 3001)
        asked = [getattr(run, f"{names}_ref") - getattr(run, names) for run in two_runs]
        np.testing.assert_array_equal(drawn, [1e3 * error[:, j] for error in asked for j in range(7)])


def test_torque_panels_draw_both_limits_and_say_when_there_is_none(arm, two_runs):
    blind = replace(arm, limits=(*arm.limits[:6], JointLimits()))
    panels = plots.torque_figure(two_runs, blind).axes
    for panel, limit in zip(panels, blind.limits, strict=False):
        broken = sorted(float(line.get_ydata()[0]) for line in panel.lines if line.get_linestyle() == "--")
        assert broken == ([] if limit.effort is None else [-limit.effort, limit.effort])
    assert "limit not known" in panels[6].get_title("left")
    np.testing.assert_array_equal(panels[2].lines[0].get_ydata(), two_runs[0].tau_applied[:, 2])


def test_path_is_drawn_in_the_plane_asked_for(arm, two_runs):
    figure = plots.path_figure(two_runs, arm, plane="xz")
    points = forward_kinematics(arm.chain, two_runs[1].q)[:, :3, 3]
    drawn = figure.axes[0].lines[-1]
    np.testing.assert_allclose(np.column_stack([drawn.get_xdata(), drawn.get_ydata()]), points[:, [0, 2]])
    assert figure.axes[0].get_xlabel() == "x [m]"
    with pytest.raises(OptionError, match="plane: 'zy'; allowed: xy, xz, yz"):
        plots.path_figure(two_runs, arm, plane="zy")


@pytest.mark.parametrize("make", FIGURES, ids=lambda make: make.__name__)
def test_same_runs_give_the_same_bytes_whatever_the_settings(arm, two_runs, make):
    def both():
        figure = make(two_runs, arm)
        return plots.figure_bytes(figure, "png"), plots.figure_bytes(figure, "svg")

    png, svg = both()
    with matplotlib.rc_context({"font.size": 20.0, "axes.facecolor": "pink", "lines.linewidth": 5.0}):
        assert both() == (png, svg)
    assert png.startswith(b"\x89PNG")
    assert b"<svg" in svg


def test_save_writes_both_kinds_and_leaves_the_settings(arm, two_runs, tmp_path):
    before = dict(matplotlib.rcParams)
    written = plots.save_figure(plots.path_figure(two_runs, arm), tmp_path / "path.png")
    assert [path.name for path in written] == ["path.png", "path.svg"]
    assert all(path.stat().st_size > 1000 for path in written)
    assert dict(matplotlib.rcParams) == before
    with pytest.raises(FileAccessError):
        plots.save_figure(plots.path_figure(two_runs, arm), tmp_path / "none" / "path")
    with pytest.raises(OptionError, match="pdf"):
        plots.figure_bytes(plots.path_figure(two_runs, arm), "pdf")
