"""Figures of runs: their curves are the runs' numbers, with limits, references and units."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.pages.figures.run_figures import (
    error_figure,
    path_figure,
    register_figure,
    tip_error_figure,
    torque_figure,
)
from lwr_dyn.pages.replay.replayed_runs import replayed_runs


@pytest.fixture(scope="module")
def runs(arm, two_runs):
    return replayed_runs(two_runs, arm, ["first", "second"])


@pytest.mark.parametrize(("quantity", "name"), [("position error", "q"), ("velocity error", "dq")])
def test_error_curves_are_ref_minus_actual_in_thousandths(runs, quantity, name):
    figure = error_figure(runs, quantity=quantity)
    joints = list(runs[0].arm.joint_names)
    assert [panel.title for panel in figure.panels] == 2 * joints
    assert figure.panels[0].y_unit == ("mrad" if name == "q" else "mrad/s")
    for k, panel in enumerate(figure.panels):
        one, (curve,) = runs[k // 7], panel.curves
        error = 1e3 * (getattr(one.run, f"{name}_ref") - getattr(one.run, name))
        t, drawn = curve.points(runs)
        np.testing.assert_array_equal(t, one.run.t)
        np.testing.assert_array_equal(drawn, error[:, k % 7])
        assert curve.label == one.label


def test_tip_errors_are_distances_in_mm_a_curve_per_run(runs):
    (panel,) = tip_error_figure(runs).panels
    for curve, one in zip(panel.curves, runs, strict=True):
        away = np.linalg.norm(one.pose_ref[:, :3, 3] - one.pose[:, :3, 3], axis=1)
        np.testing.assert_allclose(curve.points(runs)[1], 1e3 * away, rtol=1e-12)


def test_torque_panels_have_both_limits_or_a_note_that_there_is_none(arm, two_runs):
    blind = replace(arm, limits=(*arm.limits[:6], JointLimits()))
    runs = replayed_runs(two_runs, blind)
    figure = torque_figure(runs)
    for panel, limit in zip(figure.panels, blind.limits, strict=True):
        values = sorted(level.value for level in panel.levels)
        assert values == ([] if limit.effort is None else [-limit.effort, limit.effort])
    assert figure.panels[6].note == "limit not known"
    assert figure.panels[0].note == "limit 176 N m"
    np.testing.assert_array_equal(figure.panels[2].curves[0].points(runs)[1], two_runs[0].tau_applied[:, 2])


def test_path_is_drawn_in_the_plane_given_or_the_widest(arm, runs):
    figure = path_figure(runs, plane="xz")
    points = flange_pose(arm.chain, runs[1].run.q)[:, :3, 3]
    np.testing.assert_allclose(np.column_stack(figure.curves[-1].points(runs)), points[:, [0, 2]])
    assert (figure.x_label, figure.panels[0].y_label) == ("x", "z")
    assert path_figure(runs).x_label in "xy"
    with pytest.raises(OptionError, match="plane: 'zy'; allowed: xy, xz, yz"):
        path_figure(runs, plane="zy")


def test_runs_of_one_reference_share_its_curve_and_others_have_their_own(arm, two_runs):
    trace = [[0.0, 0.0, 0.0], [0.1, 0.5, 1.0]]
    other = replace(two_runs[1], q_ref=two_runs[1].q_ref + 0.1, meta={"reference_trace": trace})
    runs = replayed_runs([*two_runs, other], arm, ["a", "b", "c"])
    assert [curve.label for curve in path_figure(runs, [0, 1]).curves] == ["reference", "a", "b"]
    curves = path_figure(runs, plane="yz").curves
    assert [curve.label for curve in curves] == ["reference", "reference", "a", "b", "c"]
    np.testing.assert_array_equal(np.column_stack(curves[1].points(runs)), np.array(trace)[:, 1:])


def test_register_shows_motion_and_torques_of_one_joint(runs):
    figure = register_figure(1, 3)
    drawn = [curve.points(runs)[1] for curve in figure.curves]
    run = runs[1].run
    for values, wanted in zip(drawn, (run.q, run.dq, run.tau_applied, run.tau_friction), strict=True):
        np.testing.assert_array_equal(values, wanted[:, 3])
    assert figure.title == "Register of joint 4"
