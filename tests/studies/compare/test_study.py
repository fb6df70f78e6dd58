"""A study has the same runs in one process and in several; what fails is a line; what shakes is not ranked."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError, MissingDataError, OptionError
from lwr_dyn.studies.compare.compared_run import torque_cuts
from lwr_dyn.studies.compare.comparison import comparison_of
from lwr_dyn.studies.compare.plants import plant_case
from lwr_dyn.studies.compare.study import ControllerStudy, Workshop, begin, option_words, run_in_pool
from tests.studies.compare.conftest import POSE

LIMIT_CYCLE = (
    "def make(arm, dynamics):\n"
    "    return lambda t, q, dq, q_ref, *_: dynamics.gravity_vector(q) + 1e5 * (q_ref - q) - 300.0 * dq + 0.1\n"
)


@pytest.fixture(scope="module")
def arm():
    """As its authors computed it, with rotors too light for the wrist."""
    return lwr_dyn.load("lwr4plus", "computed")


@pytest.fixture(scope="module")
def move(arm):
    return lwr_dyn.reference("point-to-point", arm, start=POSE, end=POSE + 0.05, duration=0.3)


def study(arm, move, *controllers, plants=("nominal",), **more):
    return ControllerStudy(arm, move, controllers, [plant_case(arm, text) for text in plants], "move", **more)


@pytest.mark.slow
def test_processes_change_nothing(arm, move, tmp_path):
    plants = ("payload=20+noise=1e-5", "delay=3")
    chosen = study(arm, move, "inverse-dynamics:omega-n=20", "pid", plants=plants, since=0.1, folder=tmp_path)
    alone, runs = chosen.run()
    saved = [lwr_dyn.Run.load(tmp_path / f"run_{i}.npz").q for i in (1, 2, 3, 4)]
    pooled, others = chosen.run(processes=2)
    assert alone.record() == pooled.record()
    assert all(np.array_equal(a.q, b.q) for a, b in zip(runs, others, strict=True))
    assert all(np.array_equal(lwr_dyn.Run.load(tmp_path / f"run_{i + 1}.npz").q, q) for i, q in enumerate(saved))
    assert np.array_equal(saved[0][100:], runs[0].q)
    assert alone.title.endswith("0.2 s from 0.1 s on")
    assert alone.runs[0].controller == "inverse dynamics with feed-forward, omega_n 20"


def test_a_fault_in_a_file_ends_a_study_in_any_process(arm, move, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n    return 1 / 0\n")
    chosen = study(arm, move, "pid", str(file))
    with pytest.raises(LwrDynError, match=r"mine.py: line 2: ZeroDivisionError"):
        chosen.run()
    begin(chosen)
    fault, warned = pickle.loads(pickle.dumps(run_in_pool(1)))
    assert (fault.stops, warned) == (True, ())
    assert str(fault.error()) == fault.text
    assert "mine.py: line 2: ZeroDivisionError" in fault.text


def test_a_warning_of_another_process_is_passed_on():
    arm = lwr_dyn.load("kr30ha")
    hold = lwr_dyn.reference("hold", arm, q=[0.1] * 6, duration=0.01)
    begin(ControllerStudy(arm, hold, ["inverse-dynamics"], [plant_case(arm, "payload=40")]))
    _, warned = pickle.loads(pickle.dumps(run_in_pool(0)))
    assert [words.endswith("a payload of 40 kg is over the rated 30 kg") for words in warned] == [True]


def test_what_a_plant_refuses_is_a_line_and_the_others_go_on(arm, move):
    refused = plant_case(arm, "nominal").changed("refused", delay=-1)
    chosen = replace(study(arm, move, "pid"), plants=[refused, plant_case(arm, "nominal")])
    compared, _ = chosen.run()
    assert [one.plant for one in compared.runs] == ["as modelled"]
    assert compared.failures[0].startswith("PID + gravity, damping on dq, refused: delay: -1; allowed: ")
    with pytest.raises(LwrDynError, match="delay: -1"):
        replace(chosen, plants=[refused]).run()


def test_a_study_with_one_pair_is_a_table_with_one_row(arm, move):
    compared, runs = study(arm, move, "pid").run()
    assert (len(compared.runs), len(runs), len(compared.table.rows)) == (1, 1, 1)
    assert " *" not in compared.table.text()


@pytest.mark.slow
def test_a_large_study_keeps_fewer_samples_and_the_figures_of_all(arm, move, monkeypatch):
    monkeypatch.setattr("lwr_dyn.studies.compare.study.MANY", 2)
    few, kept = study(arm, move, "pid", "inverse-dynamics").run()
    monkeypatch.setattr("lwr_dyn.studies.compare.study.MANY", 3)
    all_of_them, runs = study(arm, move, "pid", "inverse-dynamics").run()
    assert (kept[0].t.size, runs[0].t.size) == (31, 301)
    assert few.record() == all_of_them.record()


def test_runs_go_plant_by_plant_with_their_share_and_their_files(arm, move, tmp_path):
    said, laws, plants = [], ("pid", "inverse-dynamics:omega-n=20"), ("delay=1", "payload=1+scale=1.1")
    short = replace(study(arm, move, *laws, plants=plants, folder=tmp_path), options=(("duration", 0.01),))
    compared, runs = short.run(said.append)
    assert said == [0.25, 0.5, 0.75, 1.0]
    words = ("delay of 1 sample", "masses times 1.1, 1 kg at the flange")
    assert [(one.typed, one.plant) for one in compared.runs] == [(law, plant) for plant in words for law in laws]
    notes = [run.meta["note"] for run in runs]
    assert notes[1] == {"task": "move", "plant": words[0], "controller_options": "omega_n 20", "typed": laws[1]}
    assert notes[2] == {"task": "move", "plant": "masses times 1.1", "typed": "pid"}
    for k, run in enumerate(runs, 1):
        np.testing.assert_array_equal(lwr_dyn.Run.load(tmp_path / f"run_{k}.npz").q, run.q)
    assert option_words({"a": 1.23456, "b": True, "c": "x", "d": 3}) == "a 1.23, d 3, c x"
    assert [replace(short, controllers=("pid",) * n).rate for n in (11, 12)] == [None, 100.0]


def test_each_controller_is_made_once(arm, move):
    workshop = Workshop(study(arm, move, "pid", plants=("nominal", "payload=1")))
    workshop.run(0)
    made = dict(workshop.made)
    workshop.run(1)
    assert workshop.made == made


@pytest.mark.slow
def test_a_law_that_the_arm_does_not_feed_is_left_out_only_where_all_are_asked_for():
    wam = lwr_dyn.load("wam7")
    hold = lwr_dyn.reference("hold", wam, q=[0.1] * 7, duration=0.02)
    chosen = ControllerStudy(wam, hold, ["pid", "motor-pd"], [plant_case(wam, "nominal")], lenient=True)
    compared, _ = chosen.run()
    assert compared.failures == ("motor-pd: wam7: joint stiffness not given; needed for elastic joints",)
    with pytest.raises(LwrDynError, match="joint stiffness"):
        replace(chosen, lenient=False).run()
    with pytest.raises(MissingDataError, match=r"^wam7: joint stiffness not given; needed for elastic joints$"):
        replace(chosen, controllers=["motor-pd"]).run()
    with pytest.raises(OptionError, match=r"none holds here; allowed: .*hand-guiding: left out: it follows"):
        replace(chosen, controllers=["hand-guiding"]).run()


@pytest.mark.parametrize("processes", [0, -1, 1000])
def test_a_number_of_processes_outside_what_is_allowed_is_refused(processes, arm, move):
    with pytest.raises(LwrDynError, match=rf"processes: {processes}; allowed: from 1 to 64"):
        study(arm, move, "pid").run(processes=processes)


def test_a_bounded_unstable_loop_is_marked_and_not_ranked(arm, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(LIMIT_CYCLE)
    hold = lwr_dyn.reference("hold", arm, q=POSE, duration=0.5)
    compared, runs = study(arm, hold, str(file), "pid").run()
    shaking, still = compared.runs
    assert np.isfinite(runs[0].q).all()
    assert shaking.shakes
    assert shaking.cuts.switches > 100
    assert not still.shakes
    assert [compared.mark(one, "tip_rms_mm") for one in compared.runs] == ["bad", "best"]
    assert any("unstable, bounded by the torque limits alone: cut in " in note for note in compared.notes)
    records = compared.record()["runs"]
    assert [record["unstable"] for record in records] == [True, False]
    assert records[0]["best"] == []


def test_a_motion_that_is_cut_on_one_side_at_a_time_is_no_shaking(arm):
    fast = lwr_dyn.reference("point-to-point", arm, start=POSE, end=POSE + 1.0, duration=0.2)
    _, (run,) = study(arm, fast, "inverse-dynamics").run()
    cuts = torque_cuts(run, arm)
    assert cuts.share > 0.02
    assert not cuts.shakes


def test_a_loop_that_only_sampling_makes_unstable_is_found(arm):
    upright = lwr_dyn.reference("point-to-point", arm, start=[0.0] * 7, end=[0.05] * 7, duration=0.3)
    compared, _ = study(arm, upright, "pd-gravity", "inverse-dynamics").run()
    assert [one.shakes for one in compared.runs] == [True, False]


def test_names_of_runs_are_counted_from_their_own(arm, move):
    compared, runs = study(arm, move, "pid", "pid:omega-n=30").run()
    assert [one.controller for one in compared.runs][1].endswith("omega_n 30")
    assert comparison_of(runs, ["a", "b"]).record() == compared.record()
