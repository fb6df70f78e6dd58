"""`lwr-dyn compare`: what is typed reaches the study, its comparison is what is shown, files, and bad input."""

from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.design.defaults import usual_task
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.studies.compare.comparison import comparison_html, comparison_of
from lwr_dyn.studies.compare.plants import PLANTS, plant_case
from lwr_dyn.trajectory.references.ist import part_of

SHORT = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.02")
MINE = "def make(arm, dynamics):\n    return lambda t, q, dq, q_ref, dq_ref, ddq_ref: dynamics.gravity_vector(q)\n"
Q = np.radians([0, 30, 0, -60, 0, 30, 0])
NOTHING = "would do nothing here; allowed:"


@pytest.mark.parametrize(
    ("options", "controllers", "plants", "expected"),
    [
        ((), list(CONTROLLERS.names), ["nominal"],
         ("hold", (("rate", 1000.0), ("position_limits", True)), 0.0, None, None, True)),
        (("--controllers", "pid, pid:ki=3+friction", "--plants", "friction,payload=2", "--friction-share", "0.02",
          "--tuned", "1.5", "--rate", "500", "--no-stops", "--twice", "--out", "runs",
          "--jobs", "2"),
         ["pid", "pid:ki=3+friction"], ["friction", "payload=2"],
         ("hold twice", (("rate", 500.0), ("position_limits", False)), 3.02, 1.5, "runs", False)),
    ],
)  # fmt: skip
def test_what_is_typed_reaches_the_study(asked, refused, folder, options, controllers, plants, expected):
    jobs = []

    def run(_, processes):
        jobs.append(processes)
        raise OptionError("stop", "here", "nothing")

    calls = asked("lwr_dyn.cli.compare.ControllerStudy", SimpleNamespace(run=run))
    refused("compare", "lwr4plus", *SHORT, *options)
    (arm, reference, laws, cases, task, fixed, since, peak), given = calls[0]
    where = given["folder"] and str(given["folder"])
    assert jobs == [2 if "--jobs" in options else 1]
    assert (laws, repr(cases)) == (controllers, repr([plant_case(arm, text) for text in plants]))
    assert (task, fixed, pytest.approx(since), peak, where, given["lenient"]) == expected
    own = lwr_dyn.load("lwr4plus")
    own = arm_with_friction(own, 0.02) if "--friction-share" in options else own
    assert repr(arm.friction) == repr(own.friction)
    np.testing.assert_allclose(reference.sample(0.0).q[0], Q)


def test_controllers_and_plants_of_any_arm_and_a_file_of_ones_own(folder, printed, recorded, as_recorded):
    """The runs are written, and files that are compared again are those of the library, page and all."""
    (folder / "mine.py").write_text(MINE)
    arguments = ("--controllers", "pid,mine.py", "--plants", "nominal,friction,payload=3+scale=1.1", "--out", "runs")
    out = printed("compare", "lwr4plus", *SHORT, *arguments)
    assert len(out.splitlines()) >= 3 + 6
    assert "3 kg at the flange" in out
    assert "assumed Coulomb friction, 5 % of the torque limits" in out
    files = sorted(path.name for path in (folder / "runs").iterdir())
    assert files == [f"run_{i}.npz" for i in range(1, 7)]
    runs = [Run.load(f"runs/run_{k}.npz") for k in (1, 3)]
    line = ("compare", "runs/run_1.npz", "runs/run_3.npz")
    for more, labels in ((), None), (("--label", "a", "--label", "b"), ("a", "b")):
        expected = comparison_of(runs, ["run_1.npz", "run_3.npz"], labels)
        assert recorded(*line, *more) == as_recorded(expected.document, lwr_dyn.load("lwr4plus"))
    out = printed(*line, *more, "--html", "x.html")
    assert out.splitlines()[-1] == "wrote x.html"
    assert (folder / "x.html").read_text(encoding="utf-8") == comparison_html(expected)


@pytest.mark.slow
def test_without_a_choice_all_controllers_run_and_json_is_one_object(recorded):
    task = ("--task", "hold", "--from-deg", "0,30,0,60,0,30,0", "--duration", "0.02")
    record = recorded("compare", "wam7", *task)
    assert len(record["runs"]) + len(record["failures"]) == len(CONTROLLERS.names)
    assert len(record["runs"]) > 3
    assert {"tip_rms_mm", "tip_max_mm", "peak_torque", "torque_share", "audit_residual_J"} <= set(record["runs"][0])


