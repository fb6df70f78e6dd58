"""Pages with numbers that scripts make: each has those of its file, and a seeded share comes out again."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.inertia.certificate import inertia_certificate
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.studies.compare.plants import plant_case
from lwr_dyn.studies.compare.study import ControllerStudy, tuned_frequencies
from lwr_dyn.trajectory.references.ist import Twice

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import certified_inertia
import ranking
import robots_against_reality as reality


@pytest.fixture(scope="module")
def ranks():
    return json.loads(ranking.NUMBERS.read_text("utf-8"))


@pytest.mark.slow
def test_the_tables_of_robots_against_reality_are_fresh():
    """Those that need no log from elsewhere."""
    page = reality.PAGE.read_text("utf-8")
    found = {"shipped": reality.shipped(), "copies": reality.copies(), "panda-b": reality.ranked("panda-b")}
    assert "panda:gaz" in found["shipped"]
    assert "`ur10e:maker` | tensors | `ur10:maker`" in found["copies"]
    assert reality.with_tables(page, found) == page


PROVEN, QUICK = 8, 0.5
"""Rows that are proven again, of those that took fewer seconds than `QUICK`; all: scripts/certified_inertia.py."""
BOXES = 0.05
"""Relative: boxes at the threshold go either way with the rounding of another machine."""
ROWS = certified_inertia.rows(certified_inertia.PAGE.read_text("utf-8"))
QUICK_ROWS = [row for row in ROWS if float(row[9]) < QUICK]


def test_every_joint_stands_on_the_page_of_certified_inertias_with_gaps_as_asked():
    named = [(arm.name, arm.reading, joint) for arm in certified_inertia.arms() for joint in arm.joint_names]
    assert [tuple(row[:3]) for row in ROWS] == named
    for row in ROWS:
        assert float(row[4]) <= 1e-6
        assert float(row[7]) <= 1e-9
        assert float(row[10]) < 1e-11
    assert max(float(row[6]) for row in ROWS) < 10.0


@pytest.mark.slow
@pytest.mark.parametrize("place", np.random.default_rng(27).choice(len(QUICK_ROWS), PROVEN, replace=False))
def test_a_share_of_the_certificates_is_proven_again(place):
    robot, reading, joint, value, *numbers, rounding = QUICK_ROWS[place]
    arm = lwr_dyn.load(robot, reading=reading)
    maximum = worst_case_inertias(arm)[arm.joint_names.index(joint)]
    assert f"{maximum.value:.9g}" == value
    for gap, (shown, boxes, _) in zip(certified_inertia.GAPS, (numbers[:3], numbers[3:]), strict=True):
        proven = inertia_certificate(arm, maximum, gap)
        assert proven.holds
        assert proven.gap == pytest.approx(float(shown), rel=0.2, abs=1e-12)
        assert abs(proven.boxes - int(boxes)) <= BOXES * int(boxes)
    assert proven.allowance / maximum.value == pytest.approx(float(rounding), rel=1.0)


PAIRS = 2
"""Pairs of a move that are simulated again; all of them: scripts/ranking.py."""
TIP_AGAIN = 1e-4
"""Relative, of an error of the tip: rounding of another machine, through friction that sticks."""


def study_of(ranks, study, controllers, plants):
    """The study with some of its controllers, and the gains that it had; its reference is followed twice."""
    arm = arm_with_friction(lwr_dyn.load("lwr4plus", reading=study.partition("-")[2]), 0.01)
    start, end = (np.radians([float(x) for x in ranking.MOVE[i].split(",")]) for i in (1, 3))
    once = lwr_dyn.reference("point-to-point", arm, start=start, end=end, duration=float(ranking.MOVE[5]))
    tuned = {name: {"omega_n": x["omega_n"]} for name, x in ranks[study]["tuned"].items()}
    reference = Twice(once)
    cases = [plant_case(arm, text) for text in plants]
    return ControllerStudy(arm, reference, controllers, cases, since=reference.second, tuned=tuned)


def test_the_page_of_the_ranking_has_the_numbers_of_its_file(ranks):
    page = ranking.PAGE.read_text("utf-8")
    assert ranking.filled(page, ranks) == page
    assert set(ranks) == set(ranking.STUDIES)


def test_each_study_of_the_ranking_has_every_pair_or_says_why_not(ranks):
    for study, record in ranks.items():
        assert record["command"] == f"lwr-dyn {ranking.shlex.join(ranking.command(study))}"
        assert re.fullmatch(r"[0-9a-f]{40}", record["commit"])
        pairs = [(run["typed"], run["plant"]) for run in record["runs"]]
        assert len(set(pairs)) == len(pairs)
        made = {typed for typed, _ in pairs}
        absent = [one for one in ranking.controllers(study.partition("-")[2]) if one not in made]
        assert all(any(why.startswith(f"{one}: ") for why in record["failures"]) for one in absent)
        refused = len(record["failures"]) - len(absent)
        assert len(pairs) + refused == len(made) * len(ranking.PLANTS_OF[study.partition("-")[0]])


@pytest.mark.slow
@pytest.mark.parametrize("reading", ranking.READINGS)
def test_a_seeded_share_of_the_ranking_comes_out_again(reading, ranks):
    study = f"move-{reading}"
    stable = [run for run in ranks[study]["runs"] if not run["unstable"]]
    words = {", ".join(text_words(text, reading)): text for text in ranking.PLANTS if "friction" not in text}
    rows = [run for run in stable if run["plant"] in words]
    for i in np.random.default_rng(26).choice(len(rows), PAIRS, replace=False):
        run = rows[i]
        compared, _ = study_of(ranks, study, [run["typed"]], [words[run["plant"]]]).run()
        (again,) = compared.record()["runs"]
        for figure in ("tip_rms_mm", "tip_max_mm", "peak_torque"):
            assert again[figure] == pytest.approx(run[figure], rel=TIP_AGAIN), (run["typed"], run["plant"], figure)


def text_words(text, reading):
    """What a comparison says of the plant, where the plant's words say all of it."""
    case = plant_case(lwr_dyn.load("lwr4plus", reading=reading), text)
    load = case.options.get("payload")
    return [*case.words, *([f"{load:g} kg at the flange"] if load else [])] or ["as modelled"]


@pytest.mark.slow
def test_a_gain_comes_out_again(ranks):
    chosen = study_of(ranks, "move-physical", ["inverse-dynamics"], ["nominal"])
    found = tuned_frequencies(chosen.arm, chosen.specs, chosen.reference, ranking.PEAK)["inverse-dynamics"]
    recorded = ranks["move-physical"]["tuned"]["inverse-dynamics"]
    assert found.omega_n == pytest.approx(recorded["omega_n"], rel=1e-9)
    assert found.case.words == recorded["case"]
