"""Planted copies are traced, and what copies nothing is not called a copy; all of it in `scripts/soak.py origins`."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.checks.origin.link_numbers import KnownSet, known_set, known_sets, numbers_of_file
from lwr_dyn.checks.origin.tracing import agreeing_digits, significant_digits, trace_origin
from tests.checks.origin.planted import FRAMES, foreign_arm, links_of, planted_copy, urdf_of


def traced(text, path, sets=None):
    path.write_text(text)
    return trace_origin(numbers_of_file(path), sets)


@pytest.mark.parametrize("frames", FRAMES[::2])
def test_a_copy_is_traced_in_any_frame(frames, tmp_path):
    rng = np.random.default_rng(3)
    text = urdf_of(links_of(known_set("panda", "fer").links), rng, frames, (1e3, 1e3), digits=6)
    found = traced(text, tmp_path / "copy.urdf")
    assert found.is_copy
    assert found.known.name == "panda:fer"
    assert len(found.pairs) == 7
    assert [kind.power for kind in found.kinds[:1]] == [3]


def test_a_share_of_the_planted_copies_is_traced(tmp_path):
    sets = known_sets()
    right = 0
    for seed in range(3):
        rng = np.random.default_rng(seed)
        known = sets[rng.integers(len(sets))]
        found = traced(planted_copy(known, rng)[0], tmp_path / "copy.urdf")
        right += found is not None and found.is_copy and found.known.robot == known.robot
    assert right >= 2


def test_an_arm_that_copies_nothing_is_no_copy(tmp_path):
    for seed in range(2):
        found = traced(foreign_arm(np.random.default_rng(seed)), tmp_path / "own.urdf")
        assert found is None or not found.is_copy


def test_the_cells_that_differ_are_named(tmp_path):
    rows = links_of(known_set("panda", "gaz").links)
    name, mass, com, tensor = rows[3]
    rows[3] = (name, mass, com * [1.0, -1.0, 1.0], tensor)
    rows[5] = (rows[5][0], 1.7, *rows[5][2:])
    found = traced(urdf_of(rows, np.random.default_rng(0)), tmp_path / "slip.urdf")
    assert {(x.link, x.cell) for x in found.differences} == {("link_4", "y"), ("link_6", "mass")}


def test_numbers_of_another_robot_are_seen():
    """The tensors of the maker's UR10e are those of its UR10, digit for digit; masses are its own."""
    found = trace_origin(known_set("ur10e", "maker").links)
    kinds = {kind.kind: kind for kind in found.kinds}
    assert found.known.name == "ur10e:maker"
    assert "ur10:maker" in kinds["tensors"].elsewhere
    assert "ur10:maker" not in kinds["masses"].elsewhere


def test_without_sets_and_without_agreement_nothing_is_found():
    links = known_set("panda", "gaz").links
    assert trace_origin(links, []) is None
    other = KnownSet("x", "y", "", *(replace(links, mass=links.mass * np.pi, com=links.com * 7.3 + 1,
                                             tensor=links.tensor * 0.37),) * 2)  # fmt: skip
    found = trace_origin(links, [other])
    assert found is None or not found.is_copy


def test_digits():
    assert significant_digits(np.array([2.0, 0.365, 1e-5])).tolist() == [1.0, 3.0, 1.0]
    assert agreeing_digits(np.array([0.0]), np.array([0.0]), np.array([6.0])).tolist() == [0.0]
