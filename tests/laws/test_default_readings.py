"""The default reading of every paper is the arm most likely."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper, open_readings, studied
from lwr_dyn.arms.papers.schema import SEVERITIES

PAPERS = [paper for robot in studied() for paper in open_readings(robot)]


@pytest.mark.parametrize("robot", studied())
def test_no_default_leaves_a_proven_error_of_the_model_in_place(robot):
    paper = open_paper(robot)
    assert paper.left_in_place() == () == lwr_dyn.load(robot).caveats.left_in_place
    proven = {e.id for e in paper.errata if e.status == "proven" and e.severity == "model" and e.of_tables()}
    assert proven <= set(paper.reading.errata)


@pytest.mark.parametrize("robot", studied())
def test_what_a_default_applies_is_proven_or_named_as_likely(robot):
    paper, arm = open_paper(robot), lwr_dyn.load(robot)
    unproven = [e.id for e in paper.errata if e.id in paper.reading.errata and e.status != "proven"]
    assert list(arm.caveats.likely) == unproven
    text = lwr_dyn.urdf_text(arm)
    for name in unproven:
        assert f"{name} (likely)" in text


@pytest.mark.parametrize("paper", PAPERS, ids=lambda paper: f"{paper.name}-{paper.reading.name}")
def test_a_reading_names_exactly_the_proven_errors_that_it_leaves(paper):
    left = [e for e in paper.errata if e.id not in paper.reading.errata and e.status == "proven" and e.of_tables()]
    arm = lwr_dyn.load(paper.name, paper.reading.name)
    assert arm.caveats.left_in_place == tuple(e.id for e in left if e.severity == "model")
    assert bool(arm.caveat(used=())) == bool(arm.caveats.left_in_place)


def test_every_erratum_has_a_weight_and_what_changes_no_number_and_no_law_is_a_slip_of_typing():
    errata = [erratum for paper in PAPERS for erratum in paper.errata]
    assert {e.severity for e in errata} <= set(SEVERITIES)
    assert {e.severity for e in errata if e.effect.startswith("none")} == {"text"}


def test_the_lwr_has_its_own_rotors_by_default():
    arm = lwr_dyn.load("lwr4plus")
    assert arm.reading == "physical"
    assert [link.rotor.inertia for link in arm.chain.links] == [1.325e-5] * 7
    mass = lwr_dyn.dynamics_of(arm).mass_matrix(np.zeros(7))
    assert round(float(mass[6, 6]), 3) == 0.160
