"""Planted copies are traced, and what copies nothing is not called a copy; all of it in `scripts/soak.py origins`."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.checks.origin.link_numbers import KnownSet, LinkNumbers, known_set, known_sets, numbers_of_file
from lwr_dyn.checks.origin.origin_document import origin_document
from lwr_dyn.checks.origin.tracing import agreeing_digits, significant_digits, trace_origin
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.spatial import from_rpy
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
    ours, theirs, known = np.array([
        [0.0, 2.0, 0.3, 1.0, 1.0, 1000.0, 1000.0, 5.0], [0.0, 2.0, 0.3003, 1.1, -1.0, 995.0, 994.9, 5.0],
        [6.0, 1.0, 6.0, 2.0, 6.0, 6.0, 6.0, 8.0],
    ])  # fmt: skip
    found = agreeing_digits(ours, theirs, known)
    assert found == pytest.approx([0.0, 1.0, 3.0004, 0.0, 0.0, 3.0 - np.log10(5.0), 0.0, 6.0], abs=1e-3)


MASS, COM = np.array([1.234, 7.0]), np.array([[0.0123, 0.0345, 0.0567], [0.1312, 0.0, -0.2713]])
TENSOR = np.array(
    [np.diag([0.011, 0.011, 0.023]), [[0.31012, 0.01123, 0], [0.01123, 0.42031, -0.02131], [0, -0.02131, 0.57093]]]
)
TURN = from_rpy([0.3, -0.7, 1.1])


def small_set(name="x", mass=MASS, com=COM, tensor=TENSOR):
    links = LinkNumbers(tuple("abcdef"[: len(mass)]), mass, com, tensor)
    return KnownSet(name, "y", "", links, links)


@pytest.mark.parametrize(
    ("kind", "changed", "how", "power", "digits"),
    [  # links have 4 and 1 digits of mass, 9 and 8 of the centre, 4 and 23 of the tensor: equal numbers count once
        ("masses", {}, "as written", 0, 4 + 1),
        ("masses", {"mass": 1e9 * MASS}, "as written", 9, 4 + 1),
        ("masses", {"mass": 1e-9 * MASS}, "as written", -9, 4 + 1),
        ("centres", {"com": 1e3 * COM}, "as written", 3, 9 + 8),
        ("centres", {"com": -COM[:, [2, 0, 1]]}, "axes exchanged", 0, 9 + 8 - 2 * 1.5),
        ("centres", {"com": COM @ TURN.T}, "frame turned", 0, 2 * 6 - 2 * 1.0),
        ("tensors", {"tensor": TENSOR * [[1, -1, 1], [-1, 1, -1], [1, -1, 1]]}, "signs changed", 0, 4 + 23 - 2 * 1.0),
        ("tensors", {"tensor": TENSOR[:, [2, 0, 1]][:, :, [2, 0, 1]]}, "axes exchanged", 0, 4 + 23 - 2 * 1.5),
        ("tensors", {"tensor": TURN @ TENSOR @ TURN.T}, "frame turned", 0, 4 + 3 * 6 - 2 * 1.0),
    ],
)
def test_a_kind_counts_the_digits_that_agree_less_the_freedom_of_its_form(kind, changed, how, power, digits):
    found = trace_origin(small_set(**changed).links, [small_set()])
    rest = {"masses": 5, "centres": 17, "tensors": 27} | {kind: digits}
    assert [(x.kind, x.agree, round(x.digits, 6)) for x in found.kinds] == [(x, 2, y) for x, y in rest.items()]
    assert {x.kind: (x.how, x.power) for x in found.kinds if x.kind == kind} == {kind: (how, power)}
    assert (found.pairs, found.differences) == (((0, 0), (1, 1)), ())
    assert found.digits == pytest.approx(sum(rest.values()) - 2 * 3.0)


@pytest.mark.parametrize(("mass", "power", "digits"), [(1000.0, 0, 0), (1200.0, 3, 2)])
def test_a_power_of_ten_needs_more_than_a_digit(mass, power, digits):
    known = small_set(mass=np.array([mass / 1e3, 4.44]))
    found = trace_origin(small_set(mass=np.array([mass, 7.77])).links, [known]).kinds[0]
    assert (found.power, found.digits, found.agree) == (power, digits, digits // 2)


def test_links_are_paired_in_order_and_cells_named_in_units_of_the_set():
    """Both have a link of their own; lengths of the file are in mm; two cells are beyond rounding, two within it."""
    rows, others = [0, 0, 1], [1, 0, 1, 0]
    com = np.array([COM[0], [9.9, 8.8, 7.7], COM[1]]) * 1e3
    com[0, 1], com[2, 1], com[2, 2] = 70.0, 1e-10, -271.3001
    mass = np.array([MASS[0] * (1 + 2e-6), 3.3, MASS[1]])
    file = small_set(mass=mass, com=com, tensor=TENSOR[rows] * np.array([1, 7.7, 1])[:, None, None]).links
    known = small_set(
        mass=np.array([5.55, *MASS, 8.8]),
        com=np.array([[6.6, 5.5, 4.4], *COM, [3.1, 2.1, 1.1]]),
        tensor=TENSOR[others] * 1.0,
    )
    known.links.tensor.flags.writeable = True
    known.links.tensor[[0, 3]] *= 0.3
    found = trace_origin(file, [known])
    assert found.pairs == ((0, 1), (2, 2))
    assert [(x.link, x.cell, x.file, x.published) for x in found.differences] == [
        ("a", "mass", pytest.approx(1.234 * (1 + 2e-6), rel=1e-12), 1.234), ("a", "y", pytest.approx(0.07), 0.0345),
    ]  # fmt: skip


def test_other_sets_with_nearly_the_same_numbers_are_named():
    """Of 20 digits of masses another set may lack one; of fewer than 8 nothing is said."""
    mass = np.array([1.23456, 2.34567, 3.4567, 4.567, 5.0])
    com, tensor = np.arange(1.0, 16.0).reshape(5, 3) ** 1.7, np.array([np.diag([x, x, x]) for x in range(1, 6)]) * 0.1
    first = small_set("first", mass, com, tensor)
    others = [small_set(name, mass * [1, 1, 1, *rest], 3.3 * com + 1.0, (tensor + 0.033) * np.pi)
              for name, rest in (("near", (1, 1.4)), ("far", (1.4, 1)))]  # fmt: skip
    found = trace_origin(first.links, [others[0], first, others[1]])
    assert [x.elsewhere for x in found.kinds] == [("near:y",), (), ()]
    assert (found.known.name, found.is_copy, found.kinds[2].digits) == ("first:y", True, 5.0)
    few = trace_origin(first.links, [first, small_set("same tensors", 3.3 * mass, 3.3 * com + 1.0, tensor)])
    assert few.kinds[2].elsewhere == ()
    assert [replace(found, digits=8.0, pairs=((0, 0),) * n).is_copy for n in (1, 2)] == [False, True]
    assert not replace(found, digits=7.99).is_copy


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
