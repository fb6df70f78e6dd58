"""The file of a study: what it becomes."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.foundation.fields import Fields
from lwr_dyn.model.chain import JointKind
from lwr_dyn.studies.sweep.read_parameters import has_same_frames
from lwr_dyn.studies.sweep.read_study import missing_option, read_task, study_of_text
from lwr_dyn.studies.sweep.sweep_study import arm_of_study, controller_of_study, references_of_study, task_choices
from tests.studies.sweep.texts import HEAD, PAYLOAD


def test_a_short_study_has_the_usual_for_all_else(read):
    study = read(HEAD + PAYLOAD)
    assert (study.name, study.method, study.runs, study.seed) == ("s", "sobol", 256, 0)
    assert study.loop == {"rate": 1000.0, "substeps": 1, "friction": "none"}
    assert (study.chunk, study.keep, study.cutoff_hz, study.tip, study.assumed_friction) == (500, 3, 100.0, None, None)
    (one,) = study.parameters
    assert (one.path, one.distribution, one.low, one.high, one.kind) == ("payload.mass", "uniform", 0.0, 7.0, "assumed")
    assert (one.unit, one.nominal, one.distribution_words) == ("kg", 0.0, "uniform from 0 to 7")
    np.testing.assert_allclose(study.task_options["q"], np.radians([0, 30, 0, -60, 0, 30, 0]))
    assert arm_of_study(study).reading == "physical"
    (reference,) = references_of_study(study)
    assert reference.duration == 0.5
    assert controller_of_study(study, "robust:omega_n=20").omega_n == 20.0


def test_a_slow_loop_needs_no_cut_off_unless_it_has_encoders(tmp_path):
    slow = HEAD + "[loop]\nrate = 150\n"
    payload, noise = (f'[[parameter]]\npath = "{x}"\nlow = 0\nhigh = 1e-3\n' for x in ("payload.mass", "sensor.noise"))
    assert study_of_text(slow + payload, tmp_path / "slow.toml").loop["rate"] == 150.0
    with pytest.raises(PaperError, match=r"loop: cut-off of the velocity filter: 100.0; allowed: above 0 and below 75"):
        study_of_text(slow + noise, tmp_path / "slow.toml")


def test_each_distribution_is_known_by_its_fields(read):
    tables = {
        "arm.mass.all": "mean = 1\ndeviation = 0.1\nlow = 0.5",
        "arm.com.7.z": "mean = 0\ndeviation = 0.003",
        "loop.delay": "values = [0, 2]",
        "limits.torque": "low = 0.8\nhigh = 1\ncount = 3",
        "payload.mass": "value = 3",
    }
    study = read(HEAD + "".join(f'[[parameter]]\npath = "{path}"\n{rest}\n' for path, rest in tables.items()))
    assert [one.distribution for one in study.parameters] == ["normal", "normal", "choice", "levels", "fixed"]
    assert study.parameters[3].values == pytest.approx((0.8, 0.9, 1.0))
    assert study.columns == (
        "arm.mass.all", "arm.com.7.z", "loop.delay", *(f"limits.torque.{i}" for i in range(1, 8)), "payload.mass",
    )  # fmt: skip
    assert [one.path for one in study.varied] == list(tables)[:4]


EVERY = """
name = "all"
assumed_friction = 0.03
[loop]
rate = 500
substeps = 2
friction = "none"
duration = 0.25
friction_width = 0.03
saturate = false
position_limits = false
hand_over = false
cutoff_hz = 50
"""


def test_every_field_is_what_it_says(read):
    first, loop = EVERY.split("[loop]")
    sampling = '[sampling]\nmethod = "random"\nruns = 9\nseed = 1\nchunk = 7\nkeep = 2\n'
    limits = "[metrics]\ntolerance = 1e-3\nquantiles = [0.5, 0.95]\n[limits]\ntip_q50 = 0\nfirst_violation = 1\n"
    study = read(f"{first}{HEAD}[loop]{loop}{sampling}{limits}{PAYLOAD}kind = 'datasheet'\nnote = 'why'\n")
    assert study.loop == {
        "rate": 500.0, "substeps": 2, "friction": "none", "duration": 0.25, "friction_width": 0.03, "saturate": False,
        "position_limits": False, "hand_over": False,
    }  # fmt: skip
    assert (study.name, study.assumed_friction, study.cutoff_hz) == ("all", 0.03, 50.0)
    assert (study.method, study.runs, study.seed, study.chunk, study.keep) == ("random", 9, 1, 7, 2)
    assert (study.tolerance, study.quantiles, study.limits) == (
        1e-3,
        (0.5, 0.95),
        {"tip_q50": 0.0, "first_violation": 1.0},
    )
    assert (study.parameters[0].kind, study.parameters[0].note) == ("datasheet", "why")


def test_more_than_sixteen_numbers_a_run_are_drawn_by_a_latin_hypercube(read):
    seven = [f'[[parameter]]\npath = "{path}"\nlow = 0.9\nhigh = 1.1\n' for path in ("arm.mass", "arm.inertia")]
    two = [f'[[parameter]]\npath = "{path}"\nlow = 0\nhigh = 1\n' for path in ("payload.mass", "payload.com.x")]
    more = '[[parameter]]\npath = "payload.com.y"\nlow = 0\nhigh = 1\n'
    text = HEAD + "".join([*seven, *two])
    assert [read(one).method for one in (text, text + more)] == ["sobol", "latin-hypercube"]


def test_comments_and_limits_do_not_change_the_digest(read):
    study = read(HEAD + PAYLOAD)
    assert read("# other words\n" + HEAD + PAYLOAD + "[limits]\ntip_max = 1e-3\n").digest == study.digest
    assert read(HEAD + PAYLOAD.replace("7", "6")).digest != study.digest
    assert replace(study, runs=512).runs == 512


def test_a_distance_from_a_limit_may_be_bounded_below_zero(read):
    assert read(HEAD + PAYLOAD + "[limits]\nlimit_margin = -0.1\n").limits == {"limit_margin": -0.1}


def test_a_grid_counts_its_levels_and_tasks_vary_by_choice(read):
    study = read(
        HEAD.replace("duration = 0.5\n", "")
        + '[sampling]\nmethod = "grid"\n[[parameter]]\npath = "payload.mass"\nlow = 0\nhigh = 7\ncount = 8\n'
        + '[[parameter]]\npath = "task.duration"\nvalues = [0.5, 0.25, 1.0]\n'
    )
    assert study.runs == 24
    assert task_choices(study) == [{"duration": 0.5}, {"duration": 0.25}, {"duration": 1.0}]
    assert [reference.duration for reference in references_of_study(study)] == [0.5, 0.25, 1.0]
    values = study.values(0, 24)
    np.testing.assert_array_equal(values["task.duration"], [0.5, 0.25, 1.0] * 8)
    np.testing.assert_allclose(values["payload.mass"], np.arange(8).repeat(3))


OWN = "def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n    return 0 * q\n"


def test_files_stand_beside_the_study_and_count_by_their_content(read, tmp_path):
    (tmp_path / "mine.py").write_text(OWN, encoding="utf-8")
    text = HEAD.replace("robust:omega_n=20", "mine.py") + PAYLOAD
    study = read(text)
    assert list(study.sources) == ["mine.py"]
    assert controller_of_study(study, "mine.py").name == "mine.py"
    (tmp_path / "mine.py").write_text(OWN + "# other\n", encoding="utf-8")
    assert read(text).digest != study.digest


def test_files_of_one_name_in_two_folders_count_both(read, tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(OWN, encoding="utf-8")
    text = HEAD.replace("robust:omega_n=20", 'a/mine.py", "b/mine.py') + PAYLOAD
    before = read(text).digest
    (tmp_path / "a" / "mine.py").write_text(OWN + "# other\n", encoding="utf-8")
    assert read(text).digest != before


def test_assumed_friction_is_in_the_model(read):
    study = read("assumed_friction = 0.02\n" + HEAD.replace("robust:omega_n=20", "pid+friction") + PAYLOAD)
    arm = arm_of_study(study)
    coulomb = [model.positive.coulomb for model in arm.friction_models()]
    np.testing.assert_allclose(coulomb, 0.02 * lwr_dyn.load("lwr4plus").effort)
    assert study.loop["friction"] == "smooth"


def test_nominal_values_are_those_of_the_model(read):
    free = HEAD.replace(":omega_n=20", "").replace("duration = 0.5\n", "")
    paths = (
        "friction.coulomb.all",
        "friction.viscous.1",
        "controller.omega_n",
        "task.duration",
        "loop.delay",
        "arm.mass.2",
    )
    tables = "".join(f'[[parameter]]\npath = "{path}"\nvalues = [1, 2]\n' for path in paths)
    assert [one.nominal for one in read(free + tables).parameters] == [0.0, 0.0, 50.0, 2.0, 0.0, 1.0]
    assumed = read("assumed_friction = 0.02\n" + free + tables)
    assert [one.nominal for one in assumed.parameters[:2]] == [0.02, 0.0]
    wam = free.replace("lwr4plus", "wam7").replace('reading = "physical"', "").replace("-60", "60")
    assert [one.nominal for one in read(wam + tables).parameters[:2]] == [None, None]


LINE = {
    "name": "line", "from-deg": [0, 30, 0, -60, 0, 30, 0], "to-xyz": [0.1, 0.2, 0.3], "to-rpy-deg": [0, 90, 180],
    "turn-speed-deg": 90, "speed": 1,
}  # fmt: skip


def test_degrees_become_radians_and_metres_stay(arm, tmp_path):
    task = read_task(Fields(LINE, "s.toml", "task"), tmp_path, arm)
    assert (task.name, task.files, missing_option(task, set())) == ("line", (), None)
    np.testing.assert_allclose(task.options["start"], np.radians(LINE["from-deg"]))
    np.testing.assert_allclose(task.options["to_rpy"], [0, np.pi / 2, np.pi])
    np.testing.assert_array_equal(task.options["to_xyz"], [0.1, 0.2, 0.3])
    assert (task.options["turn_speed"], task.options["speed"]) == (pytest.approx(np.pi / 2), 1.0)


def test_switches_files_and_what_is_missing(arm, tmp_path):
    task = read_task(Fields({"name": "line", "free-orientation": True}, "s.toml", "task"), tmp_path, arm)
    assert task.options == {"free_orientation": True}
    assert missing_option(task, set()) == "from-deg"
    assert missing_option(task, {"start"}) == "to-xyz"
    (tmp_path / "way.csv").write_text("x,y,z\n", encoding="utf-8")
    task = read_task(Fields({"name": "waypoints", "waypoints": "way.csv"}, "s.toml", "task"), tmp_path, arm)
    assert task.files == (tmp_path / "way.csv",)
    assert task.options == {"waypoints": str(tmp_path / "way.csv")}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"to-xyz": [0.1, 0.2]}, "task.to-xyz: 2 numbers; allowed: a list of 3 numbers"),
        ({"to-xyz": 0.1}, "task.to-xyz: 0.1; allowed: a list of 3 numbers"),
        ({"to-rpy-deg": [0, 90, "x"]}, r"task.to-rpy-deg\[2\]: 'x'; allowed: a number"),
        ({"free-orientation": 1}, "task.free-orientation: 1; allowed: true or false"),
        ({"turn-speed-deg": True}, "task.turn-speed-deg: True; allowed: a number"),
        ({"name": 3}, "task.name: 3; allowed: text"),
    ],
)
def test_other_values_are_refused(change, words, arm, tmp_path):
    with pytest.raises(PaperError, match=words):
        read_task(Fields(LINE | change, "s.toml", "task"), tmp_path, arm)


def test_arms_with_the_same_frames():
    arm, wam = lwr_dyn.load("lwr4plus"), lwr_dyn.load("wam7")
    links = [replace(link, kind=JointKind.PRISMATIC) if i == 2 else link for i, link in enumerate(arm.chain.links)]
    sliding = replace(arm, chain=replace(arm.chain, links=tuple(links)))
    hung = replace(arm, chain=replace(arm.chain, gravity=-arm.chain.gravity))
    assert has_same_frames(arm, lwr_dyn.load("lwr4plus", "physical"))
    assert not any(has_same_frames(arm, other) for other in (wam, sliding, hung, lwr_dyn.load("kr30ha")))
