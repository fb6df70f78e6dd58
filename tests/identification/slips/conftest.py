"""The study of planted slips, on the physical reading of the LWR 4+."""

import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from tests.identification.slip_study import SlipStudy


@pytest.fixture(scope="module")
def study() -> SlipStudy:
    return SlipStudy.of(lwr_dyn.load("lwr4plus", "physical"), open_paper("lwr4plus", "physical"))
