"""What a notebook shows of results: small, escaped, and with the numbers of the result."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.checks.arm.model_laws import Verdict
from lwr_dyn.checks.arm.run_checks import check_arm
from lwr_dyn.foundation.document import Note
from lwr_dyn.foundation.tables import Table
from lwr_dyn.identification.friction.identify_friction import identify_friction
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.run import short_repr
from lwr_dyn.reproduction.paper_study import Reproduction, study_document
from lwr_dyn.simulation.metrics import metrics

LARGEST = 2200
"""Letters of a result's HTML."""


class Balanced(HTMLParser):
    """Raises `AssertionError` where a tag is not closed in its place; collects the text."""

    def __init__(self):
        super().__init__()
        self.open, self.words = [], []

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def text_of(page: str) -> str:
    parser = Balanced()
    parser.feed(page)
    assert parser.open == []
    return " ".join(parser.words)


@pytest.fixture(scope="module")
def run(arm):
    move = lwr_dyn.reference("point-to-point", arm, start=[0.0] * 7, end=[0.1] * 7, duration=0.3)
    return lwr_dyn.simulate(arm, lwr_dyn.controller("pd-gravity", arm), move)


@pytest.fixture(scope="module")
def friction():
    t = np.linspace(0.0, 4.0, 401)
    logs = [
        JointLog("a", (1,), t, (v * t)[:, None], np.full((401, 1), 2.0 * np.sign(v) + 3.0 * v))
        for v in (0.1, 0.2, 0.3, -0.1, -0.2, -0.3)
    ]
    return identify_friction(logs, subtract="none")


@pytest.fixture(scope="module")
def results(arm, run, friction):
    pose = lwr_dyn.forward_kinematics(arm, [0.1, 0.5, 0.0, -1.0, 0.2, 0.4, 0.0])
    table = Table("Numbers", ("paper", "printed"), (("LWR", "157"),))
    return {
        "Arm": arm,
        "Run": run,
        "Metrics": metrics(run, arm),
        "CheckReport": check_arm(arm),
        "InverseResult": lwr_dyn.inverse_kinematics(arm, pose),
        "FrictionIdentification": friction,
        "Reproduction": Reproduction(True, study_document(Note("text"), table, x=list(range(10000)))),
    }


def test_each_is_one_or_two_kilobytes_of_whole_html_and_a_short_text(results):
    for name, result in results.items():
        page = result._repr_html_()
        assert type(result).__name__ == name
        assert 20 < len(page) < LARGEST, name
        assert text_of(page)
        assert "<script" not in page
        assert len(repr(result).splitlines()) <= 5, name
        assert len(repr(result)) < 560, name


def test_the_numbers_are_those_of_the_result(results, arm, run):
    words = text_of(arm._repr_html_())
    heads = "joint range [deg] speed [deg/s] torque [N m] mass [kg] rotor [kg m^2]"
    assert words.startswith(f"{arm.title}: 7 joints, reading {arm.reading} {heads} joint_1 ")
    assert "joint_2 -120 to 120 110 176 2.778 0.1603" in words
    figures, words = metrics(run, arm), text_of(run._repr_html_())
    assert f"RMS {figures.tip_rms_mm:.6g} mm" in words
    assert "rigid links and joints" in words
    assert f" {figures.peak_torque[1]:.4g} " in words
    friction = text_of(results["FrictionIdentification"]._repr_html_())
    assert "joint way coulomb [N m] viscous [N m s/rad]" in friction
    assert re.search(r"1 \+ 2 \+- \S+ 3 \+- ", friction)
    assert "paper printed LWR 157" in text_of(results["Reproduction"]._repr_html_())
    solutions = results["InverseResult"]
    assert text_of(solutions._repr_html_()).count(", ") >= 6 * len(solutions.solutions)


def test_an_unknown_is_unknown_and_a_sliding_joint_is_said(arm, tmp_path):
    bare = replace(arm, limits=(JointLimits(),) * 7)
    assert text_of(bare._repr_html_()).count("unknown unknown unknown") == 7
    assert "sliding" not in lwr_dyn.load("wam7")._repr_html_()
    (tmp_path / "own.toml").write_text(template("own.toml", "own", "RP"), encoding="utf-8")
    own = lwr_dyn.load(tmp_path / "own.toml")
    words, slide = text_of(own._repr_html_()), own.limits[1]
    assert f"joint_2 0 to 0.5 {slide.velocity:.4g} {slide.effort:.4g} 2 " in words
    assert words.endswith("of a sliding joint in m, m/s, N, kg")


def test_names_from_files_are_escaped(arm, run):
    bad = '<img src=x onerror="alert(1)">&'
    for page in (
        replace(arm, title=bad)._repr_html_(),
        replace(run, setup=None, meta={"robot": bad, "task": bad, "audit": {}})._repr_html_(),
        replace(check_arm(arm), robot=bad, verdicts=(Verdict(bad, 1.0, 2.0, bad),), not_judged=(bad,))._repr_html_(),
    ):
        assert "<img" not in page
        assert "&lt;img" in page
        text_of(page)


def test_a_run_of_a_lost_file_still_shows_itself(run):
    page = replace(run, setup=None, meta={**run.meta, "file": "/none/arm.toml"})._repr_html_()
    assert "no figures: /none/arm.toml" in text_of(page)


def test_failed_checks_come_first_and_long_lists_are_cut(arm):
    good = tuple(Verdict(f"good {i}", 0.0, 1.0, "m") for i in range(30))
    report = replace(check_arm(arm), verdicts=(*good, Verdict("bad", 2.0, 1.0, "m")))
    words = text_of(report._repr_html_())
    assert words.index("bad") < words.index("good 0")
    assert "and 19 more" in words
    assert "1 of 31 checks fails" in words


def test_a_paper_that_does_not_come_out_says_so():
    assert "DIFFER" in Reproduction(False, study_document())._repr_html_()


def test_a_short_text_says_shapes_and_sizes(run):
    assert "array(301, 7)" in short_repr(run.setup.motion)
    assert re.fullmatch(r"Motion\(t=array\(301,\), .*\)", repr(run.setup.motion))
    assert len(repr(run.setup)) < 400


def test_an_empty_run_has_no_figures(run):
    none = np.empty((0, 7))
    empty = replace(
        run, t=none[:, 0], q=none, dq=none, q_ref=none, dq_ref=none, tau_command=none, tau_applied=none,
        tau_friction=none, energy=none[:, 0], work={},
    )  # fmt: skip
    assert "0 s, 0 samples" in empty._repr_html_()
