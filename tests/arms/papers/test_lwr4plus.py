"""The LWR 4+ data file: what its readings claim, recomputed."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.model.spatial import principal_moments


def test_with_the_printed_signs_kept_link_5_could_not_exist():
    paper = open_paper("lwr4plus", "physical")
    assert paper.inertia_products == ("tensor", *["integral"] * 4, *["tensor"] * 2)
    tensor, mass, c = (paper.columns[f"inertial.{x}"].si()[4] for x in ("inertia", "mass", "com"))
    kept = tensor - mass * (c @ c * np.eye(3) - np.outer(c, c))
    assert principal_moments(kept)[0] == pytest.approx(-4.6e-4, abs=1e-5)


def test_limits_are_those_of_table_iii_in_the_dh_coordinate():
    arm = lwr_dyn.load("lwr4plus")
    assert np.degrees(arm.lower) == pytest.approx([-170, -120, -170, -120, -170, -120, -170])
    assert np.degrees(arm.upper) == pytest.approx([170, 120, 170, 120, 170, 120, 170])
    assert arm.effort.tolist() == [176, 176, 100, 100, 100, 38, 38]
    assert arm.chain.bodies is not None
    assert sum(b.mass for b in arm.chain.bodies) == pytest.approx(14.4462, abs=1e-4)  # Fig. 1, last row


def test_the_rotor_formula_gives_the_power_of_ten_that_physical_takes():
    assert pytest.approx(1.325e-5) == 0.5 * 0.0106 * 0.05**2
    assert lwr_dyn.load("lwr4plus", "physical").chain.links[0].rotor.inertia == 1.325e-5
    assert lwr_dyn.load("lwr4plus", "computed").chain.links[0].rotor.inertia == 1.325e-7


def test_the_sidecar_calls_the_fitted_cell_fitted():
    sources = lwr_dyn.load("lwr4plus").sources
    assert [x.kind for x in sources["link_5.com"]] == ["fitted"]
    assert [x.kind for x in sources["link_6.com"]] == ["printed"]
    assert [x.kind for x in lwr_dyn.load("lwr4plus", "printed").sources["link_5.com"]] == ["printed"]
