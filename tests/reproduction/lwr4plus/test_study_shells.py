"""Links 1 to 4 of the LWR 4+ are shells of two mirror-image forms: only one reading shows it."""

import pytest

import lwr_dyn
from lwr_dyn.reproduction.lwr4plus.worst_cases import shell_asymmetry


def test_principal_moments_of_the_mirror_image_shells_agree_within_0_6_percent():
    assert shell_asymmetry(lwr_dyn.load("lwr4plus", "physical")) < 0.006


@pytest.mark.parametrize("reading", ["printed", "computed"])
def test_no_other_reading_shows_that_symmetry(reading):
    assert shell_asymmetry(lwr_dyn.load("lwr4plus", reading)) > 0.01
