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


def test_limits_are_those_of_table_iii_in_the_dh_coordinate_and_rotors_those_of_the_formula():
    """The rotor formula 1/2 m r^2 gives the power of ten that the reading `physical` takes."""
    arm = lwr_dyn.load("lwr4plus")
    assert np.degrees(arm.upper) == pytest.approx([170, 120, 170, 120, 170, 120, 170])
    assert (arm.lower == -arm.upper).all()
    assert arm.effort.tolist() == [176, 176, 100, 100, 100, 38, 38]
    assert sum(b.mass for b in arm.chain.bodies) == pytest.approx(14.4462, abs=1e-4)  # Fig. 1, last row
    assert pytest.approx(1.325e-5) == 0.5 * 0.0106 * 0.05**2
    rotors = [lwr_dyn.load("lwr4plus", x).chain.links[0].rotor.inertia for x in ("physical", "computed")]
    assert rotors == [1.325e-5, 1.325e-7]


def test_the_sidecar_calls_the_fitted_cell_fitted():
    sources, printed = (lwr_dyn.load("lwr4plus", x).sources for x in (None, "printed"))
    cells = (sources, "link_5.com"), (sources, "link_6.com"), (printed, "link_5.com")
    assert [[x.kind for x in table[name]] for table, name in cells] == [["fitted"], ["printed"], ["printed"]]
