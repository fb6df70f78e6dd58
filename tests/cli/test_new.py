"""A study and a paper to start from: both run as they stand, and are not written over another file."""

from dataclasses import replace

import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.reproduction.compare import compare_numbers
from lwr_dyn.reproduction.named_results import QUANTITIES
from lwr_dyn.reproduction.own_paper import own_study
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.sweep_study import arm_of_study
from lwr_dyn.studies.sweep.vocabulary import OPTION, PATHS, parameter_path

pytestmark = pytest.mark.usefixtures("folder")


def test_the_study_is_read_as_it_stands(printed):
    out = printed("new", "study", "first.toml")
    assert out == "wrote first.toml; next: edit it, then  lwr-dyn sweep first.toml --out first\n"
    study = read_study("first.toml")
    assert (study.name, study.count, study.chunks, len(study.controllers)) == ("first", 512, 4, 3)
    assert study.limits == {"tip_max": 3e-3, "saturated_s": 0.0}
    assert "lwr-dyn sweep first.toml --out first" in study.text
    assert "@@" not in study.text
    for path in (path for path in PATHS if OPTION not in path):
        assert path in study.text


@pytest.mark.parametrize(
    ("word", "words"),
    [
        ("first.txt", "first.txt: ends in '.txt'; allowed: a path that ends in .toml"),
        ("a b.toml", "a b.toml: a name with other characters"),
        ("there.toml", "there.toml: exists already; allowed: a new file"),
    ],
)
def test_other_files_are_refused(word, words, refused, tmp_path):
    (tmp_path / "there.toml").write_text("", encoding="utf-8")
    assert words in refused("new", "study", word)


@pytest.mark.parametrize("path", [path for path in PATHS if OPTION not in path])
def test_every_path_is_a_path_and_its_nominal_value_is_allowed(path):
    row = parameter_path(path, 7).row
    assert row.words
    assert row.text or row.allows(row.nominal)


def test_paths_know_how_many_numbers_they_have():
    counts = {
        "arm.mass": 7, "arm.mass.all": 1, "arm.mass.7": 1, "arm.com": 21, "arm.com.all": 3, "arm.com.2": 3,
        "arm.com.2.x": 1, "payload.com": 3, "payload.com.z": 1, "payload.mass": 1, "reading": 1,
        "controller.omega-n": 1,
    }  # fmt: skip
    assert {path: len(parameter_path(path, 7).columns(7)) for path in counts} == counts
    assert parameter_path("controller.omega-n", 7).option == "omega_n"


@pytest.mark.parametrize(
    ("joints", "convention"), [("RRRRRR", "standard"), ("RRPR", "modified"), ("P", "standard"), ("RP", "modified")]
)
def test_the_paper_is_reproduced_as_it_stands(joints, convention, printed, folder):
    out = printed("new", "paper", "first.toml", "--joints", joints, "--convention", convention)
    assert out == "wrote first.toml; next: fill it in, then  lwr-dyn reproduce first.toml\n"
    numbers = compare_numbers(own_study("first.toml")).numbers
    assert [n.verdict for n in numbers] == ["reproduced"] * 5
    text = (folder / "first.toml").read_text(encoding="utf-8")
    assert "@@" not in text
    assert "-0.0" not in [n.cell.printed for n in numbers]
    for name in QUANTITIES:
        assert f"  {name} " in text
    run = [line.removeprefix("# ") for line in text[text.index("# [run.move]") :].splitlines()]
    more = [
        "[[result]]",
        'id = "x"',
        'where = ""',
        'printed = "0"',
        'unit = "mm"',
        'compute = "tip_max"',
        'run = "move"',
    ]
    (folder / "first.toml").write_text("\n".join([text, *run, *more]), encoding="utf-8")
    assert "tip_max at run move" in own_study("first.toml").formulas


def test_a_paper_with_odd_joints_is_refused(refused):
    assert "joints: 'RX'; allowed: R or P per joint" in refused("new", "paper", "first.toml", "--joints", "RX")
    assert "'--convention': 'x' is not one of 'standard', 'modified'" in refused(
        "new", "paper", "first.toml", "--convention", "x"
    )


@pytest.mark.parametrize("robot", ["kr30ha", pytest.param("arms/own.urdf", marks=pytest.mark.slow)])
def test_a_study_of_any_robot_names_it_from_where_the_study_stands(printed, folder, robot):
    (folder / "arms").mkdir()
    (folder / "studies").mkdir()
    (folder / "arms" / "own.urdf").write_text(lwr_dyn.urdf_text(lwr_dyn.load("wam7")))
    printed("new", "study", "studies/mine.toml", robot)
    study = read_study("studies/mine.toml")
    assert 'robot = "kr30ha"' in study.text if robot == "kr30ha" else 'robot = "../arms/own.urdf"' in study.text
    assert arm_of_study(study).n == lwr_dyn.load(robot).n


def test_a_robot_that_no_study_reads_or_a_reading_without_one_is_refused(refused, folder):
    assert "no robot named" in refused("new", "study", "x.toml", "kr31")
    assert "--reading: would do nothing here; allowed: with a robot behind FILE" in refused(
        "new", "study", "x.toml", "--reading", "printed"
    )
    assert "--tip: would do nothing here" in refused("new", "study", "x.toml", "--tip", "link_3")
    assert not (folder / "x.toml").exists()


@pytest.mark.slow
def test_a_study_of_a_tree_names_the_tip(printed, folder):
    (folder / "own.urdf").write_text(lwr_dyn.urdf_text(lwr_dyn.load("wam7")))
    printed("new", "study", "mine.toml", "own.urdf", "--tip", "link_4")
    study = read_study("mine.toml")
    assert (study.tip, arm_of_study(study).n) == ("link_4", 4)
    assert replace(study, tip="link_3").digest != study.digest
    (folder / "mine.toml").write_text(study.text.replace('tip = "link_4"', "tip = 4"))
    with pytest.raises(LwrDynError, match="tip: 4; allowed: text"):
        read_study("mine.toml")
