"""A share of the faults in public arms, drawn by seed, is found; no false error. All of them: soak.py linter."""

import xml.etree.ElementTree as ET
from collections import Counter

import pytest

from tests.checks.urdf.detection import alarms, findings_of, judge_plant, verdicts
from tests.checks.urdf.fault_plants import fault_kinds, plants
from tests.checks.urdf.judged_arms import arm_rows, judged_arms

ARMS = {arm.name: arm for arm in judged_arms()}
PLANTED = ("xarm7", "z1")
"""Of example-robot-data, which the tests install."""
SHARE = 0.04
LEAST_LARGE, LEAST_ALL = 0.95, 0.8
"""Share found at least, by an error or a warning; over all arms: scripts/soak.py linter."""


def arm_of(name):
    if ARMS[name].path is None:
        pytest.skip("example-robot-data is not installed")
    return ARMS[name]


@pytest.mark.slow
def test_faults_are_found_where_they_are():
    """Of all kinds, and nearly all above their floors."""
    found = [verdict for name in PLANTED for verdict in verdicts(arm_of(name), fault_kinds(), SHARE, seed=1)]
    large = [v for v in found if v.large]
    missed = Counter(v.kind for v in large if not v.seen("warning"))
    assert len(large) > 30
    assert 1 - sum(missed.values()) / len(large) >= LEAST_LARGE, missed
    assert sum(v.seen("warning") for v in found) / len(found) >= LEAST_ALL


@pytest.mark.slow
def test_every_large_fault_of_one_link_is_found():
    arm = arm_of("xarm7")
    text = arm.text()
    before = findings_of(text, arm.path)
    planted = plants(text, arm.path, fault_kinds(), wanted=lambda link, kind: link == "link4")
    judged = [judge_plant(arm.name, plant, before, arm.path) for plant in planted]
    assert len(judged) > 60
    assert [v.kind for v in judged if v.large and not v.seen("warning")] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, arm in ARMS.items() if arm.source.startswith("example-robot-data")])
def test_a_good_link_raises_no_error(name):
    arm = ARMS[name]
    if not arm.is_as_judged:
        pytest.skip(f"{arm.file} of {arm.source} is not installed")
    assert [alarm for alarm in alarms(arm) if alarm.level == "error"] == []


@pytest.mark.slow
def test_a_planted_fault_changes_one_link_or_joint():
    arm = arm_of("z1")
    before = ET.fromstring(arm.text())
    planted = list(plants(arm.text(), arm.path, fault_kinds(), wanted=lambda link, kind: link in ("link02", "link05")))
    kinds = fault_kinds()
    assert len({kind.name for kind in kinds}) == len(kinds) == 73
    assert {kind.name for kind in kinds} - {plant.kind.name for plant in planted} == {
        "inertial rpy in degrees", "inertial rpy sign", "joint rpy in degrees", "quaternion as rpy", "travel in cm",
    }  # its angles are 0, and nothing slides  # fmt: skip
    for plant in planted[::3]:
        after = ET.fromstring(plant.text)
        changed = [x for x, y in zip(before, after, strict=False) if ET.tostring(x) != ET.tostring(y)]
        assert len(changed) + len(after) - len(before) == 1, plant.kind.name


def test_the_parts_of_the_arms_share_no_maker():
    rows = arm_rows()
    parts = ("tuning", "unused", "fresh", "latest", "newest")
    makers = {part: {row["maker"] for row in rows if row["half"] == part} for part in parts}
    assert len(rows) >= 40
    assert len(set().union(*makers.values())) == sum(map(len, makers.values()))
    for part in parts[1:]:
        good = [row for row in rows if row["half"] == part and row["judgement"] == "good"]
        left_out = sum(len(row.get("faults", {})) + len(row.get("without_shapes", [])) for row in good)
        assert sum(row["moving"] for row in good) - left_out >= 100
    assert len(makers["fresh"]) >= 8
    assert {row["judgement"] for row in rows} == {"good", "faulty"}
    assert all(len(row["sha256"]) == 64 and row["why"] for row in rows)