def test_one_table_in_markdown_with_friction_that_a_law_knows(printed):
    task = ("--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "5,35,5,-55,5,35,5")
    laws = "inverse-dynamics,inverse-dynamics+friction"
    plants = ("--plants", "friction", "--friction-share", "0.01")
    out = printed("compare", "lwr4plus", *task, "--duration", "0.5", "--controllers", laws, *plants, "--markdown")
    head, _, row = out.splitlines()
    assert head == "| plant | `inverse-dynamics` | `inverse-dynamics+friction` |"
    cells = row.strip("| ").split(" | ")
    assert cells[0] == "friction"
    assert float(cells[1]) > 10.0 * float(cells[2].strip("*"))


def test_twice_compares_the_second_pass(folder, recorded):
    arguments = ("--controllers", "pid:omega-n=30", "--plants", "noise=1e-6", "--twice", "--out", "runs")
    record = recorded("compare", "lwr4plus", *SHORT, *arguments)
    assert (len(record["runs"]), record["title"]) == (1, "lwr4plus, hold twice, 0.02 s from 3.02 s on")
    whole = Run.load("runs/run_1.npz")
    assert whole.t[-1] == pytest.approx(3.04)
    rest = lwr_dyn.compare(part_of(whole, 3.02), part_of(whole, 3.02)).runs[0]
    assert record["runs"][0]["tip_rms_mm"] == rest.figures.tip_rms_mm


def test_a_task_that_is_not_typed_is_said_beside_the_result(asked, lwr_dyn_command, folder):
    asked("lwr_dyn.cli.compare.ControllerStudy", OptionError("stop", "here", "nothing"))
    code, out, err = lwr_dyn_command("compare", "kr30ha")
    assert (code, out, err.splitlines()[0]) == (2, "", usual_task(lwr_dyn.load("kr30ha")).words)


BAD = {
    "nothing": ((), "Missing argument"),
    "a run and a robot": (("lwr4plus", "x.npz"), "run files and a robot; allowed: run files alone, or one robot"),
    "two robots": (("lwr4plus", "wam7"), "compare: 2 robots; allowed: one robot, or run files that end in .npz"),
    "one run": (("run.npz",), "run.npz: no such file"),
    "a plant for files": (
        ("x.npz", "y.npz", "--plants", "friction"),
        f"--plants: {NOTHING} with a robot, not with run",
    ),
    "no stops of files": (("x.npz", "--no-stops"), f"--no-stops: {NOTHING} with a robot, not with run files"),
    "a label for a robot": (("lwr4plus", "--label", "a"), f"--label: {NOTHING} with run files"),
    "no controllers": (("lwr4plus", "--controllers", ""), "--controllers: ''; allowed: names separated by commas"),
    "no plants": (("lwr4plus", "--plants", ","), "--plants: ','; allowed: names separated by commas"),
    "unknown controller": (("lwr4plus", "--controllers", "pdi"), "no controller named 'pdi' (did you mean pid?)"),
    "controller twice": (("lwr4plus", "--controllers", "pid,pid"), "--controllers: pid twice; allowed: each once"),
    "unknown plant": (("lwr4plus", "--plants", "paylod=3"), "no plant named 'paylod' (did you mean payload?)"),
    "no folder": (("lwr4plus", "--html", "none/x.html"), "none/x.html: no directory none"),
    "another ending": (("lwr4plus", "--replay", "x.pdf"), "x.pdf: does not end in .html; allowed: a path that ends in"),
    "no such controller file": (("lwr4plus", "--controllers", "no.py,pid", *SHORT), "no.py: no such file"),
    "no controller in it": (("lwr4plus", "--controllers", "empty.py,pid", *SHORT), "empty.py: no function of six"),
    "an option of another task": (("lwr4plus", *SHORT, "--timing", "smooth"), f"--timing: {NOTHING} with --task ist"),
    "no masses": (("lwr4", *SHORT), "masses and inertias not given"),
}


@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_input_gets_one_line_and_exit_code_2(arguments, message, refused, folder):
    (folder / "empty.py").write_text("x = 1\n")
    assert message in refused("compare", *arguments)
    assert [path.name for path in folder.iterdir()] == ["empty.py"]


def test_runs_of_different_references_are_refused(refused, folder, arm):
    for name, angle in (("a.npz", 30), ("b.npz", 31)):
        hold = lwr_dyn.reference("hold", arm, q=np.radians([0, angle, 0, -60, 0, 30, 0]), duration=0.01)
        lwr_dyn.simulate(arm, lwr_dyn.controller("pd-gravity", arm), hold).save(name)
    err = refused("compare", "a.npz", "b.npz", "--html", "x.html")
    assert "a.npz and b.npz: different references, 0.0175 rad or m apart at t = " in err
    assert not (folder / "x.html").exists()


def test_the_help_names_every_plant(printed):
    out = printed("compare", "--help")
    assert all(name in out for name in (*PLANTS.names, "payload=3", "--controllers", "--task"))


def test_where_one_page_cannot_be_made_none_is_written(folder, refused):
    arguments = ("--controllers", "pid", "--html", "a.html", "--replay", "b.html")
    assert "two runs or more" in refused("compare", "lwr4plus", *SHORT, *arguments)
    assert list(folder.iterdir()) == []


@pytest.mark.slow
def test_an_arm_without_a_task_of_its_own_and_laws_that_its_rate_does_not_hold(lwr_dyn_command):
    code, out, err = lwr_dyn_command("compare", "kr30ha")
    assert (code, "diverges" in out) == (0, False)
    assert "task: point-to-point, chosen for this arm (--task move): (" in err
    assert "kr30ha, move, 2 s" in out
    assert "robust: left out: at 1000 Hz it is unstable at rest at " in out
