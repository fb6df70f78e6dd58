"""Planted copies are traced, and what copies nothing is not called a copy; all of it in `scripts/soak.py origins`."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.checks.origin.link_numbers import KnownSet, known_set, known_sets, numbers_of_file
from lwr_dyn.checks.origin.origin_document import origin_document
from lwr_dyn.checks.origin.tracing import agreeing_digits, significant_digits, trace_origin
from lwr_dyn.foundation.errors import MissingDataError
from tests.checks.origin.planted import FRAMES, foreign_arm, links_of, planted_copy, urdf_of


def traced(text, path, sets=None):
    path.write_text(text)
    return trace_origin(numbers_of_file(path), sets)


@pytest.mark.parametrize("frames", FRAMES[::2])
def test_a_copy_is_traced_in_any_frame(frames, tmp_path):
    text = urdf_of(links_of(known_set("panda", "fer").links), np.random.default_rng(3), frames, (1e3, 1e3), digits=6)
    found = traced(text, tmp_path / "copy.urdf")
    assert (found.is_copy, found.known.name, len(found.pairs), found.kinds[0].power) == (True, "panda:fer", 7, 3)


def test_a_share_of_the_planted_copies_is_traced_and_an_arm_that_copies_nothing_is_no_copy(tmp_path):
    sets, right = known_sets(), 0
    for seed in range(3):
        rng = np.random.default_rng(seed)
        known = sets[rng.integers(len(sets))]
        found = traced(planted_copy(known, rng)[0], tmp_path / "copy.urdf")
        right += found is not None and found.is_copy and found.known.robot == known.robot
    assert right >= 2
    for seed in range(2):
        found = traced(foreign_arm(np.random.default_rng(seed)), tmp_path / "own.urdf")
        assert found is None or not found.is_copy


def test_the_cells_that_differ_are_named_and_links_of_its_own(tmp_path):
    rows = links_of(known_set("panda", "gaz").links)
    name, mass, com, tensor = rows[3]
    rows[3] = (name, mass, com * [1.0, -1.0, 1.0], tensor)
    rows[5] = (rows[5][0], 1.7, *rows[5][2:])
    path = tmp_path / "slip.urdf"
    found = traced(urdf_of([*rows, ("hand", 0.7, com * np.pi, 3.3 * tensor)], np.random.default_rng(0)), path)
    assert {(x.link, x.cell) for x in found.differences} == {("link_4", "y"), ("link_6", "mass")}
    text = origin_document("a.urdf", numbers_of_file(path), found).text()
    assert "Not of that set: hand." in text
    assert "link_6 mass 1.7 1.66656" in " ".join(text.split())


def test_numbers_of_another_robot_are_seen_and_said():
    """The tensors of the maker's UR10e are those of its UR10, digit for digit; masses are its own."""
    links = known_set("ur10e", "maker").links
    found = trace_origin(links)
    elsewhere = {kind.kind: kind.elsewhere for kind in found.kinds}
    assert (found.known.name, "ur10:maker" in elsewhere["tensors"]) == ("ur10e:maker", True)
    assert "ur10:maker" not in elsewhere["masses"]
    document = origin_document("a.urdf", links, found)
    record = document.record()
    assert document.verdict == (
        f"a.urdf: numbers of ur10e:maker, {found.known.about}; 6 links agree, {found.digits:.0f} digits"
    )
    assert ("ur10:maker" in document.text(), record["origin"], len(record["links"])) == (True, "ur10e:maker", 6)
    none = origin_document("a.urdf", links, None)
    assert (none.verdict, none.record()["origin"]) == ("a.urdf: the numbers of no published set here", None)
    few = replace(found, digits=1.0)
    assert origin_document("a.urdf", links, few).verdict == (
        "a.urdf: the numbers of no published set here (nearest: ur10e:maker, 1.0 digits, less than a copy has)"
    )


def test_without_sets_and_without_agreement_nothing_is_found():
    links = known_set("panda", "gaz").links
    assert trace_origin(links, []) is None
    other = replace(links, mass=links.mass * np.pi, com=links.com * 7.3 + 1, tensor=links.tensor * 0.37)
    found = trace_origin(links, [KnownSet("x", "y", "", other, other)])
    assert found is None or not found.is_copy


def test_digits():
    assert significant_digits(np.array([2.0, 0.365, 1e-5])).tolist() == [1.0, 3.0, 1.0]
    ours, theirs, known = np.array(
        [[0.0, 2.0, 0.3, 1.0, 1.0], [0.0, 2.0, 0.3003, 1.1, -1.0], [6.0, 1.0, 6.0, 2.0, 6.0]]
    )
    assert agreeing_digits(ours, theirs, known) == pytest.approx([0.0, 1.0, 3.0004, 0.0, 0.0], abs=1e-3)


def test_every_reading_with_masses_is_a_known_set_and_a_urdf_has_the_numbers_of_its_arm(tmp_path):
    names = {one.name for one in known_sets()}
    assert names <= {f"{robot}:{reading}" for robot in robots() for reading in readings(robot)}
    assert {"panda:gaz", "panda:fer", "ur10:maker", "ur10e:maker"} <= names
    assert not any("lwr4:" in x for x in names)
    path = tmp_path / "panda.urdf"
    path.write_text(lwr_dyn.urdf_text(lwr_dyn.load("panda", "fer")))
    read, known = numbers_of_file(path), known_set("panda", "fer").links
    assert read.names == known.names
    np.testing.assert_allclose(read.com, known.com, atol=1e-12)
    np.testing.assert_allclose(read.tensor, known.tensor, atol=1e-12)
    path.write_text('<robot name="bare"><link name="a"/></robot>')
    with pytest.raises(MissingDataError, match="masses and inertias"):
        numbers_of_file(path)
