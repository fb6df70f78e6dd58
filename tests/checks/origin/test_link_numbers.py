"""Numbers of links: a file's as written, and those of the published sets."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.checks.origin.link_numbers import known_set, known_sets, numbers_of_file
from lwr_dyn.foundation.errors import MissingDataError


def test_every_reading_with_masses_is_a_known_set():
    found = {one.name for one in known_sets()}
    assert found <= {f"{robot}:{reading}" for robot in robots() for reading in readings(robot)}
    assert {"panda:gaz", "panda:fer", "ur10:maker", "ur10e:maker"} <= found
    assert not any("lwr4:" in x for x in found)


def test_a_urdf_has_the_numbers_of_its_arm(tmp_path):
    path = tmp_path / "panda.urdf"
    path.write_text(lwr_dyn.urdf_text(lwr_dyn.load("panda", "fer")))
    read, known = numbers_of_file(path), known_set("panda", "fer").links
    assert read.names == known.names
    np.testing.assert_allclose(read.com, known.com, atol=1e-12)
    np.testing.assert_allclose(read.tensor, known.tensor, atol=1e-12)


def test_a_file_without_masses_is_refused(tmp_path):
    path = tmp_path / "bare.urdf"
    path.write_text('<robot name="bare"><link name="a"/></robot>')
    with pytest.raises(MissingDataError, match="masses and inertias"):
        numbers_of_file(path)
