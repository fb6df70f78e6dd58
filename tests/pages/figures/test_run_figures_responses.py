"""Responses as figures and in words, and what `simulate` prints of them."""

import json
import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.pages.figures.figure import Level
from lwr_dyn.simulation.step_and_chirp import response_parts, responses_of
from tests.json_schemas import faults
from tests.simulation.answers import ARM, answered

POSE = ("--from-deg", "0,30,0,-70,0,35,0")


@pytest.fixture(scope="module")
def step():
    return answered("step", 0.5, 2, duration=0.2)


@pytest.fixture(scope="module")
def chirp():
    return answered("chirp", 0.5, 2, low=2.0, high=30.0, duration=1.5)


def test_a_step_is_drawn_as_a_share_of_it(step):
    (figure,) = lwr_dyn.plot(step, "response").figures
    (panel,) = figure.panels
    (response,) = responses_of(step, ARM)
    rise, over = 1e3 * response.rise, 100.0 * response.overshoot
    assert (panel.title, panel.note) == ("joint 2", f"rise {rise:.3g} ms, overshoot {over:.2g} %")
    assert over == pytest.approx(16.3, abs=0.05)
    np.testing.assert_array_equal(panel.curves[0].x, 1e3 * response.t)
    np.testing.assert_array_equal(panel.curves[0].y, response.y)
    assert float(panel.curves[0].y[-1]) == pytest.approx(1.0, abs=0.02)
    assert (panel.levels, figure.x_unit, figure.columns) == ((Level("asked for", 1.0),), "ms", 2)
    (two,) = lwr_dyn.plot([step, step], "response", labels=["a", "b"]).figures
    assert ([curve.colour for curve in two.panels[0].curves], two.panels[0].note) == ([0, 1], "")


def test_a_chirp_is_drawn_as_magnitude_and_phase(chirp):
    picture = lwr_dyn.plot([chirp, chirp], "response", labels=["a", "b"])
    magnitude, phase = picture.figures[0].panels
    assert [curve.label for curve in magnitude.curves] == ["a", "b"]
    (response,) = responses_of(chirp, ARM)
    np.testing.assert_allclose(magnitude.curves[1].y, 20 * np.log10(np.abs(response.H)))
    np.testing.assert_allclose(phase.curves[1].y, np.degrees(np.unwrap(np.angle(response.H))))
    for panel in (magnitude, phase):
        np.testing.assert_array_equal(panel.curves[1].x, response.f)
    (alone, _) = lwr_dyn.plot(chirp, "response").figures[0].panels
    assert (magnitude.note, alone.note) == ("", f"bandwidth {response.bandwidth:.3g} Hz")
    assert magnitude.curves[0].y.max() == pytest.approx(20.0 * math.log10(2.0 / math.sqrt(3.0)), abs=0.02)
    assert magnitude.levels[0].value == pytest.approx(20.0 * math.log10(math.sqrt(0.5)))
    assert phase.curves[0].y.min() < -90.0
    assert picture.figure.axes[0].get_xscale() == "log"


@pytest.mark.slow
def test_other_runs_have_no_response_to_draw(two_runs, step, chirp):
    for runs in (two_runs[0], [step, chirp], [step, two_runs[0]]):
        with pytest.raises(OptionError, match="not all of the task step"):
            lwr_dyn.plot(runs, "response")


@pytest.mark.slow
def test_words(step, chirp, two_runs):
    assert "16.3" in response_parts(step, ARM)[1].text()
    assert "bandwidth [Hz]" in response_parts(chirp, ARM)[1].text()
    assert response_parts(two_runs[0])[1:] == []


@pytest.mark.slow
def test_simulate_prints_the_response(lwr_dyn_command):
    arguments = ("simulate", "lwr4plus", "--task", "step", *POSE, "--joint", "2", "--duration", "0.3")
    code, out, _ = lwr_dyn_command(*arguments)
    assert code == 0
    assert "response to the step: rise 10 to 90 %" in out
    code, out, _ = lwr_dyn_command(*arguments, "--json")
    record = json.loads(out)
    assert not faults("simulate", record)
    assert record["responses"][0]["joint"] == 2
    code, _, err = lwr_dyn_command("simulate", "lwr4plus", "--task", "step", *POSE, "--joint", "9")
    assert code == 2
    assert err.count("\n") == 1
