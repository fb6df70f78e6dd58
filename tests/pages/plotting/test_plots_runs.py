"""`lwr_dyn.plot` and `simulate --csv --plot`: pictures that a notebook draws, files written whole or not at all."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.run_figures import QUANTITIES, quantity_named
from lwr_dyn.pages.plotting.plots import plot_writer

PNG = b"\x89PNG\r\n"
SHORT = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")


@pytest.mark.slow
@pytest.mark.parametrize("quantity", [name for name in QUANTITIES if name != "response"])
def test_each_quantity_is_drawn_and_saved(quantity, two_runs, tmp_path):
    picture = lwr_dyn.plot(two_runs[0], quantity)
    assert picture._repr_svg_().startswith("<?xml")
    picture.save(tmp_path / "x.svg")
    assert (tmp_path / "x.svg").read_text() == picture._repr_svg_()
    assert quantity in repr(picture)


@pytest.mark.slow
def test_a_picture_is_png_too_and_a_figure_of_matplotlib(two_runs, tmp_path):
    picture = lwr_dyn.plot(list(two_runs), "tip_error", labels=["late", "early"])
    assert picture._repr_png_().startswith(PNG)
    picture.save(str(tmp_path / "X.PNG"))
    assert (tmp_path / "X.PNG").read_bytes() == picture._repr_png_()
    assert len(picture.figure.axes) == 1
    lines = [line for line in picture.figure.axes[0].lines if len(line.get_xdata()) == two_runs[0].t.size]
    for line, shown in zip(lines, picture.runs, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), 1e3 * shown.tip_error)
    assert "late" in repr(picture)


def test_a_joint_quantity_has_one_panel_a_joint(arm, two_runs):
    (torque,) = lwr_dyn.plot(two_runs, "torque").figures
    assert [panel.title for panel in torque.panels] == list(arm.joint_names)
    assert [panel.note for panel in torque.panels][:2] == ["limit 176 N m"] * 2
    bare = replace(two_runs[0], meta={**two_runs[0].meta, "robot": "wam7", "reading": None})
    assert lwr_dyn.plot(bare, "torque").figures[0].panels[0].note


def test_the_overview_has_the_tip_error_and_every_torque(arm, two_runs):
    (overview,) = lwr_dyn.plot(two_runs, "overview").figures
    assert [panel.title for panel in overview.panels] == ["tip error", *arm.joint_names]
    assert [panel.y_unit for panel in overview.panels] == ["mm", *["N m"] * 7]


def test_quantities_are_found_by_any_spelling():
    assert quantity_named("Velocity-Error") == quantity_named("velocity_error") == "velocity error"


BAD = {
    "unknown quantity": (lambda runs: lwr_dyn.plot(runs, "torqe"), "no quantity named 'torqe' (did you mean torque?)"),
    "no runs": (lambda runs: lwr_dyn.plot([], "torque"), "runs: none; allowed: one or more"),
    "no run": (lambda runs: lwr_dyn.plot(["x.npz"], "torque"), "allowed: runs, as simulate or Run.load give them"),
    "labels": (lambda runs: lwr_dyn.plot(runs, labels=["a"]), "labels: 1 for 2 runs"),
    "unknown ending": (
        lambda runs: lwr_dyn.plot(runs).save("x.bmp"),
        "ends in '.bmp'; allowed: a path that ends in .png",
    ),
    "no folder": (lambda runs: lwr_dyn.plot(runs, "path").save("none/x.png"), "no directory none"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, two_runs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, message = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        call(list(two_runs))
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_simulate_writes_every_picture_and_the_page_that_replay_writes(lwr_dyn_command, tmp_path, monkeypatch, arm):
    monkeypatch.chdir(tmp_path)
    wishes = ("--out", "x.npz", "--csv", "x.csv", "--html", "x.html", "--plot", "torque", "--plot", "tip.svg")
    code, out, err = lwr_dyn_command("simulate", "lwr4plus", *SHORT, *wishes)
    assert code == 0, err
    names = ("x.csv", "x.html", "torque.png", "tip.svg", "x.npz")
    assert out.splitlines()[-5:] == [f"wrote {name}" for name in names]
    assert (tmp_path / "torque.png").read_bytes().startswith(PNG)
    assert "<svg" in (tmp_path / "tip.svg").read_text()
    run, log = Run.load("x.npz"), read_log("x.csv", arm=arm)
    np.testing.assert_array_equal(log.q, run.q)
    np.testing.assert_array_equal(log.tau, run.tau_applied)
    assert lwr_dyn_command("replay", "x.npz", "--html", "y.html")[0] == 0
    assert (tmp_path / "x.html").read_bytes() == (tmp_path / "y.html").read_bytes()


@pytest.mark.slow
def test_a_file_named_after_a_quantity_shows_it_another_the_overview(two_runs, tmp_path):
    for name, quantity in (("tip_error.svg", "tip error"), ("pid.svg", "overview")):
        path = plot_writer(str(tmp_path / name))(two_runs[0])
        assert path.read_text() == lwr_dyn.plot(two_runs[0], quantity)._repr_svg_()


@pytest.mark.parametrize(
    ("wish", "message"),
    [("jerk", "no quantity named 'jerk'; known: overview, tip error"), ("none/x.png", "none/x.png: no directory none")],
)
def test_pictures_that_cannot_be_are_refused_before_the_work(wish, message, lwr_dyn_command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = lwr_dyn_command("simulate", "lwr4plus", *SHORT, "--plot", wish)
    assert (code, out, err.count("\n"), message in err) == (2, "", 1, True)
    assert list(tmp_path.iterdir()) == []


def test_names_of_runs_are_escaped_in_a_picture(two_runs):
    svg = lwr_dyn.plot(two_runs[0], "tip error", labels=["<script>alert(1)</script>"])._repr_svg_()
    assert "<script" not in svg
