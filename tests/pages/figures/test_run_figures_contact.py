"""The figure of contact: its curves are the wall's forces along the run, one colour a run, drawn without fault."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.pages.figures.run_figures import contact_figure, pressing_and_drag
from lwr_dyn.pages.plotting.plots import figure_bytes
from lwr_dyn.simulation.walls_and_pushes import Wall
from tests.simulation.test_walls_and_pushes import ARM, POSE, TIP


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
