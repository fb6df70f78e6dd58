"""Figures of runs: their curves are the runs' numbers, a wall's forces, or an observer's torques, with limits."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Level
from lwr_dyn.pages.figures.run_figures import (
    QUANTITIES,
    contact_figure,
    error_figure,
    observer_figure,
    path_figure,
    pressing_and_drag,
    register_figure,
    tip_error_figure,
    torque_figure,
)
from lwr_dyn.pages.plotting.plots import figure_bytes
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.simulation.walls_and_pushes import Push, Wall
from tests.pages.replay.replayed import lagging_run
from tests.simulation.sample_runs import joint_waves, lwr
from tests.simulation.test_walls_and_pushes import ARM, POSE, TIP


@pytest.fixture(scope="module")
def runs(arm, two_runs):
    return replayed_runs(two_runs, arm, ["first", "second"])


@pytest.mark.parametrize(("quantity", "name"), [("position error", "q"), ("velocity error", "dq")])
def test_error_curves_are_ref_minus_actual_in_thousandths(runs, quantity, name):
    figure = error_figure(runs, quantity=quantity)
    joints = list(runs[0].arm.joint_names)
    assert [panel.title for panel in figure.panels] == 2 * joints
    assert (figure.panels[0].y_unit, figure.columns) == ("mrad" if name == "q" else "mrad/s", 4)
    for k, panel in enumerate(figure.panels):
        one, (curve,) = runs[k // 7], panel.curves
        error = 1e3 * (getattr(one.run, f"{name}_ref") - getattr(one.run, name))
        t, drawn = curve.points(runs)
        np.testing.assert_array_equal(t, one.run.t)
        np.testing.assert_array_equal(drawn, error[:, k % 7])
        assert curve.label == one.label


def described(figure):
    """Its id, title, columns; title, quantity and unit of each panel; labels of curves."""
    panels = [(panel.title, panel.y_label, panel.y_unit) for panel in figure.panels]
    assert (figure.x_label, figure.x_unit, figure.over_time) == ("time", "s", True)
    return (figure.id, figure.title, figure.columns), panels, [curve.label for curve in figure.panels[0].curves]


@pytest.mark.parametrize(
    ("quantity", "head", "units", "limits"),
    [
        ("torque", ("torque", "Torques and their limits", 2), ("N m", "N"), "effort"),
        ("position error", ("position-error", "Position errors", 2), ("mrad", "mm"), ""),
        ("velocity error", ("velocity-error", "Speed errors", 2), ("mrad/s", "mm/s"), ""),
        ("position", ("q", "Positions", 2), ("rad", "m"), ""),
        ("velocity", ("dq", "Speeds", 2), ("rad/s", "m/s"), "velocity"),
        ("friction", ("friction", "Friction", 2), ("N m", "N"), ""),
        ("energy", ("energy", "Energy", 1), ("J",), ""),
        ("tip error", ("tip-error", "Tip error", 1), ("mm",), ""),
    ],
)
def test_each_quantity_has_its_units_joint_by_joint_and_its_limits(tmp_path, quantity, head, units, limits):
    """Of an arm that turns and slides, beside an arm of one joint less."""
    arms = []
    for joints in ("RP", "R"):
        (tmp_path / f"{joints}.toml").write_text(template("own.toml", joints, joints), encoding="utf-8")
        arms.append(lwr_dyn.load(tmp_path / f"{joints}.toml"))
    runs = replayed_runs([lagging_run(arm, 0.02, "pid", k=5) for arm in arms], arms, ["both", "one"])
    figure = QUANTITIES[quantity](runs)
    found, panels, labels = described(figure)
    assert (found, tuple(unit for *_, unit in panels)) == (head, units)
    names = [arms[0].joint_names[k] for k in range(len(units))] if len(units) == 2 else [""]
    assert [title for title, *_ in panels] == names
    reference = ["reference"] if quantity in ("position", "velocity") else []
    assert [label.partition(";")[0] for label in labels] == [*reference, "both", "one"]
    if len(units) == 2:
        assert [c.label.partition(";")[0] for c in figure.panels[1].curves] == [*reference, "both"]
    for panel, joint, unit in zip(figure.panels, arms[0].limits, units, strict=False):
        most = getattr(joint, limits, None)
        assert panel.levels == ((Level("limit", most), Level("limit", -most)) if limits else ())
        assert panel.note == (f"limit {most:g} {unit}" if limits else "")
    scale = 1e3 if "error" in quantity else 1.0
    assert figure.panels[0].curves[-1].y.scale == scale


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


@pytest.fixture(scope="module")
def pressed():
    wall = Wall(ARM, TIP + np.array([0.0, 0.0, 1e-3]), [0.0, 0.0, 1.0], friction=0.4)
    hold = lwr_dyn.reference("hold", ARM, q=POSE, duration=0.05)
    law = lwr_dyn.controller("cartesian-impedance", ARM)
    return lwr_dyn.simulate(ARM, law, hold, external=wall, friction="none", dq0=[0.2, *[0.0] * 6]), wall


def test_curves_are_the_forces_of_the_wall(pressed):
    run, wall = pressed
    pressing, drag = pressing_and_drag(run, wall)
    assert drag.max() > 0.1
    assert (drag <= 0.4 * pressing + 1e-12).all()
    figure = contact_figure([run, run], wall, ["a", "b"])
    assert figure.labels == ("a", "b")
    np.testing.assert_array_equal(figure.panels[0].curves[1].y, pressing)
    np.testing.assert_array_equal(figure.panels[1].curves[0].y, drag)
    assert [curve.colour for curve in figure.panels[0].curves] == [0, 1]


def test_it_is_drawn_with_the_label_of_the_controller(pressed):
    figure = contact_figure(*pressed)
    assert figure.labels == ("Cartesian impedance",)
    assert figure_bytes(figure, "svg").startswith(b"<?xml")


def test_a_run_read_from_a_file_has_its_label_too(pressed, tmp_path):
    run, wall = pressed
    run.save(tmp_path / "x.npz")
    assert contact_figure(lwr_dyn.Run.load(tmp_path / "x.npz"), wall).labels == ("Cartesian impedance",)


def test_bad_input_is_refused(pressed):
    run, wall = pressed
    with pytest.raises(OptionError, match="labels"):
        contact_figure(run, wall, ["a", "b"])
    with pytest.raises(OptionError, match="labels"):
        contact_figure([], wall)
    six = Wall(lwr_dyn.load("kr30ha"), [0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    with pytest.raises(ShapeError):
        contact_figure(run, six)


def test_levels_estimate_and_truth(tmp_path):
    law = lwr_dyn.controller("inverse-dynamics+observer", lwr())
    push = Push(lwr(), (20.0, 0.0, 0.0), start=0.02, duration=0.06)
    run = simulate(lwr(), law, joint_waves(), duration=0.1, external=push)
    run.save(tmp_path / "run.npz")
    for one in (run, Run.load(tmp_path / "run.npz")):
        figure = observer_figure(one, [1, 3])
        assert [panel.title for panel in figure.panels] == ["joint_2", "joint_4"]
        true, estimate = figure.panels[1].curves
        np.testing.assert_array_equal(estimate.y, run.signals["external_torque"][:, 3])
        np.testing.assert_array_equal(true.y, run.signals["tau_external"][:, 3])
        level = law.threshold.level(np.full(7, 50.0), 1e-3)[3]
        assert [edge.value for edge in figure.panels[1].levels] == pytest.approx([level, -level], rel=1e-9)
    assert len(observer_figure(run).panels) == 7


def test_a_run_without_an_observer_is_refused():
    run = simulate(lwr(), lwr_dyn.controller("inverse-dynamics", lwr()), joint_waves(), duration=0.01)
    with pytest.raises(MissingDataError, match="momentum observer"):
        observer_figure(run)
